//! The commands that pages of the book print are run as they are printed.

use std::process::Command;

use crate::program::Folder;

/// The contents of the blocks of this language in a document.
fn blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    let start = format!("\n```{language}\n");
    text.split(&start).skip(1).map(|rest| rest.split("\n```").next().unwrap_or_default()).collect()
}

fn page(name: &str) -> String {
    let path = format!("{}/../docs/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Runs all commands of a page, one by one, in a folder.
fn run_commands(text: &str, folder: &Folder) -> usize {
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_phalanx"));
    let programs = program.parent().expect("the folder of the program").display().to_string();
    let path = format!("{programs}:{}", std::env::var("PATH").unwrap_or_default());
    let commands: Vec<&str> = blocks(text, "sh").into_iter().flat_map(str::lines).collect();
    for command in &commands {
        let output =
            Command::new("bash").args(["-c", command]).current_dir(folder.path(".")).env("PATH", &path).output();
        let output = output.expect("bash");
        assert!(output.status.success(), "{command}\n{}", String::from_utf8_lossy(&output.stderr));
    }
    commands.len()
}

fn assert_files(folder: &Folder, files: &[&str]) {
    for file in files {
        assert!(folder.path(file).is_file(), "{file}");
    }
}

#[test]
fn the_tutorial_works_as_it_is_written() {
    let text = page("tutorial.md");
    let scenario = blocks(&text, "toml");
    assert_eq!(scenario.len(), 1);
    let folder = Folder::new();
    folder.write("triangle.toml", scenario[0]);
    assert!(run_commands(&text, &folder) > 10);
    let files = ["runs/first.html", "comparison.html", "runs/triangle.html", "scenario.schema.json", "again.mcap"];
    assert_files(&folder, &files);
}

#[test]
fn the_examples_for_users_of_other_tools_work_as_they_are_written() {
    let folder = Folder::new();
    assert_eq!(run_commands(&page("coming-from.md"), &folder), 4);
    assert_files(&folder, &["runs/triangle.mcap", "runs/stiff.mcap", "gains.html", "runs/stiff.mat"]);
}
