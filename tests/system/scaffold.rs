//! Projects that `phalanx new` writes: they build, and keep the contract as they are.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::program::Folder;

/// Builds a project in Rust, with the packages that this program was built with.
pub(crate) fn build(project: &Path) {
    let target = Path::new(env!("CARGO_BIN_EXE_phalanx")).ancestors().nth(2).expect("the folder of all artefacts");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--release", "--offline"]).current_dir(project).stdin(Stdio::null());
    // The profile of this workspace, so that what is built already is used again.
    cargo.env("CARGO_TARGET_DIR", target).env("CARGO_PROFILE_RELEASE_DEBUG", "line-tables-only");
    let output = cargo.output().expect("cargo runs");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    assert!(!stderr.contains("warning: "), "{stderr}");
}

#[test]
#[cfg_attr(not(feature = "long-tests"), ignore = "long; --features long-tests runs it")]
fn a_new_project_in_rust_builds_and_conforms() {
    let folder = Folder::new();
    let target = Path::new(env!("CARGO_BIN_EXE_phalanx")).parent().expect("a folder");
    let cases = [
        ("controller", "uav", "controller.3"),
        ("observer", "cida", "observer_2"),
        ("planner", "uav", "planner"),
        ("plant", "uav", "plant"),
    ];
    for (role, scenario, node) in cases {
        let name = format!("trial_{role}");
        let new = folder.run(&["new", role, &name, "--lang", "rust", "--scenario", scenario]);
        assert_eq!(new.code(), 0, "{}", new.stderr());
        let told = if role == "controller" { "It has no law yet" } else { "It computes placeholders" };
        assert!(new.stdout().contains(told), "{}", new.stdout());
        build(&folder.path(&name));
        let program = target.join(&name);
        let program = program.to_str().expect("a path");
        let tried = folder.run(&["conform", node, "--scenario", scenario, "--steps", "50", "--", program]);
        assert_eq!(tried.code(), 0, "{role}\n{}{}", tried.stdout(), tried.stderr());
        assert!(tried.stdout().contains("note  reference"), "{}", tried.stdout());
    }
    let readme = std::fs::read_to_string(folder.path("trial_controller/README.md")).expect("a README");
    assert!(
        readme.contains("phalanx conform controller.1 --scenario uav -- ./target/release/trial_controller"),
        "{readme}"
    );
    assert!(readme.contains("| `position` of the plant | 6 | "), "{readme}");
}

#[test]
fn a_project_that_cannot_be_is_refused() {
    let folder = Folder::new();
    let refused = |arguments: &[&str], expected: &str| {
        let new = folder.run(&[&["new"], arguments].concat());
        assert!(new.code() == 2 && new.stderr().contains(expected), "{}", new.stderr());
    };
    refused(&["observer", "mine", "--lang", "rust", "--scenario", "rcaa"], "did you mean `rca`");
    refused(&["controller", "Mine", "--lang", "rust"], "a name consists of");
    refused(&["controller", "mine", "--lang", "rust", "--phalanx", "nowhere"], "is no checkout of Phalanx");
    std::fs::create_dir(folder.path("mine")).expect("a folder");
    refused(&["controller", "mine", "--lang", "rust"], "mine exists already");
}
