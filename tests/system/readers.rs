//! The log in the stock readers of the Python world.

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
