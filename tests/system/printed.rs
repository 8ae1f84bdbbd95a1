//! Every program that the documentation prints runs to a good end, as printed, on the scenario that it is printed with; and so
//! does what `phalanx new` writes without options.

use std::path::Path;

use crate::own_programs::{compile, library_folder, python, root};
use crate::program::{Finished, Folder};
use crate::scaffold::build;

/// The command that stands below each of these programs, up to the program.
const PRINTED: &str = "phalanx run triangle --swap ";

/// The code blocks of a page in this language that are whole programs.
fn programs(page: &str, language: &str, whole: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join(page)).expect("a page");
    assert!(text.contains(PRINTED), "{page} prints no `{PRINTED}...`");
    let blocks = text.split("\n```").skip(1).step_by(2);
    let programs = blocks.filter_map(|block| block.split_once('\n').filter(|(head, _)| head.starts_with(language)));
    let found: Vec<String> =
        programs.map(|(_, code)| format!("{code}\n")).filter(|code| code.contains(whole)).collect();
    assert!(!found.is_empty(), "{page} has no program in {language}");
    found
}

/// The environment in which a Python program finds the package and the library.
fn with_package(command: &mut std::process::Command) {
    command.env("PYTHONPATH", root().join("python/src"));
    command.env("PHALANX_LIBRARY", library_folder().join("libphalanx.so"));
}

/// Runs `triangle` with the program as one controller, and then as all three. Both runs have to be complete, and every assertion of the
/// scenario has to hold.
fn flies(folder: &Folder, command: &str) {
    for controllers in [&["controller.3"][..], &["controller.1", "controller.2", "controller.3"]] {
        let mut run = folder.phalanx(&["run", "triangle", "-q", "--json"]);
        for one in controllers {
            run.args(["--swap", &format!("{one}={command}")]);
        }
        with_package(&mut run);
        let run = Finished(run.output().expect("the program starts"));
        assert_eq!(run.code(), 0, "{command}: {}{}", run.stdout(), run.stderr());
        let result = run.json();
        assert_eq!((&result["ending"], &result["ok"]), (&"complete".into(), &true.into()), "{result}");
        let assertions = result["assertions"].as_array().expect("assertions");
        assert!(assertions.iter().all(|one| one["ok"] == true && one["reached"] == true), "{result}");
    }
}

/// A project of `phalanx new` for a controller, without further options.
fn new_controller(folder: &Folder, language: &str) {
    let new = folder.run(&["new", "controller", "my_controller", "--lang", language]);
    assert_eq!(new.code(), 0, "{}", new.stderr());
}

#[test]
#[cfg_attr(not(feature = "long-tests"), ignore = "long; --features long-tests runs it")]
fn programs_in_rust_fly() {
    let folder = Folder::new();
    new_controller(&folder, "rust");
    let project = folder.path("my_controller");
    let built = Path::new(env!("CARGO_BIN_EXE_phalanx")).with_file_name("my_controller");
    build(&project);
    flies(&folder, built.to_str().expect("a path"));
    let pages = ["README.md", "docs/adding-a-controller.md"];
    let mut texts: Vec<String> = pages.iter().flat_map(|page| programs(page, "rust", "fn main()")).collect();
    // A program that both pages print needs no second build.
    texts.dedup();
    for text in texts.iter().filter(|text| !text.contains("Catalog")) {
        folder.write("my_controller/src/main.rs", text);
        build(&project);
        flies(&folder, built.to_str().expect("a path"));
    }
}

#[test]
fn programs_in_cpp_fly() {
    let folder = Folder::new();
    new_controller(&folder, "cpp");
    let template = folder.path("my_controller/main.cpp");
    flies(&folder, &compile(&folder, template.to_str().expect("a path"), "template"));
    for (number, text) in programs("docs/adding-a-controller.md", "cpp", "int main()").iter().enumerate() {
        let source = format!("printed-{number}.cpp");
        folder.write(&source, text);
        let source = folder.path(&source);
        flies(&folder, &compile(&folder, source.to_str().expect("a path"), &format!("printed-{number}")));
    }
}

#[test]
fn programs_in_python_fly() {
    let Some(python) = python() else { return };
    let folder = Folder::new();
    new_controller(&folder, "python");
    flies(&folder, &format!("{python} my_controller/main.py"));
    for page in ["docs/adding-a-controller.md", "python/README.md"] {
        for text in programs(page, "python", "phalanx.Participant()") {
            folder.write("my_controller.py", &text);
            flies(&folder, &format!("{python} my_controller.py"));
        }
    }
}

#[test]
fn the_example_in_c_hovers() {
    let folder = Folder::new();
    let example = "examples/controller-c/controller.c";
    let printed = "phalanx run uav --variant apart --duration 30 --swap controller.3=./hover";
    assert!(std::fs::read_to_string(root().join(example)).expect("the example").contains(printed));
    compile(&folder, example, "hover");
    let arguments: Vec<&str> = printed.split(' ').skip(1).chain(["-q", "--json"]).collect();
    let run = folder.run(&arguments);
    assert_eq!((run.code(), &run.json()["ending"]), (0, &"complete".into()), "{}{}", run.stdout(), run.stderr());
    let assertions = run.json()["assertions"].clone();
    assert!(assertions.as_array().expect("assertions").iter().all(|one| one["ok"] == true), "{assertions}");
}
