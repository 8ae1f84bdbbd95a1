//! Placement, control and proof of sameness, as a user sees them.

use std::os::unix::fs::PermissionsExt;
use std::process::Child;
use std::time::Duration;

use recording::Log;
use serde_json::Value;

use crate::program::{Folder, children, wait_until};

/// The drone scenario with something appended.
fn scenario(folder: &Folder, name: &str, more: &str) -> String {
    let text = folder.run(&["validate", "uav", "--duration", "0.5", "--print"]).stdout();
    folder.write(name, &format!("{text}\n{more}\n")).to_str().expect("a path").to_string()
}

const GROUPS: &str =
    "[placement]\ngroups = [[\"plant\", \"planner\"], [\"observer_1\", \"controller_1\", \"controller_2\"]]";

#[test]
fn two_logs_are_compared_bit_by_bit() {
    let folder = Folder::new();
    let short = ["run", "uav", "--duration", "0.5", "-q", "--placement", "single"];
    folder.run(&[&short[..], &["--out", "a.mcap"]].concat());
    folder.run(&[&short[..], &["--out", "b.mcap", "--set", "phase=1e-12"]].concat());
    folder.run(&["run", "uav", "--duration", "0.4", "-q", "--placement", "single", "--out", "c.mcap"]);
    let same = folder.run(&["verify", "a.mcap", "a.mcap"]);
    assert_eq!((same.code(), same.stdout().starts_with("equal: all ")), (0, true), "{}", same.stdout());
    let other = folder.run(&["verify", "a.mcap", "b.mcap"]);
    assert_eq!(other.code(), 1);
    let text = other.stdout();
    assert!(text.contains("they differ first at step 0 (t = 0 s), /agent_1/state disturbance[0]: "), "{text}");
    assert!(text.contains(" ulp apart; "), "{text}");
    let json = folder.run(&["verify", "a.mcap", "b.mcap", "--json"]).json();
    assert!(json["ulps"].as_u64() > Some(0) && json["differing"].as_u64() > Some(0), "{json}");
    let shorter = folder.run(&["verify", "a.mcap", "c.mcap"]);
    assert_eq!(shorter.code(), 1);
    assert!(shorter.stdout().contains("steps 0 to 50, the second 0 to 40"), "{}", shorter.stdout());
    assert_eq!(folder.run(&["verify", "a.mcap"]).code(), 2);
}

#[test]
fn all_ways_to_run_a_scenario_are_equal_under_stress() {
    let folder = Folder::new();
    let file = scenario(&folder, "grouped.toml", GROUPS);
    let run = folder.run(&["verify", "--scenario", &file, "--placements", "all", "--stress", "--json"]);
    let json = run.json();
    assert_eq!((json["equal"].as_bool(), json["runs"].as_u64()), (Some(true), Some(8)), "{json} {}", run.stderr());
}

#[test]
fn groups_share_a_process_and_change_nothing() {
    let folder = Folder::new();
    let file = scenario(&folder, "grouped.toml", GROUPS);
    let run = |more: &[&str]| folder.run(&[&["run", &file, "-q", "--json"], more].concat()).json();
    let grouped = run(&["--out", "a.mcap"]);
    let apart = run(&["--out", "b.mcap", "--placement", "processes"]);
    assert_eq!((grouped["processes"].as_u64(), apart["processes"].as_u64()), (Some(12), Some(15)));
    assert_eq!(grouped["sha256"], apart["sha256"]);
    let file = scenario(&folder, "wrong.toml", "[placement]\ngroups = [[\"plant\", \"observr_1\"], [\"plant\"]]");
    let wrong = folder.run(&["validate", &file]);
    assert_eq!(wrong.code(), 2);
    let text = wrong.stderr();
    assert!(text.contains("did you mean `observer_1`") && text.contains("`plant` is in two groups"), "{text}");
}

#[test]
fn an_edge_can_be_delayed() {
    let folder = Folder::new();
    let file = scenario(&folder, "delayed.toml", "[edges]\n\"observer_1 <- plant\" = \"delayed\"");
    let graph = folder.run(&["graph", &file]).stdout();
    assert!(graph.contains("observer_1\n    reads of the step before: plant"), "{graph}");
    let equal = folder.run(&["verify", "--scenario", &file, "--placements", "processes"]);
    assert_eq!(equal.code(), 0, "{}{}", equal.stdout(), equal.stderr());
    let file =
        scenario(&folder, "wrong.toml", "[edges]\n\"planner <- plant\" = \"delayed\"\n\"plant <- x\" = \"delayed\"");
    let wrong = folder.run(&["validate", &file]).stderr();
    assert!(
        wrong.contains("planner reads nothing of plant") && wrong.contains("no participant is called `x`"),
        "{wrong}"
    );
}

/// The first samples of all controllers of `triangle` in a short run with these lines in the scenario, by placement.
fn first_commands(lines: &str, placement: &str) -> Vec<Vec<f64>> {
    let folder = Folder::new();
    let text = include_str!("../../scenarios/triangle.toml").replace("[plant]", &format!("{lines}\n[plant]"));
    folder.write("mine.toml", &text);
    let run = ["run", "mine.toml", "-q", "--duration", "0.1", "--placement", placement, "--out", "log.mcap"];
    let run = folder.run(&run);
    assert!(run.code() <= 1, "{}", run.stderr());
    let log = Log::open(&folder.path("log.mcap")).expect("a log");
    let first = |agent| {
        let input = log.signal(&format!("/agent_{agent}/command"), "input").expect("inputs");
        input.row(0).to_vec()
    };
    (1..=3).map(first).collect()
}

#[test]
fn a_delayed_edge_starts_with_what_its_writer_publishes_first() {
    let expected = first_commands("", "single");
    assert!(expected.iter().flatten().any(|input| *input != 0.0), "{expected:?}");
    for edges in ["\"controller <- plant\" = \"delayed\"", "\"controller <- planner\" = \"delayed\""] {
        for placement in ["single", "processes"] {
            assert_eq!(first_commands(&format!("[edges]\n{edges}\n"), placement), expected, "{edges}, {placement}");
        }
    }
}

#[test]
fn what_has_an_offset_starts_with_what_its_component_publishes_first() {
    let folder = Folder::new();
    let text = include_str!("../../scenarios/triangle.toml").replace("[planner]", "[planner]\noffset = 2");
    folder.write("mine.toml", &text);
    let equal = folder.run(&["verify", "--scenario", "mine.toml", "--placements", "all", "--duration", "0.1"]);
    assert_eq!(equal.code(), 0, "{}{}", equal.stdout(), equal.stderr());
    let run = folder.run(&["run", "mine.toml", "-q", "--duration", "0.1", "--out", "log.mcap"]);
    assert!(run.code() <= 1, "{}", run.stderr());
    let log = Log::open(&folder.path("log.mcap")).expect("a log");
    let error = log.signal("/agent_1/command", "error").expect("errors").row(0);
    // The planner publishes nothing before step 2, but the error is not that of a reference of zeros: robot 1 starts at the
    // origin, and its reference at (2 cos(2 pi/3), 2 sin(2 pi/3)).
    assert!(error[..2].iter().all(|error| error.abs() > 0.5), "{error:?}");
}

/// The status of the run that this process is, once its processes are connected.
pub(crate) fn status(folder: &Folder, run: &Child) -> Option<(String, Value)> {
    let names = std::iter::once("uav".to_string()).chain((2..20).map(|number| format!("uav-{number}")));
    let ask = |name: String| {
        let answer = folder.run(&["ctl", "status", &name, "--json"]);
        let json: Value = serde_json::from_str(answer.stdout().trim()).ok()?;
        let is_it = json["pid"].as_u64() == Some(run.id().into()) && json["state"] != "starting";
        is_it.then_some((name, json))
    };
    names.filter_map(ask).next()
}

/// Processor time that a process has used, in clock ticks.
fn ticks(pid: u32) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    let words: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    [11, 12].iter().filter_map(|&word| words.get(word)?.parse::<u64>().ok()).sum()
}

#[test]
fn a_run_is_controlled_from_another_terminal() {
    let folder = Folder::new();
    let mut run = folder.start(&["run", "uav", "--realtime", "2", "-q", "--out", "a.mcap"]);
    wait_until("the run answers", || status(&folder, &run).is_some());
    let (name, _) = status(&folder, &run).expect("a status");
    let tell = |words: &[&str]| folder.run(&[&["ctl"], words, &[&name, "--json"]].concat()).json();
    let steps = || tell(&["status"])["steps"].as_u64().expect("a number of steps");
    let socket = format!("/dev/shm/phalanx-{}/{name}/control.sock", rustix::process::getuid().as_raw());
    assert_eq!(std::fs::metadata(socket).expect("a socket").permissions().mode() & 0o777, 0o600);

    assert_eq!(tell(&["pause"])["paused"], true);
    // A step that was waiting for its time when the pause came is still done.
    std::thread::sleep(Duration::from_millis(100));
    let (paused, workers) = (steps(), children(run.id()));
    let used = || workers.iter().map(|&worker| ticks(worker)).sum::<u64>();
    let before = used();
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!((steps(), used()), (paused, before), "a paused run does something");

    tell(&["step", "5"]);
    wait_until("five steps are done", || steps() == paused + 5);
    let top = folder.run(&["top", &name, "--once", "--interval", "0.1"]);
    assert!(top.stdout().contains("controller_6"), "{}{}", top.stdout(), top.stderr());
    assert_eq!(steps(), paused + 5);
    assert_eq!(tell(&["resume"])["paused"], false);
    wait_until("it goes on", || steps() > paused + 10);
    tell(&["stop"]);
    assert_eq!(run.wait().expect("an end").code(), Some(130));
    assert_eq!(folder.run(&["info", "a.mcap"]).code(), 0);
    let gone = folder.run(&["ctl", "pause", "no-such-run"]);
    assert_eq!(gone.code(), 2);
    assert!(gone.stderr().contains("no run is called `no-such-run`"), "{}", gone.stderr());
}

#[test]
fn a_paced_run_takes_its_time_and_is_the_same() {
    let folder = Folder::new();
    let short = ["run", "uav", "--duration", "0.5", "-q", "--json"];
    let paced = folder.run(&[&short[..], &["--realtime", "--out", "a.mcap"]].concat()).json();
    assert!(paced["wall_s"].as_f64() >= Some(0.5) && paced["overruns"].is_u64(), "{paced}");
    let fast = folder.run(&[&short[..], &["--out", "b.mcap"]].concat()).json();
    assert_eq!(paced["sha256"], fast["sha256"]);
    assert_eq!(folder.run(&["run", "uav", "--realtime", "-1"]).code(), 2);
}

#[test]
fn a_profile_names_everybody_and_is_no_part_of_the_log() {
    let folder = Folder::new();
    let short = ["run", "uav", "--duration", "0.5", "-q"];
    let run = folder.run(&[&short[..], &["--profile", "--out", "a.mcap"]].concat());
    let text = run.stdout();
    assert!(text.contains("\nplanner ") && text.contains("of which"), "{text}");
    let trace: Value =
        serde_json::from_slice(&std::fs::read(folder.path("a.trace.json")).expect("a trace")).expect("JSON");
    // 14 names, and 51 runs of all participants.
    assert_eq!(trace["traceEvents"].as_array().map(Vec::len), Some(14 + 14 * 51));
    folder.run(&[&short[..], &["--out", "b.mcap"]].concat());
    assert_eq!(folder.run(&["verify", "a.mcap", "b.mcap"]).code(), 0);
    let single = folder.run(&[&short[..], &["--profile", "--placement", "single", "--out", "c.mcap"]].concat());
    assert!(single.stdout().contains("\nobserver_6 "), "{}", single.stdout());
}

#[test]
fn a_scenario_and_a_log_are_profiled() {
    let folder = Folder::new();
    let from_scenario = folder.run(&["profile", "uav", "--duration", "0.5", "-q", "--out", "a.mcap"]);
    let text = from_scenario.stdout();
    assert!(from_scenario.code() == 0 && text.contains("\nplanner ") && text.contains("of which"), "{text}");
    let spans = |name: &str| {
        let trace: Value = serde_json::from_slice(&std::fs::read(folder.path(name)).expect("a trace")).expect("JSON");
        let events = trace["traceEvents"].as_array().expect("events");
        assert!(events.iter().all(|event| event["ph"] != "X" || event["dur"].as_f64() >= Some(0.0)));
        events.iter().filter(|event| event["ph"] == "X").count()
    };
    assert_eq!(spans("uav.trace.json"), 14 * 51);
    let from_log = folder.run(&["profile", "a.mcap", "-q", "--trace", "again.json", "--placement", "agents"]);
    assert_eq!(from_log.code(), 0, "{}", from_log.stderr());
    // Plant, planner, and two runs a step of every agent's process.
    assert_eq!(spans("again.json"), 14 * 51);
    let changed = folder.run(&["profile", "a.mcap", "--set", "seed=2"]);
    assert!(changed.code() == 2 && changed.stderr().contains("is a log"), "{}", changed.stderr());
}
