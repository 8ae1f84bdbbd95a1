//! Assertions of a scenario, in real runs.

use crate::program::Folder;

const UAV: &str = include_str!("../../scenarios/uav.toml");

/// The drones, with this assertion behind their own.
fn with_assertion(folder: &Folder, assertion: &str) {
    let at = UAV.find("[expect]").expect("expectations");
    folder.write("mine.toml", &format!("{}[[assert]]\n{assertion}\n{}", &UAV[..at], &UAV[at..]));
}

const VIOLATED: &str = "name = \"agents 1 and 2 stay low\"\nsignal = \"state.position[2]\"\nmax = 0.1\nagents = [1, 2]";

#[test]
fn a_violated_assertion_fails_the_run_and_is_in_the_log() {
    let folder = Folder::new();
    with_assertion(&folder, VIOLATED);
    let run = folder.run(&["run", "mine.toml", "--duration", "3", "--placement", "single", "--out", "a.mcap"]);
    assert_eq!(run.code(), 6, "{}", run.stderr());
    let first = run.stderr().lines().find(|line| line.starts_with("violated: ")).map(String::from);
    let first = first.unwrap_or_else(|| panic!("nothing said at the moment\n{}", run.stderr()));
    assert!(first.contains("agents 1 and 2 stay low: agent ") && first.contains("state.position[2] = 0.1"), "{first}");
    assert!(first.ends_with("> 0.1"), "{first}");
    assert!(run.stdout().contains("VIOLATED"), "{}", run.stdout());
    assert!(run.stderr().contains("error: an assertion is violated"), "{}", run.stderr());

    let check = folder.run(&["check", "a.mcap", "--json"]);
    assert_eq!(check.code(), 6, "{}", check.stderr());
    let found = &check.json()["assertions"][5];
    assert_eq!((&found["name"], &found["ok"]), (&"agents 1 and 2 stay low".into(), &false.into()));
    let info = folder.run(&["info", "a.mcap", "--json"]).json();
    let channels = info["channels"].as_array().expect("channels");
    let topic = channels.iter().find(|channel| channel["topic"] == "/phalanx/assertions").expect("the topic");
    assert_eq!(topic["schema"], "rcl_interfaces/msg/Log");
    assert!(topic["messages"].as_u64() >= Some(2), "{topic}");
    let bytes = std::fs::read(folder.path("a.mcap")).expect("the log");
    assert!(bytes.windows(18).any(|window| window == b"phalanx-assertions"), "the summary is in the log");

    // Processes find the same, and write the same log.
    let json = |arguments: &[&str]| {
        let run = folder.run(&[&["run", "mine.toml", "--duration", "3", "-q", "--json"], arguments].concat());
        assert_eq!(run.code(), 6, "{}", run.stderr());
        run.json()
    };
    let (single, processes) = (json(&["--placement", "single", "--out", "b.mcap"]), json(&["--out", "c.mcap"]));
    assert_eq!(single["sha256"], processes["sha256"]);
    assert_eq!(single["assertions"], processes["assertions"]);
    assert_eq!(single["assertions"], check.json()["assertions"], "the log alone says the same");
    let silent = json(&["--no-log"]);
    assert_eq!(single["assertions"], silent["assertions"], "also without a log");
    assert_eq!(silent["log"], serde_json::Value::Null);
}

#[test]
fn an_assertion_that_stops_ends_the_run_at_its_step() {
    let folder = Folder::new();
    with_assertion(&folder, &format!("{VIOLATED}\nstop = true"));
    let run = folder.run(&["run", "mine.toml", "-q", "--json", "--out", "a.mcap"]);
    assert_eq!(run.code(), 6, "{}", run.stderr());
    let summary = run.json();
    let first = summary["assertions"][5]["first"]["time"].as_f64().expect("a violation");
    let steps = summary["steps"].as_u64().expect("steps");
    assert_eq!(steps, (first / 0.01).round() as u64);
    let info = folder.run(&["info", "a.mcap", "--json"]).json();
    assert_eq!((info["steps"].as_u64(), &info["complete"]), (Some(steps + 1), &true.into()));
}

#[test]
fn a_warning_does_not_fail_the_run() {
    let folder = Folder::new();
    with_assertion(&folder, &format!("{VIOLATED}\nseverity = \"warn\""));
    let run = folder.run(&["run", "mine.toml", "--duration", "3", "-q", "--json", "--no-log", "--placement", "single"]);
    assert_eq!(run.code(), 0, "{}", run.stderr());
    assert_eq!(run.json()["assertions"][5]["ok"], false);
}

#[test]
fn a_wrong_assertion_is_refused_with_its_place() {
    let folder = Folder::new();
    with_assertion(&folder, "name = \"a\"\nsignal = \"norm(state.positon)\"\nmax = 1");
    for command in ["run", "validate"] {
        let run = folder.run(&[command, "mine.toml"]);
        assert_eq!(run.code(), 2);
        let stderr = run.stderr();
        assert!(
            stderr.contains("mine.toml:") && stderr.contains("assert.6.signal: /agent_1/state has no field"),
            "{stderr}"
        );
        assert!(stderr.contains("did you mean `position`?"), "{stderr}");
    }
    assert!(!folder.path("runs").exists());
}
