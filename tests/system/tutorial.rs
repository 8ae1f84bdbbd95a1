//! The commands of the tutorial are run as they stand there.

use std::process::Command;

use crate::program::Folder;

/// The contents of the blocks of this language in a document.
fn blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    let start = format!("\n```{language}\n");
    text.split(&start).skip(1).map(|rest| rest.split("\n```").next().unwrap_or_default()).collect()
}

#[test]
fn the_tutorial_works_as_it_is_written() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/tutorial.md");
    let text = std::fs::read_to_string(path).expect("the tutorial");
    let scenario = blocks(&text, "toml");
    assert_eq!(scenario.len(), 1);
    let folder = Folder::new();
    folder.write("triangle.toml", scenario[0]);
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_phalanx"));
    let programs = program.parent().expect("the folder of the program").display().to_string();
    let path = format!("{programs}:{}", std::env::var("PATH").unwrap_or_default());
    let commands: Vec<&str> = blocks(&text, "sh").into_iter().flat_map(str::lines).collect();
    assert!(commands.len() > 10, "{commands:?}");
    for command in commands {
        let output =
            Command::new("bash").args(["-c", command]).current_dir(folder.path(".")).env("PATH", &path).output();
        let output = output.expect("bash");
        assert!(output.status.success(), "{command}\n{}", String::from_utf8_lossy(&output.stderr));
    }
    for file in ["runs/first.html", "comparison.html", "runs/triangle.html", "scenario.schema.json", "again.mcap"] {
        assert!(folder.path(file).is_file(), "{file}");
    }
}
