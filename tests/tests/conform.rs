//! The contract kit on a program that keeps the contract, and on one that breaks it in many ways.

use std::process::{Command, Output, Stdio};

use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_trial");

/// Tries the controller with a fault; exit code and report.
fn conform(fault: &str, more: &[&str]) -> (Option<i32>, Value) {
    let mut command = Command::new(PROGRAM);
    command.args(["conform", "controller.3", "--scenario", "uav", "--steps", "100", "--json"]).args(more);
    command.args(["--", PROGRAM, "misbehave", fault]).stdin(Stdio::null());
    let Output { status, stdout, stderr } = command.output().expect("the program starts");
    let report = serde_json::from_slice(&stdout);
    let report = report.unwrap_or_else(|error| panic!("{fault}: {error}\n{}", String::from_utf8_lossy(&stderr)));
    (status.code(), report)
}

/// The names of the points with this verdict.
fn points(report: &Value, verdict: &str) -> Vec<String> {
    let points = report["points"].as_array().expect("points").iter();
    let chosen = points.filter(|point| point["verdict"] == verdict);
    chosen.map(|point| point["name"].as_str().expect("a name").to_string()).collect()
}

#[test]
fn a_good_program_conforms() {
    let (code, report) = conform("nothing", &["--range", "input=-1000..1000"]);
    assert_eq!((code, &report["ok"]), (Some(0), &Value::Bool(true)), "{report:#}");
    assert_eq!(points(&report, "pass").len(), 14, "{report:#}");
    assert_eq!(points(&report, "note"), ["reference", "speed"]);
    let reference = report["points"].as_array().expect("points").iter().find(|point| point["name"] == "reference");
    let finding = reference.expect("a point")["finding"].as_str().expect("text").to_string();
    assert!(finding.starts_with("all 1900 numbers are those that were recorded"), "{finding}");
}

/// The fault, what shows it, and options.
const FAULTS: &[(&str, &str, &[&str])] = &[
    ("silent-alone", "alone", &[]),
    ("any-plan", "plan", &[]),
    ("any-signals", "signals", &[]),
    ("no-start", "start", &["--patience", "5"]),
    ("exits", "steps", &[]),
    ("aborts", "steps", &[]),
    ("hangs", "steps", &["--patience", "5"]),
    ("nan", "steps", &[]),
    ("stops-writing", "steps", &[]),
    ("nothing", "ranges", &["--range", "input=-1..1"]),
    // Its writes into the samples of others break their seals, which ends the trial in the step.
    ("scribbles", "steps", &[]),
    ("deaf", "end", &["--patience", "5"]),
    ("deaf", "stop", &["--patience", "5"]),
    ("other-code", "end", &[]),
    ("leaves-a-child", "left", &[]),
    ("chatters", "output", &[]),
    ("random", "repeat", &[]),
    ("brittle", "absurd", &["--patience", "5"]),
];

/// What is wrong if the kit does not find the fault.
fn missed(&(fault, point, more): &(&str, &str, &[&str])) -> Option<String> {
    let (code, report) = conform(fault, more);
    let found = points(&report, "fail");
    let failed = report["points"].as_array().expect("points").iter().filter(|found| found["verdict"] == "fail");
    let advised = failed.into_iter().all(|found| found["advice"] != "");
    let caught = code == Some(1) && advised && found.iter().any(|name| name == point);
    (!caught).then(|| format!("{fault}: {point} is not among {found:?}\n{report:#}"))
}

#[test]
fn planted_faults_are_caught() {
    // Some at a time: most of them wait.
    let missed: Vec<String> = FAULTS
        .chunks(5)
        .flat_map(|faults| {
            std::thread::scope(|scope| {
                let trials: Vec<_> = faults.iter().map(|fault| scope.spawn(|| missed(fault))).collect();
                trials.into_iter().filter_map(|trial| trial.join().expect("a trial")).collect::<Vec<_>>()
            })
        })
        .collect();
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn a_program_that_is_not_there_is_said_to_be_missing() {
    let output = Command::new(PROGRAM).args(["conform", "plant", "--", "./no_such_program"]).output().expect("a start");
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("there is no program ./no_such_program"), "{stderr}");
}
