//! What a user does first: run, look, check, run again.

use crate::program::{Folder, children, wait_until};

/// The whole drone scenario, as the README starts it.
#[test]
fn the_drone_scenario_meets_its_bands_in_fifteen_processes() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uav", "--json", "-q"]);
    let json = run.json();
    assert_eq!(run.code(), 0, "{}", run.stderr());
    assert_eq!(json["ok"], true);
    assert_eq!(json["processes"], 15);
    assert_eq!(json["steps"], 8000);
    assert_eq!(json["scenario"], "uav");
    assert_eq!(json["variant"], "TSC");
    assert_eq!(json["metrics"]["dx_p"]["in_range"], true);
    let log = json["log"].as_str().expect("the path of the log");
    assert_eq!(log, "runs/uav-TSC.mcap");
    let check = folder.run(&["check", log]);
    assert_eq!(check.code(), 0, "{}", check.stdout());
    assert!(check.stdout().contains("Regression: all 30 values are in range"), "{}", check.stdout());
    let info = folder.run(&["info", log]);
    assert!(info.stdout().contains("/agent_6/command"), "{}", info.stdout());
    let scenario = folder.run(&["info", log, "--scenario"]).stdout();
    let again = folder.write("again.toml", &scenario);
    let again = folder.run(&["validate", again.to_str().expect("a path"), "--json"]).json();
    assert_eq!(again["steps"], 8000, "the scenario in the log is one that runs");
}

#[test]
fn the_same_bytes_whatever_the_placement() {
    let folder = Folder::new();
    let short = ["run", "uav", "--duration", "1.5", "-q", "--json"];
    let digest = |more: &[&str]| {
        let run = folder.run(&[&short[..], more].concat());
        run.json()["sha256"].as_str().unwrap_or_else(|| panic!("{}", run.stderr())).to_string()
    };
    let first = digest(&["--out", "a.mcap"]);
    assert_eq!(digest(&["--out", "b.mcap"]), first);
    assert_eq!(digest(&["--out", "c.mcap", "--placement", "single"]), first);
    assert_eq!(digest(&["--out", "d.mcap", "--placement", "agents"]), first);
    assert_eq!(digest(&["--out", "e.mcap", "--pin", "none"]), first);
    assert_eq!(digest(&["--out", "g.mcap", "--wake", "events"]), first);
    let [a, b, g] = ["a.mcap", "b.mcap", "g.mcap"].map(|name| std::fs::read(folder.path(name)).expect("a log"));
    assert!(a == b && a == g, "the files are equal, not only their digests");
    assert_ne!(digest(&["--out", "f.mcap", "--set", "phase=1e-9"]), first, "another scenario gives other bytes");
}

#[test]
fn every_participant_is_a_process() {
    let folder = Folder::new();
    let mut run = folder.start(&["run", "uav", "--duration", "4000", "--no-log", "-q"]);
    wait_until("all participants run", || children(run.id()).len() == 14);
    let pid = rustix::process::Pid::from_child(&run);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).expect("a running program");
    assert_eq!(run.wait().expect("an end").code(), Some(130));
}

#[test]
fn an_earlier_log_is_not_replaced_in_silence() {
    let folder = Folder::new();
    let short = ["run", "uav", "--duration", "0.1", "--placement", "single"];
    let first = folder.run(&short);
    assert!(!first.stderr().contains("replaces"), "{}", first.stderr());
    let second = folder.run(&short);
    assert!(second.stderr().contains("the log replaces that of an earlier run, runs/uav-TSC-"), "{}", second.stderr());
    let other = folder.run(&["run", "uav", "--duration", "0.2", "--placement", "single"]);
    assert!(!other.stderr().contains("replaces"), "other overrides, another log: {}", other.stderr());
    assert!(!folder.path("runs/uav-TSC.mcap").exists(), "the name of the scenario as it is stays free");
}

#[test]
fn a_run_with_overrides_is_not_held_against_the_thesis() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uav", "--duration", "0.1", "--placement", "single", "-q"]);
    assert_eq!(run.code(), 0);
    let said = "Not held against the thesis or the regression ranges: overridden: timing.duration=0.1.";
    assert!(run.stdout().contains(said) && !run.stdout().contains("not met"), "{}", run.stdout());
    let unchecked = folder.run(&["run", "uav", "--duration", "0.1", "--placement", "single", "-q", "--no-check"]);
    assert!(unchecked.code() == 0 && !unchecked.stdout().contains("x_til"), "{}", unchecked.stdout());
    assert!(unchecked.stdout().contains("assertions"), "they are still watched: {}", unchecked.stdout());
}

#[test]
fn what_is_violated_is_said_last() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uav", "--duration", "6", "--placement", "single", "-q", "--no-check"]);
    let last = run.stdout().trim_end().lines().last().unwrap_or_default().to_string();
    assert!(
        last.starts_with("warning: arms of two vehicles do not overlap: agent 3 at t = 4.7 s: gap = -0.008982"),
        "{last}"
    );
    let apart = folder.run(&[
        "run",
        "uav",
        "--variant",
        "apart",
        "--duration",
        "6",
        "--placement",
        "single",
        "-q",
        "--no-check",
    ]);
    assert!(!apart.stdout().contains("warning"), "{}", apart.stdout());
}

#[test]
fn lists_graphs_and_completions() {
    let folder = Folder::new();
    let list = folder.run(&["list", "--json"]).json();
    let names: Vec<_> = list.as_array().expect("a list").iter().map(|entry| entry["name"].clone()).collect();
    assert!(names.contains(&"uav".into()), "{names:?}");
    let graph = folder.run(&["graph", "uav"]).stdout();
    assert!(graph.contains("phase 2\n  controller_1\n    reads of this step: plant, planner, observer_1"), "{graph}");
    assert!(folder.run(&["graph", "uav", "--format", "dot"]).stdout().starts_with("digraph"));
    assert!(folder.run(&["graph", "uav", "--format", "mermaid"]).stdout().contains("controller_1 -.-> plant"));
    assert!(folder.run(&["completions", "bash"]).stdout().contains("phalanx"));
    let check = folder.run(&["check", "nothing.mcap"]);
    assert_eq!(check.code(), 4);
    assert!(check.stderr().contains("nothing.mcap"), "{}", check.stderr());
}

/// The binary of a role does what the program does in its place.
#[test]
fn a_swapped_participant_gives_the_same_log() {
    let folder = Folder::new();
    let short = ["run", "uav", "--duration", "1", "-q", "--json"];
    let own = format!("controller.3={} participant", env!("CARGO_BIN_EXE_phalanx"));
    folder.run(&[&short[..], &["--out", "a.mcap", "--swap", &own]].concat());
    folder.run(&[&short[..], &["--out", "b.mcap"]].concat());
    assert_eq!(folder.samples("a.mcap"), folder.samples("b.mcap"));
    let log = std::fs::read(folder.path("b.mcap")).expect("the log");
    let lost = ["--out", "b.mcap", "--swap", "controller.3=./no_such_program"];
    let missing = folder.run(&[&short[..], &lost].concat());
    assert_eq!(missing.code(), 2);
    assert!(missing.stderr().contains("controller_3: there is no program ./no_such_program"), "{}", missing.stderr());
    assert!(std::fs::read(folder.path("b.mcap")).expect("the log") == log, "a typing mistake costs no log");
}

/// The links among the chosen agents are what is left of the graph, strongly connected or not.
#[test]
fn some_of_the_agents_can_be_chosen() {
    let folder = Folder::new();
    let short = ["run", "uav", "--duration", "1", "-q", "--json", "--placement", "single"];
    let three = folder.run(&[&short[..], &["--set", "agents=[1,3,5]", "--out", "three.mcap"]].concat());
    assert!(three.json()["metrics"]["tvq_uav3"]["value"].is_number(), "{}", three.stderr());
    let again = folder.run(&["check", "three.mcap", "--json"]);
    assert_eq!(again.json()["metrics"]["tvq_uav3"], three.json()["metrics"]["tvq_uav3"]);
}
