//! Modules import each other in one direction: what a module needs can be read without what needs it.
//!
//! In every folder of every crate, a module and its siblings form a graph: `a` points to `b` where a file of `a` names something
//! in `b`. None of these graphs has a cycle. A module and the modules in it are one unit here.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Crates that are looked at.
const CRATES: [&str; 15] = [
    "filesystem",
    "recording",
    "lockstep",
    "processes",
    "formation",
    "plant",
    "hardware",
    "high_level_planner",
    "observer",
    "low_level_ctrl",
    "schemes",
    "programs",
    "orchestrator",
    "thesis",
    "phalanx",
];

/// Modules that are one unit in several files, with the reason.
const UNITS: [(&str, &[&str], &str); 1] = [(
    "formation::config",
    &["access", "read", "reader", "stand_in"],
    "a deserializer: the reader of a value gives its fields to an access, which reads each with a reader",
)];

/// Files of a folder, those of folders in it, too.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.push(path);
        }
    }
    files
}

/// The module that a file is: `["run", "control"]` for `run/control/mod.rs`.
fn module_of(root: &Path, file: &Path) -> Vec<String> {
    let inner = file.strip_prefix(root).expect("a file of the crate").with_extension("");
    let mut names: Vec<String> = inner.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if matches!(names.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        names.pop();
    }
    names
}

/// The code of a file, without its comments and its tests.
fn code(text: &str) -> String {
    let before_tests = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = before_tests.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// All paths that begin with `crate::` or `super::`, as modules from the root of the crate; `use` lists are spread.
fn paths(code: &str, module: &[String]) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for start in ["crate::", "super::"] {
        for (place, _) in code.match_indices(start) {
            let before = code[..place].chars().next_back();
            if before.is_some_and(|letter| letter.is_alphanumeric() || letter == '_' || letter == ':' || letter == '$')
            {
                continue;
            }
            let mut base =
                if start == "crate::" { Vec::new() } else { module[..module.len().saturating_sub(1)].to_vec() };
            let mut rest = &code[place + start.len()..];
            while let Some(further) = rest.strip_prefix("super::") {
                base.pop();
                rest = further;
            }
            spread(rest, base, &mut found);
        }
    }
    found
}

/// The paths that begin here: names between `::`, or a list in braces.
fn spread(text: &str, base: Vec<String>, found: &mut Vec<Vec<String>>) {
    if let Some(list) = text.strip_prefix('{') {
        let mut depth = 0;
        let mut item = String::new();
        for letter in list.chars() {
            match letter {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    spread(item.trim(), base.clone(), found);
                    item.clear();
                    continue;
                }
                _ => {}
            }
            item.push(letter);
        }
        spread(item.trim(), base, found);
        return;
    }
    let name: String = text.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect();
    let mut path = base;
    let rest = &text[name.len()..];
    path.push(name);
    match rest.strip_prefix("::") {
        Some(further) => spread(further, path, found),
        None => found.push(path),
    }
}

/// What points to what among the children of every module.
fn graphs(root: &Path) -> BTreeMap<Vec<String>, BTreeMap<String, BTreeSet<String>>> {
    let files: Vec<(Vec<String>, String)> = sources(root)
        .into_iter()
        .map(|file| (module_of(root, &file), code(&fs::read_to_string(&file).expect("a source file"))))
        .filter(|(module, _)| !module.iter().any(|name| name == "tests"))
        .collect();
    let modules: BTreeSet<&[String]> = files.iter().map(|(module, _)| module.as_slice()).collect();
    let mut graphs: BTreeMap<Vec<String>, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (module, code) in &files {
        for path in paths(code, module) {
            // Where both leave their common parent.
            let common = module.iter().zip(&path).take_while(|(own, other)| own == other).count();
            let (Some(own), Some(other)) = (module.get(common), path.get(common)) else { continue };
            let target: Vec<String> = path[..=common].to_vec();
            if modules.contains(target.as_slice()) {
                let graph = graphs.entry(path[..common].to_vec()).or_default();
                graph.entry(own.clone()).or_default().insert(other.clone());
            }
        }
    }
    graphs
}

/// The graph with several modules as one, which has the name of the first.
fn united(graph: BTreeMap<String, BTreeSet<String>>, names: &[&str]) -> BTreeMap<String, BTreeSet<String>> {
    let name = |name: String| if names.contains(&name.as_str()) { names[0].to_string() } else { name };
    let mut result: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (from, targets) in graph {
        let from = name(from);
        let targets = targets.into_iter().map(name).filter(|target| *target != from).collect::<Vec<_>>();
        result.entry(from).or_default().extend(targets);
    }
    result
}

/// A cycle of the graph, if there is one.
fn cycle(graph: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    fn visit(
        graph: &BTreeMap<String, BTreeSet<String>>,
        name: &str,
        trail: &mut Vec<String>,
        done: &mut BTreeSet<String>,
    ) -> Option<Vec<String>> {
        if let Some(start) = trail.iter().position(|earlier| earlier == name) {
            return Some(trail[start..].to_vec());
        }
        if done.contains(name) {
            return None;
        }
        trail.push(name.into());
        let found = graph.get(name).into_iter().flatten().find_map(|next| visit(graph, next, trail, done));
        trail.pop();
        done.insert(name.into());
        found
    }
    let mut done = BTreeSet::new();
    graph.keys().find_map(|name| visit(graph, name, &mut Vec::new(), &mut done))
}

#[test]
fn no_modules_import_each_other_in_a_circle() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    let mut edges = 0;
    for name in CRATES {
        for (parent, graph) in graphs(&top.join(name).join("src")) {
            edges += graph.values().map(BTreeSet::len).sum::<usize>();
            let place = [&[name.to_string()][..], &parent].concat().join("::");
            let units = UNITS.iter().filter(|(folder, ..)| *folder == place);
            let graph = units.fold(graph, |graph, (_, names, _)| united(graph, names));
            if let Some(cycle) = cycle(&graph) {
                found.push(format!("{place}: {} -> {}", cycle.join(" -> "), cycle[0]));
            }
        }
    }
    assert!(edges > 300, "only {edges} imports were found");
    assert!(found.is_empty(), "imports in a circle:\n{}", found.join("\n"));
}

#[test]
fn paths_and_circles_are_found() {
    let module = ["run".to_string(), "control".to_string()];
    let text = "use crate::log::{Log, place::{follow, Name}};\nuse super::swap::Swap;\nlet x = crate::files::write(a);\nsuper::super::judge::a();";
    let found: Vec<String> = paths(text, &module).iter().map(|path| path.join("::")).collect();
    assert_eq!(
        found,
        ["log::Log", "log::place::follow", "log::place::Name", "files::write", "run::swap::Swap", "judge::a"]
    );
    let graph = |edges: &[(&str, &str)]| {
        let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (from, to) in edges {
            graph.entry(from.to_string()).or_default().insert(to.to_string());
        }
        cycle(&graph)
    };
    assert_eq!(graph(&[("a", "b"), ("b", "c"), ("a", "c")]), None);
    assert_eq!(graph(&[("a", "b"), ("b", "c"), ("c", "b")]), Some(vec!["b".into(), "c".into()]));
}
