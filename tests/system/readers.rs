//! The log in readers that other people made.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::Folder;

/// `.ci/run` makes an environment with the readers and says in this variable which Python it has.
const PYTHON: &str = "PHALANX_PYTHON";

#[test]
fn stock_readers_see_the_golden_values() {
    let Some(python) = std::env::var_os(PYTHON) else {
        eprintln!("skipped: {PYTHON} does not name a Python with tests/python/requirements.txt");
        return;
    };
    let folder = Folder::new();
    folder.run(&["run", "uav", "--duration", "1", "-q", "--out", "run.mcap"]);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/python/read_log.py");
    let log = folder.path("run.mcap");
    let read = |topic: &str, field: &str, time: &str| {
        let output = Command::new(&python)
            .arg(script)
            .arg(&log)
            .args(["--topic", topic, "--field", field, "--time", time])
            .output()
            .expect("Python runs");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
        // A line per reader: its name, then the values. The script has compared them.
        let line =
            text.lines().find(|line| line.trim_start().starts_with("rosbags")).expect("a line of rosbags").to_string();
        line.split_whitespace().skip(1).map(|word| word.parse().expect("a number")).collect::<Vec<f64>>()
    };
    let golden = [
        ("/agent_1/state", "position", "1", [3.96730214, 1.03446941, 0.191294759]),
        ("/agent_1/reference", "position", "1", [3.9, 0.93967881, 0.1]),
        ("/agent_1/command", "input", "0", [20.8208, 1.03310569, -1.02504533]),
    ];
    for (topic, field, time, expected) in golden {
        for (value, expected) in read(topic, field, time).iter().zip(expected) {
            assert!((value - expected).abs() < 1e-7, "{topic} {field} at {time}: {value} {expected}");
        }
    }
}

/// Runs a script of `tests/` on a log and returns its lines; `None` without the programs that it needs.
fn lines(program: Option<std::ffi::OsString>, script: &str, log: &Path) -> Option<Vec<String>> {
    lines_of_all(program, script, &[log.to_path_buf()])
}

/// The same on several logs.
fn lines_of_all(program: Option<std::ffi::OsString>, script: &str, logs: &[PathBuf]) -> Option<Vec<String>> {
    let Some(program) = program else {
        eprintln!("skipped: {script} needs what .ci/run installs");
        return None;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests").join(script);
    let output = Command::new(program).arg(&script).args(logs).output().expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}: {text}{}", script.display(), String::from_utf8_lossy(&output.stderr));
    Some(text.lines().map(str::to_string).collect())
}

/// What both Python readers find in the scene of a log, after holding it against the signals.
pub(crate) fn scene_of(log: &Path) -> Option<Vec<String>> {
    lines(std::env::var_os(PYTHON), "python/read_scene.py", log)
}

/// Node, if the packages of `tests/typescript` are installed.
fn node() -> Option<std::ffi::OsString> {
    let packages = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/typescript/node_modules");
    Path::new(packages).is_dir().then(|| "node".into())
}

#[test]
fn stock_readers_draw_the_scene() {
    let folder = Folder::new();
    folder.run(&["run", "rca", "--duration", "2", "-q", "--out", "rca.mcap"]);
    folder.run(&["run", "uav", "--duration", "2", "-q", "--out", "uav.mcap"]);
    // 50 frames a second, and the one at the start.
    let counts =
        "/tf=101 /rosout=2 /scene/bodies=1 /scene/links=101 /scene/trails=2 /scene/poses=101 /scene/targets=101";
    for (log, expected) in [("rca.mcap", format!("{counts} /scene/obstacles=1")), ("uav.mcap", counts.to_string())] {
        let Some(lines) = scene_of(&folder.path(log)) else { return };
        for reader in ["mcap-ros2-support", "rosbags"] {
            assert!(lines.contains(&format!("{reader} {expected}")), "{lines:?}");
        }
        assert!(lines.iter().any(|line| line.contains("|20|phalanx|the run is complete, ")), "{lines:?}");
    }
}

#[test]
fn the_readers_of_foxglove_and_lichtblick_decode_every_topic() {
    let folder = Folder::new();
    folder.run(&["run", "rca", "--duration", "1", "-q", "--out", "run.mcap"]);
    let Some(lines) = lines(node(), "typescript/read.mjs", &folder.path("run.mcap")) else { return };
    let last = |topic: &str, kind: &str, count: u64| -> serde_json::Value {
        // The name of a type of Phalanx ends in the digest of its definition.
        let line = lines.iter().find_map(|line| {
            let (found, rest) = line.strip_prefix(&format!("{topic} {kind}"))?.split_once(' ')?;
            let is_own = kind.starts_with("phalanx_msgs/") && found.len() == 8;
            rest.strip_prefix(&format!("{count} ")).filter(|_| found.is_empty() || is_own)
        });
        serde_json::from_str(line.unwrap_or_else(|| panic!("no {topic} {kind} {count} in {lines:#?}"))).expect("JSON")
    };
    let transforms = last("/tf", "tf2_msgs/msg/TFMessage", 51);
    let state = last("/agent_1/state", "phalanx_msgs/msg/State", 1001);
    assert_eq!(transforms["transforms"][0]["child_frame_id"], "agent_1");
    assert_eq!(transforms["transforms"][0]["transform"]["translation"]["x"], state["position"][0]);
    let bodies = last("/scene/bodies", "visualization_msgs/msg/MarkerArray", 1);
    assert_eq!((&bodies["markers"][0]["frame_locked"], &bodies["markers"][2]["text"]), (&true.into(), &"1".into()));
    last("/scene/obstacles", "visualization_msgs/msg/MarkerArray", 1);
    last("/scene/poses", "geometry_msgs/msg/PoseArray", 51);
    assert_eq!(last("/rosout", "rcl_interfaces/msg/Log", 2)["name"], "phalanx");
}

#[test]
fn rerun_moves_the_frames_and_shows_the_journal() {
    let folder = Folder::new();
    folder.run(&["run", "uav", "--duration", "1", "-q", "--out", "run.mcap"]);
    let Some(lines) = lines(std::env::var_os(PYTHON), "python/read_rerun.py", &folder.path("run.mcap")) else { return };
    // Six frames in each message.
    for line in ["/tf 306 Transform3D", "/agent_6/command 101 message", "/scene/links 51 message"] {
        assert!(lines.iter().any(|found| found == line), "{line} in {lines:#?}");
    }
    assert!(lines.iter().any(|line| line.starts_with("/rosout 2 ") && line.contains("TextLog")), "{lines:#?}");
}

#[test]
fn any_two_logs_open_as_one_bag() {
    let folder = Folder::new();
    let list = folder.run(&["list", "--json"]).json();
    let names: Vec<&str> = list.as_array().expect("a list").iter().map(|one| one["name"].as_str().unwrap()).collect();
    let mut logs = Vec::new();
    for name in &names {
        // Dynamic links and assertions have messages of their own; a tenth of a second has all of them.
        let log = format!("{name}.mcap");
        folder.run(&["run", name, "--duration", "0.1", "-q", "--placement", "single", "--out", &log]);
        logs.push(folder.path(&log));
    }
    let Some(lines) = lines_of_all(std::env::var_os(PYTHON), "python/read_types.py", &logs) else { return };
    assert_eq!(lines.len(), names.len() * (names.len() - 1) / 2, "{lines:#?}");
}
