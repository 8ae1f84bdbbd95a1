//! The program from outside, in an empty folder: its scenario, its metrics, its ranges, its mistakes.

use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;

/// A folder of its own, removed when the test is over.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("own-catalog-{name}-{}", std::process::id()));
        std::fs::create_dir(&path).expect("a folder");
        Self(path)
    }

    /// Runs the program with these arguments.
    fn run(&self, arguments: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_own-catalog"));
        command.args(arguments.split(' ')).current_dir(&self.0).output().expect("the program starts")
    }

    /// What it prints if it succeeds.
    fn out(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let (out, error) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "{arguments}: {}\n{out}\n{error}", output.status);
        out.into()
    }

    /// The last line of that, as JSON.
    fn json(&self, arguments: &str) -> Value {
        let out = self.out(arguments);
        serde_json::from_str(out.lines().last().unwrap_or_default()).unwrap_or_else(|error| panic!("{error}: {out}"))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn it_lists_describes_and_validates_what_it_brings_along() {
    let folder = Folder::new("list");
    let list = folder.out("list");
    assert!(list.contains("four carts whose tips turn on a circle (4 agents)"), "{list}");
    assert!(list.contains("variants: road, mud") && list.contains("`own-catalog run NAME`"), "{list}");
    let components = folder.out("list --components");
    assert!(components.contains("carts on two driven wheels") && components.contains("consensus of the tips"));
    let schema = folder.out("schema");
    assert!(schema.contains("\"tip_consensus\"") && schema.contains("From the axle to the tip"));
    folder.out("validate carousel --variant mud");
}

#[test]
fn a_run_has_the_metrics_and_the_same_bits_however_it_is_placed() {
    let folder = Folder::new("run");
    for placement in ["single", "processes"] {
        let result = folder.json(&format!("run carousel -q --placement {placement} --json --out {placement}.mcap"));
        let metrics = result["metrics"].as_object().expect("metrics");
        for name in ["miss", "t_there", "max_force"] {
            assert_eq!(metrics[name]["in_range"], true, "{placement}: {name}: {metrics:?}");
        }
    }
    folder.out("verify single.mcap processes.mcap");
    folder.out("check single.mcap");
    folder.out("report single.mcap");
    let page = std::fs::read_to_string(folder.0.join("single.html")).expect("the report");
    assert!(page.contains("four carts whose tips turn on a circle"));
}

#[test]
fn a_campaign_meets_all_ranges_and_claims() {
    let folder = Folder::new("campaign");
    let text = folder.out("campaign");
    assert!(text.contains("Regression: 4 of 4 values in range.") && text.contains("Claims: 1 of 1 hold."), "{text}");
    assert!(!text.contains("thesis"), "{text}");
}

#[test]
fn mistakes_in_a_scenario_are_located_and_the_components_of_this_program_are_named() {
    let folder = Folder::new("mistakes");
    let scenario = include_str!("../scenarios/carousel.toml");
    let mistakes = [
        ("kind = \"tip_consensus\"", "kind = \"tip_consensu\"", "did you mean `tip_consensus`?"),
        ("kind = \"carts\"", "kind = \"cart\"", "did you mean `carts`?"),
        ("l = 0.4 ", "l = -0.4 ", "expected a number > 0, found -0.4"),
        ("d = 0.05", "drag = 0.05", "drag"),
    ];
    for (right, wrong, words) in mistakes {
        assert_eq!(scenario.matches(right).count(), 1, "{right}");
        let line = 1 + scenario.lines().position(|line| line.contains(right)).expect("the line");
        std::fs::write(folder.0.join("wrong.toml"), scenario.replace(right, wrong)).expect("a scenario");
        let output = folder.run("run wrong.toml");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(&format!("wrong.toml:{line}:")) && error.contains(words), "{wrong}: {error}");
    }
    let error = folder.run("run carusel");
    let error = String::from_utf8_lossy(&error.stderr);
    assert!(error.contains("did you mean `carousel`?") && error.contains("`own-catalog list` shows all"), "{error}");
}
