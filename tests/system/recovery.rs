//! Participants that fail and are replaced while the run goes on.

use std::process::Child;
use std::thread::sleep;
use std::time::Duration;

use lockstep::Status;
use recording::Log;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::program::{Finished, Folder, children, is_alive, unique, wait_until};

/// Sleeps between two blows; the runs are paced to the clock, so that there is something left to hit.
const PAUSE: Duration = Duration::from_millis(120);

/// A generator of the same numbers in every run: SplitMix64.
struct Dice(u64);

impl Dice {
    fn throw(&mut self, sides: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut value = self.0;
        value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((value ^ (value >> 31)) % sides as u64) as usize
    }
}

fn strike(pid: u32, signal: Signal) {
    // It may have ended just now.
    let _ = kill_process(Pid::from_raw(pid as i32).expect("a process id"), signal);
}

/// The sha256 of an undisturbed run in one process.
fn undisturbed(folder: &Folder, scenario: &str, duration: &str) -> Value {
    let run = ["run", scenario, "--duration", duration, "--placement", "single", "-q", "--json", "--out", "calm.mcap"];
    folder.run(&run).json()["sha256"].clone()
}

fn start(folder: &Folder, scenario: &str, duration: &str, more: &[&str]) -> Child {
    let run = ["run", scenario, "--duration", duration, "-q", "--json", "--out", "disturbed.mcap"];
    let run = folder.start(&[&run[..], more].concat());
    wait_until("the log grows", || {
        std::fs::metadata(folder.path("disturbed.mcap")).is_ok_and(|file| file.len() > 30_000)
    });
    run
}

/// A scenario under another name, which is then that of its run; beside runs of other tests, commands need it.
fn renamed(folder: &Folder, scenario: &str, name: &str) -> String {
    let text = folder.run(&["validate", scenario, "--print"]).stdout();
    let renamed = text.replacen(&format!("name = \"{scenario}\""), &format!("name = \"{name}\""), 1);
    assert_ne!(text, renamed);
    folder.write(&format!("{name}.toml"), &renamed);
    format!("{name}.toml")
}

fn end(run: Child) -> Finished {
    Finished(run.wait_with_output().expect("an end"))
}

#[test]
fn a_run_that_loses_plant_planner_observer_and_controller_gives_the_same_log() {
    let folder = Folder::new();
    let calm = undisturbed(&folder, "uav", "12");
    let run = start(&folder, "uav", "12", &["--on-failure", "restart", "--realtime", "6"]);
    for victim in [0, 1, 4, 9] {
        strike(children(run.id())[victim.min(children(run.id()).len() - 1)], Signal::KILL);
        sleep(PAUSE);
    }
    let end = end(run);
    let outcome = end.json();
    assert_eq!(outcome["sha256"], calm, "{}", end.stderr());
    assert!(outcome["replaced"].as_array().expect("a list").len() >= 4, "{}", end.stderr());
}

#[test]
#[cfg_attr(not(feature = "long-tests"), ignore = "long; --features long-tests runs it")]
fn random_kills_in_every_scheme_change_nothing() {
    let mut dice = Dice(7);
    for scenario in
        ["dsm-ftdo", "dsm-cnn", "rca", "limited-information", "cida", "compensated", "lp-regulation", "mixed", "uav"]
    {
        let folder = Folder::new();
        let calm = undisturbed(&folder, scenario, "4");
        let policy = ["--on-failure", "restart", "--realtime", "2", "--set", "on_failure.restarts=20"];
        let run = start(&folder, scenario, "4", &policy);
        for _ in 0..1 + dice.throw(20) {
            let living = children(run.id());
            if !living.is_empty() {
                strike(living[dice.throw(living.len())], Signal::KILL);
            }
            sleep(PAUSE / 2);
        }
        let end = end(run);
        let outcome = end.json();
        assert_eq!(outcome["sha256"], calm, "{scenario}: {}", end.stderr());
        assert_ne!(outcome["replaced"].as_array().map(Vec::len), Some(0), "{scenario}: no participant was hit");
    }
}

#[test]
fn a_participant_that_hangs_is_restarted_after_the_deadline() {
    let folder = Folder::new();
    let calm = undisturbed(&folder, "uav", "6");
    let policy = ["--on-failure", "controller=restart", "--deadline", "0.5", "--realtime", "6"];
    let run = start(&folder, "uav", "6", &policy);
    let victim = *children(run.id()).last().expect("a controller");
    strike(victim, Signal::STOP);
    let end = end(run);
    assert_eq!(end.json()["sha256"], calm, "{}", end.stderr());
    assert!(!is_alive(victim) && end.stderr().contains("stopped"), "{}", end.stderr());
}

#[test]
fn a_participant_without_a_policy_ends_the_run() {
    let folder = Folder::new();
    let run = start(&folder, "uav", "12", &["--on-failure", "observer=restart", "--realtime", "6"]);
    strike(children(run.id())[0], Signal::KILL);
    let end = end(run);
    assert_eq!(end.code(), 3, "{}", end.stderr());
    assert!(end.stderr().contains("SIGKILL"), "{}", end.stderr());
}

#[test]
fn a_participant_is_restarted_so_often_and_no_more() {
    let folder = Folder::new();
    let policy = ["--on-failure", "restart", "--set", "on_failure.restarts=1", "--realtime", "4"];
    let run = start(&folder, "uav", "20", &policy);
    let first = children(run.id());
    strike(first[0], Signal::KILL);
    wait_until("it is replaced", || children(run.id()).iter().any(|pid| !first.contains(pid)));
    let second = children(run.id()).into_iter().find(|pid| !first.contains(pid)).expect("a successor");
    sleep(PAUSE);
    strike(second, Signal::KILL);
    let end = end(run);
    assert_eq!(end.code(), 3, "{}", end.stderr());
    assert!(end.stderr().contains("restarted 1 times already"), "{}", end.stderr());
}

#[test]
fn a_held_participant_is_flagged_in_the_log() {
    let folder = Folder::new();
    let name = unique("half-blind");
    let scenario = renamed(&folder, "compensated", &name);
    let run = start(&folder, &scenario, "4", &["--on-failure", "observer=hold", "--realtime", "2"]);
    let status = folder.run(&["ctl", "status", &name, "--json"]).json();
    let names: Vec<&str> =
        status["workers"].as_array().expect("workers").iter().filter_map(|w| w["name"].as_str()).collect();
    let observer = names.iter().position(|name| *name == "observer_1").expect("an observer");
    strike(children(run.id())[observer], Signal::KILL);
    let end = end(run);
    assert!(end.stderr().contains("observer_1 is held"), "{}", end.stderr());
    let log = folder.run(&["info", "disturbed.mcap", "--json"]).json();
    let topics = log["channels"].as_array().expect("channels");
    let events = topics.iter().find(|channel| channel["topic"] == "/phalanx/events").expect("a topic of events");
    assert_eq!(events["messages"], 1);
    let log = Log::open(&folder.path("disturbed.mcap")).expect("a log");
    let last = |topic: &str| log.signal(topic, "status").expect("a status").row(log.times().len() - 1)[0];
    assert_eq!(last("/agent_1/estimate"), f64::from(Status::Stale as u32));
    assert_eq!(last("/agent_2/estimate"), f64::from(Status::Fresh as u32));
}

#[test]
fn a_program_takes_over_while_the_run_goes_on() {
    let folder = Folder::new();
    let name = unique("changing");
    let scenario = renamed(&folder, "uav", &name);
    let calm = undisturbed(&folder, &scenario, "12");
    let run = start(&folder, &scenario, "12", &["--realtime", "6"]);
    let own = format!("controller.3={} participant", env!("CARGO_BIN_EXE_phalanx"));
    let swapped = folder.run(&["ctl", "swap", &own, &name]);
    assert_eq!(swapped.code(), 0, "{}", swapped.stderr());
    assert!(swapped.stdout().contains("the program plays from step"), "{}", swapped.stdout());
    let end = end(run);
    let outcome = end.json();
    assert_eq!(outcome["replaced"].as_array().map(Vec::len), Some(1), "{}", end.stderr());
    assert_ne!(outcome["sha256"], calm, "the log marks the step");
    // The same program: nothing but the mark differs.
    let verify = folder.run(&["export", "disturbed.mcap", "--format", "csv", "--out", "a"]);
    assert_eq!(verify.code(), 0, "{}", verify.stderr());
    assert_eq!(folder.run(&["export", "calm.mcap", "--format", "csv", "--out", "b"]).code(), 0);
    let table = |side: &str| std::fs::read_to_string(folder.path(side).join("agent_3_command.csv")).unwrap_or_default();
    assert!(!table("a").is_empty() && table("a") == table("b"));
}

#[test]
fn a_program_that_cannot_take_over_changes_nothing() {
    let folder = Folder::new();
    let name = unique("misled");
    let scenario = renamed(&folder, "uav", &name);
    let calm = undisturbed(&folder, &scenario, "12");
    let run = start(&folder, &scenario, "12", &["--realtime", "6"]);
    let swapped = folder.run(&["ctl", "swap", "controler.3=/bin/true", &name]);
    assert_eq!(swapped.code(), 2);
    assert!(swapped.stderr().contains("did you mean `controller_3`"), "{}", swapped.stderr());
    for (program, reason) in [("/bin/true", "exit code 0"), ("./no_such_program", "No such file")] {
        let swapped = folder.run(&["ctl", "swap", &format!("controller.3={program}"), &name]);
        assert_eq!(swapped.code(), 2, "{}", swapped.stdout());
        let told = swapped.stderr();
        assert!(told.contains(reason) && told.contains("controller_3 plays on as before"), "{told}");
    }
    let end = end(run);
    assert_eq!(end.json()["sha256"], calm, "{}", end.stderr());
    assert!(end.stderr().contains("`/bin/true` cannot play controller_3"), "{}", end.stderr());
}

/// A swapped-in program answers for the steps from its own first one on, not for those that its predecessor played.
#[test]
fn after_a_swap_the_next_may_fail_and_the_program_may_die() {
    let folder = Folder::new();
    let name = unique("twice");
    let scenario = renamed(&folder, "uav", &name);
    undisturbed(&folder, &scenario, "12");
    let run = start(&folder, &scenario, "12", &["--realtime", "6", "--on-failure", "restart"]);
    let phalanx = env!("CARGO_BIN_EXE_phalanx");
    let swap = |program: &str| folder.run(&["ctl", "swap", &format!("controller.3={program}"), &name]);
    // Its commands are those of the calm run and a tenth of a per cent more: not what the controller before it has published.
    let swapped = swap(&format!("{phalanx} participant --replay calm.mcap --factor 1.001"));
    assert_eq!(swapped.code(), 0, "{}", swapped.stderr());
    sleep(PAUSE);
    let failed = swap("./no_such_program");
    assert!(failed.code() == 2 && failed.stderr().contains("plays on as before"), "{}", failed.stderr());
    sleep(PAUSE);
    let commands = |pid: &u32| std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    let player = |pid: &u32| String::from_utf8_lossy(&commands(pid)).contains("--factor");
    let victim = children(run.id()).into_iter().find(player).expect("the program that plays on");
    strike(victim, Signal::KILL);
    let end = end(run);
    let outcome = end.json();
    assert!(end.code() <= 1, "{}", end.stderr());
    assert!(end.stderr().contains("controller_3 was restarted"), "{}", end.stderr());
    assert_eq!(outcome["replaced"].as_array().map(Vec::len), Some(3), "{outcome}");
    assert_eq!(outcome["steps"], 1200, "{outcome}");
}

#[test]
fn a_participant_that_dies_before_it_is_connected_is_restarted() {
    let folder = Folder::new();
    undisturbed(&folder, "uav", "1");
    let phalanx = env!("CARGO_BIN_EXE_phalanx");
    // The first time it dies before it has joined; the second time it plays.
    folder.write("late.sh", &format!("if mkdir once-$1; then exit 7; fi\nexec {phalanx} participant\n"));
    let swaps = ["--swap", "controller.3=sh late.sh 3", "--swap", "observer.2=sh late.sh 2"];
    let run = ["run", "uav", "--duration", "1", "-q", "--json", "--out", "disturbed.mcap", "--on-failure", "restart"];
    let end = folder.run(&[&run[..], &swaps].concat());
    assert_eq!(end.json()["replaced"].as_array().map(Vec::len), Some(2), "{}", end.stderr());
    // The log names the programs that played; the samples are those of the calm run.
    let verify = folder.run(&["verify", "calm.mcap", "disturbed.mcap"]);
    assert_eq!(verify.code(), 0, "{}{}", verify.stdout(), verify.stderr());
    // One that never comes ends the run with what it died of.
    let end = folder.run(&[&run[..], &["--swap", "controller.3=false"]].concat());
    assert!(end.code() == 3 && end.stderr().contains("was restarted 3 times already"), "{}", end.stderr());
}

#[test]
fn what_cannot_be_held_before_the_first_step_ends_the_run_with_its_own_error() {
    let folder = Folder::new();
    let run = ["run", "uav", "--duration", "1", "-q", "--out", "a.mcap", "--on-failure", "hold"];
    let end = folder.run(&[&run[..], &["--swap", "controller.3=false"]].concat());
    let told = end.stderr();
    assert!(end.code() == 3 && told.contains("ended with exit code 1 before it was connected"), "{told}");
}

#[test]
fn a_program_is_swapped_in_as_it_is_called_where_one_asks() {
    let folder = Folder::new();
    let name = unique("elsewhere");
    let scenario = renamed(&folder, "uav", &name);
    let run = start(&folder, &scenario, "12", &["--realtime", "6"]);
    // A link to the program, and a file beside it, that the run would not find from its own folder.
    let other = Folder::new();
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_phalanx"), other.path("mine")).expect("a link");
    other.write("mine.sh", "test -e beside || exit 7\nexec ./mine participant\n");
    other.write("beside", "");
    for program in ["./mine participant", "sh mine.sh"] {
        let swapped = other.run(&["ctl", "swap", &format!("controller.3={program}"), &name]);
        assert_eq!(swapped.code(), 0, "{}", swapped.stderr());
    }
    let end = end(run);
    assert_eq!(end.json()["replaced"].as_array().map(Vec::len), Some(2), "{}", end.stderr());
    assert!(end.stderr().contains("/mine participant`"), "{}", end.stderr());
}

#[test]
fn what_cannot_be_restarted_from_nothing_is_refused() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uav", "--no-log", "--on-failure", "restart"]);
    assert_eq!(run.code(), 2);
    assert!(run.stderr().contains("--no-log leaves nothing"), "{}", run.stderr());
    let run = folder.run(&["run", "uav", "--on-failure", "controler=restart"]);
    assert!(run.stderr().contains("there is no such participant"), "{}", run.stderr());
}
