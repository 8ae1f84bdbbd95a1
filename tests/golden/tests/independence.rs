//! What laws are built from depends neither on the operating system nor on what runs processes.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Every package between the contract and the golden values.
const PACKAGES: [&str; 8] =
    ["lockstep", "formation", "plant", "high_level_planner", "observer", "low_level_ctrl", "schemes", "golden"];

/// What they, their tests included, must build without.
const BANNED: [&str; 3] = ["processes", "iceoryx2", "orchestrator"];

/// The names of all packages that `package` is built from, itself among them.
fn built_from(package: &str, edges: &str) -> Vec<String> {
    let cargo = option_env!("CARGO").unwrap_or("cargo");
    let words = ["tree", "--offline", "--package", package, "--edges", edges, "--prefix", "none", "--format", "{p}"];
    let output = Command::new(cargo).args(words).current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("cargo");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("names");
    text.lines().filter_map(|line| line.split(' ').next()).map(str::to_string).collect()
}

#[test]
fn laws_build_without_processes() {
    for package in PACKAGES {
        let packages = built_from(package, "normal,build,dev");
        assert!(packages.iter().any(|name| name == package), "{package}: {packages:?}");
        let found: Vec<_> = packages.iter().filter(|name| BANNED.contains(&name.as_str())).collect();
        assert!(found.is_empty(), "{package} is built from {found:?}; what needs processes belongs into `processes/`");
    }
}

#[test]
fn the_contract_is_for_any_system() {
    let packages = built_from("lockstep", "normal");
    for system in ["libc", "rustix", "nix", "windows-sys"] {
        assert!(packages.iter().all(|name| name != system), "lockstep is built from {system}");
    }
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../lockstep/src"));
    let mut files = 0;
    for entry in fs::read_dir(folder).expect("lockstep/src") {
        let path = entry.expect("an entry").path();
        let text = fs::read_to_string(&path).expect("lockstep/src has files only");
        for words in ["std::os", "target_os", "target_arch", "unsafe", "std::process", "std::env"] {
            assert!(!text.contains(words), "{}: {words}", path.display());
        }
        files += 1;
    }
    assert!(files > 5, "only {files} files");
}
