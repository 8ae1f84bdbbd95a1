//! Every kind of participant, every moment, every fault, with the outcome that docs/faults.md promises.

use std::thread;

use crate::program::{Folder, saboteur};

use Becomes::{Complete, Ends, Impossible};

/// Steps are numbered from 0 to this.
const LAST: u64 = 50;

/// What becomes of a run.
#[derive(Clone, Copy)]
enum Becomes {
    /// It ends early, and the message says this.
    Ends(&'static str),
    /// It is complete, and its log is that of an undisturbed run.
    Complete,
    /// The fault cannot happen then.
    Impossible,
}

/// A row of the table.
struct Fault {
    key: &'static str,
    /// What a person would call it.
    name: &'static str,
    /// Before the participant joins the run.
    starting: Becomes,
    /// After that, before it is connected.
    connecting: Becomes,
    /// Within a step.
    stepping: Becomes,
}

const UNCONNECTED: [Becomes; 7] = [
    Ends("ended with exit code 0 before it was connected"),
    Ends("ended with exit code 1 before it was connected"),
    Ends("was killed by signal 6 (SIGABRT) before it was connected"),
    Ends("was killed by signal 11 (SIGSEGV) before it was connected"),
    Ends("was killed by signal 9 (SIGKILL) before it was connected"),
    Ends("which has not joined the run"),
    Ends("is still preparing itself"),
];

const fn fault(key: &'static str, name: &'static str, [starting, connecting, stepping]: [Becomes; 3]) -> Fault {
    Fault { key, name, starting, connecting, stepping }
}

/// The rows of the table in docs/faults.md.
const FAULTS: [Fault; 17] = [
    fault("exit-0", "exits with 0", [UNCONNECTED[0], UNCONNECTED[0], Ends("ended with exit code 0 in phase")]),
    fault("exit-1", "exits with 1", [UNCONNECTED[1], UNCONNECTED[1], Ends("ended with exit code 1 in phase")]),
    fault(
        "panic",
        "panics",
        [
            Ends("ended with exit code 101 before it was connected"),
            Ends("cannot start: panicked at"),
            Ends("panicked at"),
        ],
    ),
    fault("abort", "aborts", [UNCONNECTED[2], UNCONNECTED[2], Ends("was killed by signal 6 (SIGABRT) in phase")]),
    fault("segv", "SIGSEGV", [UNCONNECTED[3], UNCONNECTED[3], Ends("was killed by signal 11 (SIGSEGV) in phase")]),
    fault("kill", "SIGKILL", [UNCONNECTED[4], UNCONNECTED[4], Ends("was killed by signal 9 (SIGKILL) in phase")]),
    fault("stop", "SIGSTOP for good", [UNCONNECTED[5], UNCONNECTED[6], Ends("stopped), computing for")]),
    fault("pause", "SIGSTOP, then SIGCONT", [Complete, Complete, Complete]),
    fault("slow", "takes too long", [UNCONNECTED[5], UNCONNECTED[6], Ends("computing for")]),
    fault(
        "refuse",
        "says that it cannot",
        [Impossible, Ends("cannot start: it does not want to"), Ends("it does not want to")],
    ),
    fault("nan", "an output is NaN", [Impossible, Impossible, Ends("is NaN")]),
    fault("infinity", "an output is infinite", [Impossible, Impossible, Ends("is inf")]),
    fault("twice", "is started twice", [Complete, Complete, Complete]),
    fault(
        "scenario",
        "has another scenario",
        [Ends("not the one that the run was started with"), Impossible, Impossible],
    ),
    fault("version", "is of another version", [Ends("it has format 9999"), Impossible, Impossible]),
    fault("steps", "has an altered plan", [Ends("its digest does not fit its content"), Impossible, Impossible]),
    fault("plan", "has the plan of another run", [Ends("it belongs to another plan"), Impossible, Impossible]),
];

/// A short run of three robots.
const RUN: [&str; 8] = ["run", "compensated", "--dt", "0.001", "--duration", "0.05", "-q", "--out"];

/// Runs a formation of three robots in which `participant` fails; exit code and what was said.
fn run(folder: &Folder, participant: &str, fault: &str, moment: &str) -> (i32, String) {
    let swap = format!("{participant}={} {fault} {moment}", saboteur().display());
    let log = format!("{fault}.mcap");
    // A participant that hangs is waited for; one that does not needs the time that a busy machine takes.
    let hangs = ["stop", "slow"].contains(&fault) && moment != "end";
    let more = ["--deadline", if hangs { "1" } else { "20" }, "--swap", &swap];
    let end = folder.run(&[&RUN[..], &[&log], &more].concat());
    (end.code(), end.stderr())
}

/// The samples of the run in which no participant fails.
fn undisturbed(folder: &Folder) -> String {
    assert_eq!(
        folder.run(&[&RUN[..], &["calm.mcap"]].concat()).code(),
        0,
        "the ranges of the scenario are not held against so short a run"
    );
    folder.samples("calm.mcap")
}

/// Lets every fault happen to a participant at a moment, those that take time at once.
fn each(participant: &str, moment: &str, becomes: impl Fn(&Fault) -> Becomes + Sync) {
    let folder = Folder::new();
    let calm = undisturbed(&folder);
    let (folder, calm, becomes) = (&folder, &calm, &becomes);
    let happen = move |fault: &Fault| {
        let expected = becomes(fault);
        if matches!(expected, Impossible) {
            return;
        }
        let (code, stderr) = run(folder, participant, fault.key, moment);
        let what = format!("{participant}, {}, at {moment}: exit code {code}\n{stderr}", fault.key);
        let log = format!("{}.mcap", fault.key);
        match expected {
            Ends(message) => {
                assert!(code == 3 && stderr.contains(participant) && stderr.contains(message), "{what}");
                if let Ok(step) = moment.parse::<u64>() {
                    assert!(stderr.contains(&format!("step {step}")), "{what}");
                    let info = folder.run(&["info", &log, "--json"]).json();
                    assert_eq!(info["complete"], true, "the log is closed: {what}");
                    assert_eq!(info["steps"], step, "all steps before are in the log: {what}");
                }
            }
            Complete => {
                assert!(code <= 1, "{what}");
                assert_eq!(folder.samples(&log), *calm, "the samples are others: {what}");
            }
            Impossible => {}
        }
    };
    let (slow, quick): (Vec<&Fault>, Vec<&Fault>) =
        FAULTS.iter().partition(|fault| ["stop", "slow", "pause", "twice"].contains(&fault.key));
    thread::scope(|scope| {
        slow.into_iter().for_each(|fault| drop(scope.spawn(move || happen(fault))));
        quick.into_iter().for_each(happen);
    });
}

macro_rules! matrix {
    ($($kind:ident: $participant:literal),*) => {
        $(mod $kind {
            use super::{Becomes, Fault, LAST, each};

            #[test]
            fn fails_before_it_joins() {
                each($participant, "start", |fault| fault.starting);
            }

            #[test]
            fn fails_while_connecting() {
                each($participant, "connect", |fault| fault.connecting);
            }

            #[test]
            fn fails_at_the_first_step() {
                each($participant, "0", |fault| fault.stepping);
            }

            #[test]
            fn fails_at_a_step_in_between() {
                each($participant, "23", |fault| fault.stepping);
            }

            #[test]
            fn fails_at_the_last_step() {
                each($participant, &LAST.to_string(), |fault| fault.stepping);
            }

            #[test]
            fn fails_while_the_run_is_being_closed() {
                let at_the_end = |fault: &Fault| match fault.connecting {
                    Becomes::Impossible => Becomes::Impossible,
                    _ => Becomes::Complete,
                };
                each($participant, "end", at_the_end);
            }

            #[test]
            fn is_never_started() {
                super::never_started($participant);
            }
        })*
    };
}

matrix!(plant: "plant", planner: "planner", observer: "observer_1", controller: "controller_2");

/// There is no such program, here or where the system looks for it, and there is one that is no participant.
fn never_started(participant: &str) {
    let folder = Folder::new();
    let cases = [
        ("./nobody", 2, format!("{participant}: there is no program ./nobody")),
        ("nobody-at-all", 3, format!("start nobody-at-all for {participant}")),
        ("sleep 60", 3, "which has not joined the run".into()),
    ];
    for (program, code, expected) in cases {
        let swap = format!("{participant}={program}");
        let end = folder.run(&[&RUN[..], &["cut.mcap", "--deadline", "1", "--swap", &swap]].concat());
        let told = end.stderr().contains(participant) && end.stderr().contains(&expected);
        assert!(end.code() == code && told, "{participant}={program}: {}\n{}", end.code(), end.stderr());
    }
}

/// Only what is read in the step at which it was forged can be found out; that of the last phase is found by the recorder.
#[test]
fn a_sample_that_another_process_alters_ends_the_run() {
    for participant in ["observer_1", "controller_2"] {
        for step in [0, 23, LAST] {
            let folder = Folder::new();
            let (code, stderr) = run(&folder, participant, "forge", &step.to_string());
            let told = stderr.contains(&format!("of step {step} is not what")) && stderr.contains("has published");
            assert!(code == 3 && told, "{participant} at step {step}: {code}\n{stderr}");
            assert_eq!(folder.run(&["info", "forge.mcap", "--json"]).json()["steps"], step);
        }
    }
}

/// A participant that hangs is named, with what helps to find the reason.
#[test]
fn a_hang_is_told_with_process_step_time_and_last_lines() {
    let folder = Folder::new();
    let script = folder.write("talk.sh", &format!("echo ready to hang\nexec {} slow 23\n", saboteur().display()));
    let swap = format!("controller_2=sh {}", script.display());
    let end = folder.run(&[&RUN[..], &["cut.mcap", "--deadline", "1", "--swap", &swap]].concat());
    let stderr = end.stderr();
    let line =
        stderr.lines().find(|line| line.contains("of step 23 is not done after 1.0 s; waiting for controller_2 (pid "));
    let line = line.unwrap_or_else(|| panic!("{stderr}"));
    assert!(line.contains("sleeping") && line.contains("computing for 1."), "{line}");
    assert!(stderr.contains("its last lines:\n    ready to hang"), "{stderr}");
    assert!(stderr.contains("help: `--deadline SECONDS`"), "{stderr}");
}

#[test]
fn the_table_in_the_documentation_is_this_one() {
    let page = include_str!("../../docs/faults.md");
    let cell = |becomes| match becomes {
        Ends(message) => format!("… {message} …"),
        Complete => "the run is complete, its log the same".into(),
        Impossible => "-".into(),
    };
    for Fault { name, starting, connecting, stepping, .. } in &FAULTS {
        let row = format!("| {name} | {} | {} | {} |", cell(*starting), cell(*connecting), cell(*stepping));
        assert!(page.contains(&row), "docs/faults.md lacks the row\n{row}");
    }
}
