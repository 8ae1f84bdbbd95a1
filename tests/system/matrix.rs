//! Every kind of participant, every moment, every fault: what becomes of the run is told in docs/faults.md, and done here.

use std::path::PathBuf;

use crate::program::Folder;

/// Steps are numbered from 0 to this.
const LAST: u64 = 50;

/// What becomes of a run.
struct Outcome {
    fault: &'static str,
    /// What a person would call it.
    name: &'static str,
    /// What the message says if it happens before the participant is connected; empty if it cannot.
    connecting: &'static str,
    /// What the message says if it happens within a step.
    stepping: &'static str,
}

/// The rows of the table in docs/faults.md.
const OUTCOMES: [Outcome; 11] = [
    Outcome {
        fault: "exit-0",
        name: "exits with 0",
        connecting: "ended with exit code 0 before it was connected",
        stepping: "ended with exit code 0 in phase",
    },
    Outcome {
        fault: "exit-1",
        name: "exits with 1",
        connecting: "ended with exit code 1 before it was connected",
        stepping: "ended with exit code 1 in phase",
    },
    Outcome { fault: "panic", name: "panics", connecting: "cannot start: panicked at", stepping: "panicked at" },
    Outcome {
        fault: "abort",
        name: "aborts",
        connecting: "was killed by signal 6 (SIGABRT) before it was connected",
        stepping: "was killed by signal 6 (SIGABRT) in phase",
    },
    Outcome {
        fault: "segv",
        name: "SIGSEGV",
        connecting: "was killed by signal 11 (SIGSEGV) before it was connected",
        stepping: "was killed by signal 11 (SIGSEGV) in phase",
    },
    Outcome {
        fault: "kill",
        name: "SIGKILL",
        connecting: "was killed by signal 9 (SIGKILL) before it was connected",
        stepping: "was killed by signal 9 (SIGKILL) in phase",
    },
    Outcome {
        fault: "stop",
        name: "SIGSTOP for good",
        connecting: "not connected after",
        stepping: "is not done after",
    },
    Outcome { fault: "slow", name: "takes too long", connecting: "not connected after", stepping: "is not done after" },
    Outcome {
        fault: "refuse",
        name: "says that it cannot",
        connecting: "cannot start: it does not want to",
        stepping: "it does not want to",
    },
    Outcome { fault: "nan", name: "an output is NaN", connecting: "", stepping: "is NaN" },
    Outcome { fault: "infinity", name: "an output is infinite", connecting: "", stepping: "is inf" },
];

/// The program that fails; Cargo builds examples before it runs tests.
fn saboteur() -> PathBuf {
    let path = PathBuf::from(env!("CARGO_BIN_EXE_phalanx")).with_file_name("examples").join("saboteur");
    assert!(path.exists(), "{} is not built: cargo build --release --examples -p orchestrator", path.display());
    path
}

/// Runs a formation of three robots in which `participant` fails.
fn run(folder: &Folder, participant: &str, fault: &str, moment: &str) -> (i32, String) {
    let swap = format!("{participant}={} {fault} {moment}", saboteur().display());
    let duration = format!("{}", LAST as f64 * 1e-3);
    let scenario = ["run", "compensated", "--dt", "0.001", "--duration", &duration, "-q", "--out", "cut.mcap"];
    let end = folder.run(&[&scenario[..], &["--deadline", "0.4", "--swap", &swap]].concat());
    (end.code(), end.stderr())
}

fn connecting(participant: &str) {
    let folder = Folder::new();
    for outcome in OUTCOMES.iter().filter(|outcome| !outcome.connecting.is_empty()) {
        let (code, stderr) = run(&folder, participant, outcome.fault, "connect");
        let told = stderr.contains(participant) && stderr.contains(outcome.connecting);
        assert!(code == 3 && told, "{participant}, {}, while connecting: {code}\n{stderr}", outcome.fault);
    }
}

fn stepping(participant: &str, step: u64) {
    let folder = Folder::new();
    for outcome in &OUTCOMES {
        let (code, stderr) = run(&folder, participant, outcome.fault, &step.to_string());
        let told = stderr.contains(participant)
            && stderr.contains(outcome.stepping)
            && stderr.contains(&format!("step {step}"));
        assert!(code == 3 && told, "{participant}, {}, at step {step}: {code}\n{stderr}", outcome.fault);
        let info = folder.run(&["info", "cut.mcap", "--json"]).json();
        assert_eq!(info["complete"], true, "{participant}, {}: the log is closed", outcome.fault);
        assert_eq!(info["steps"], step, "{participant}, {}: all steps before are in the log", outcome.fault);
    }
}

fn ending(participant: &str) {
    let folder = Folder::new();
    for outcome in OUTCOMES.iter().filter(|outcome| !outcome.connecting.is_empty()) {
        let (code, stderr) = run(&folder, participant, outcome.fault, "end");
        // So short a run misses the bands of the scenario.
        assert_eq!(code, 1, "{participant}, {}, at the end: {stderr}", outcome.fault);
        assert_eq!(folder.run(&["info", "cut.mcap", "--json"]).json()["steps"], LAST + 1);
    }
}

macro_rules! matrix {
    ($($kind:ident: $participant:literal),*) => {
        $(mod $kind {
            use super::{LAST, connecting, ending, stepping};

            #[test]
            fn fails_while_connecting() {
                connecting($participant);
            }

            #[test]
            fn fails_at_the_first_step() {
                stepping($participant, 0);
            }

            #[test]
            fn fails_at_a_step_in_between() {
                stepping($participant, 23);
            }

            #[test]
            fn fails_at_the_last_step() {
                stepping($participant, LAST);
            }

            #[test]
            fn fails_while_the_run_is_being_closed() {
                ending($participant);
            }
        })*
    };
}

matrix!(plant: "plant", planner: "planner", observer: "observer_1", controller: "controller_2");

#[test]
fn the_table_in_the_documentation_is_this_one() {
    let page = include_str!("../../docs/faults.md");
    for Outcome { name, connecting, stepping, .. } in &OUTCOMES {
        let connecting = if connecting.is_empty() { "-".into() } else { format!("… {connecting} …") };
        let row = format!("| {name} | {connecting} | … {stepping} … | the run is complete |");
        assert!(page.contains(&row), "docs/faults.md lacks the row\n{row}");
    }
}
