//! What untrusted input reaches: one function per kind of input. The fuzzer in `fuzz/` and an ordinary test call the same.
//!
//! Each takes any bytes. It fails if the program under test panics; what it returns is of no interest.

use std::fs;
use std::path::PathBuf;

use clap::Parser;
use formation::config::Problem;
use formation::scenario::Selection;
use formation::wiring::Assembly;
use lockstep::Plan;
use orchestrator::cli::Cli;
use orchestrator::judge::claims::Claims;
use orchestrator::run::swap::Swap;
use orchestrator::show::report;
use orchestrator::show::view::LoggedRun;
use recording::recover;
use schemes::{ROLES, SCENARIOS};

/// A kind of input: its name, and what it reaches.
pub type Target = (&'static str, fn(&[u8]));

/// All kinds.
pub const TARGETS: [Target; 4] = [("scenario", scenario), ("command", command), ("log", log), ("plan", plan)];

/// A scenario file: TOML, formulas, components, claims, assertions.
pub fn scenario(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Some(assembly) = load(text, Selection::default()) {
        // What is written into a log must load again, and say the same.
        let record = assembly.scenario.to_record();
        let again = load(&record, Selection::default()).expect("the record of a valid scenario is valid");
        assert_eq!(again.scenario.to_record(), record);
    }
}

/// A command line: a word per line; lines with `=` are overrides of a scenario, too.
pub fn command(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let words: Vec<&str> = text.lines().collect();
    if let Err(error) = Cli::try_parse_from(["phalanx"].iter().chain(&words)) {
        shown(&error);
    }
    for word in &words {
        let _ = Swap::parse(word, &["plant", "controller_1"]);
    }
    let variant = words.first().filter(|word| !word.contains('=')).map(ToString::to_string);
    let overrides = words.iter().filter(|word| word.contains('=')).take(8).map(ToString::to_string).collect();
    let uav = SCENARIOS.iter().find(|shipped| shipped.name == "uav").expect("a shipped scenario");
    load(uav.text, Selection { variant, overrides, ..Selection::default() });
}

/// A log: read, judged, shown, and recovered.
pub fn log(data: &[u8]) {
    let folder = Scratch::new("log");
    let (path, out) = (folder.0.join("a.mcap"), folder.0.join("b.mcap"));
    fs::write(&path, data).expect("a file");
    match LoggedRun::open(&thesis::catalog(schemes::ROLES, schemes::SCENARIOS), &path) {
        Ok(run) => {
            let _ = report::html(&[run]);
        }
        Err(failure) => shown(&failure),
    }
    if let Err(error) = recover(&path, &out) {
        shown(&error);
    }
}

/// The plan of a run.
pub fn plan(data: &[u8]) {
    let folder = Scratch::new("plan");
    fs::write(folder.0.join("plan.json"), data).expect("a file");
    match Plan::read(&folder.0) {
        Ok(plan) => {
            let _ = (0..plan.phase_count().min(64)).map(|phase| plan.members(phase).len()).sum::<usize>();
        }
        Err(error) => shown(&error),
    }
}

fn load(text: &str, selection: Selection) -> Option<Assembly> {
    let show = |problems: Vec<Problem>| problems.iter().for_each(|problem| shown(problem));
    let assembly = Assembly::load("hostile.toml", text, &selection, &ROLES).map_err(show).ok()?;
    orchestrator::judge::assertions::read(&assembly).map_err(show).ok()?;
    if let Err(problem) = Claims::read(&assembly.scenario) {
        shown(&problem);
    }
    Some(assembly)
}

/// An error must have words.
fn shown(error: &dyn std::fmt::Display) {
    assert!(!error.to_string().is_empty());
}

/// A folder that is removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(kind: &str) -> Self {
        let path = std::env::temp_dir().join(format!("phalanx-hostile-{}-{kind}", std::process::id()));
        fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
