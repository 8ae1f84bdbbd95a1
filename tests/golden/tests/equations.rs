//! The tables of equations name files and items that exist.

use std::path::Path;

/// The text between backticks of a cell.
fn quoted(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

#[test]
fn every_equation_is_where_the_table_says() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let folder = root.join("docs/equations");
    let mut rows = 0;
    let mut wrong = Vec::new();
    for entry in std::fs::read_dir(&folder).expect("docs/equations") {
        let page = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&page).expect("a page");
        for line in text.lines().filter(|line| line.starts_with('|') && line.contains('`')) {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let [_, equation, _, files, names, ..] = cells[..] else { panic!("{}: {line}", page.display()) };
            for file in quoted(files) {
                let source = std::fs::read_to_string(root.join(file)).unwrap_or_default();
                let missing: Vec<&str> = quoted(names).into_iter().filter(|name| !source.contains(name)).collect();
                if source.is_empty() || !missing.is_empty() || quoted(names).is_empty() {
                    wrong.push(format!("{}: {equation}: {file} has no {missing:?}", page.display()));
                }
            }
            rows += 1;
        }
    }
    assert!(rows > 20, "only {rows} rows");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
