//! Scenarios whose formulas read data files.

use std::fmt::Write;

use crate::program::Folder;

/// A trajectory as Crazyswarm writes it: an eight of 7.4 s.
const FIGURE_8: &str = include_str!("data/figure8.csv");

/// Three robots: one along a file of 100,000 rows, one along the eight, and one between waypoints; wind from a table.
const SCENARIO: &str = r#"
name = "files"
title = "references and wind from files"
agents = [{ position = [0, 0, 0] }, { position = [1, 0, 0] }, { position = [0, 1, 0] }]

[timing]
dt = 0.01
duration = 8

[vehicle]
kind = "integrator"

[topology]
b = 1

[reference]
define.eight_x = 'trajectory("figure8.csv", "x", t)'
define.eight_y = 'trajectory("figure8.csv", "y", t)'
position = [
    'if(i <= 1, table("data/long.csv", "x", t, "cubic"), if(i <= 2, eight_x, trajectory("way.csv", "x", t)))',
    'if(i <= 1, table("data/long.csv", "y", t), if(i <= 2, eight_y, trajectory("way.csv", "y", t)))',
    "0",
]

[disturbance]
matched = ['table("wind.csv", "vx", t)', 'table("wind.csv", "vy", t, "hold")', "0.01*noise(seed + i, t, 0.05)"]

[plant]
kind = "vehicles"

[planner]
kind = "reference"

[controller]
kind = "consensus"
k_x = 4
k_v = 4
"#;

const FILES: [&str; 4] = ["data/long.csv", "figure8.csv", "way.csv", "wind.csv"];

fn files(folder: &Folder) {
    std::fs::create_dir(folder.path("data")).expect("a folder for data");
    let mut long = String::from("t,x,y\n");
    for row in 0..100_000 {
        let t = f64::from(row) * 1e-4;
        writeln!(long, "{t:.4},{:.9},{:.9}", t.sin(), t.cos()).expect("it is written");
    }
    folder.write("data/long.csv", &long);
    folder.write("figure8.csv", FIGURE_8);
    folder.write("way.csv", "t,x,y,z\n0,0,1,0\n2,1,1,0\n5,1,-1,0\n7,0,0,0\n");
    folder.write("wind.csv", "t;vx;vy\n0;0;0\n2;0.5;0.1\n4;-0.5;0\n8;0;0.2\n");
    folder.write("files.toml", SCENARIO);
}

#[test]
fn data_files_are_part_of_the_log() {
    let folder = Folder::new();
    files(&folder);
    let mut digests = Vec::new();
    for placement in ["single", "agents", "processes"] {
        let log = format!("{placement}.mcap");
        let run = folder.run(&["run", "files.toml", "--placement", placement, "--out", &log, "-q", "--json"]);
        assert_eq!(run.code(), 0, "{placement}: {}", run.stderr());
        digests.push(run.json()["sha256"].as_str().expect("a digest").to_string());
    }
    assert!(digests.iter().all(|digest| *digest == digests[0]), "{digests:?}");

    let log = recording::Log::open(&folder.path("processes.mcap")).expect("a log");
    assert!(log.data().keys().eq(FILES));
    // At the end of its pieces the eight is where it began, and its file is exact to six digits.
    let eight = log.signal("/agent_2/reference", "position").expect("a reference");
    let [x, y] = [0, 1].map(|k| eight.row(eight.len() - 1)[k]);
    assert!(x.abs() < 1e-3 && y.abs() < 1e-3, "{x} {y}");
    let long = log.signal("/agent_1/reference", "position").expect("a reference");
    assert!((long.row(123)[0] - 1.23_f64.sin()).abs() < 1e-8);
    let velocity = log.signal("/agent_1/reference", "velocity").expect("a velocity");
    assert!((velocity.row(123)[0] - 1.23_f64.cos()).abs() < 1e-4);
    let end = log.signal("/agent_3/state", "position").expect("a state");
    assert!(end.row(end.len() - 1)[0].abs() < 0.3, "it flies along its waypoints");

    // The log needs none of the files any more.
    for file in FILES {
        std::fs::remove_file(folder.path(file)).expect("it is removed");
    }
    folder.write("wind.csv", "t,vx\n0,0\n1,1\n");
    for command in [
        &["verify", "single.mcap", "processes.mcap"][..],
        &["replay", "processes.mcap", "--only", "controller_2"],
        &["replay", "processes.mcap", "--only", "planner"],
        &["check", "processes.mcap"],
        &["report", "processes.mcap", "--out", "report.html"],
    ] {
        let end = folder.run(command);
        assert_eq!(end.code(), 0, "{command:?}: {}{}", end.stdout(), end.stderr());
    }
    let end = folder.run(&["validate", "files.toml"]);
    assert!(end.code() == 2 && end.stderr().contains("cannot read figure8.csv: No such file"), "{}", end.stderr());
}

#[test]
fn a_wrong_file_is_refused_at_its_formula() {
    let folder = Folder::new();
    files(&folder);
    let refused = |expected: &[&str]| {
        let end = folder.run(&["validate", "files.toml"]);
        let stderr = end.stderr();
        assert_eq!(end.code(), 2, "{stderr}");
        for text in expected {
            assert!(stderr.contains(text), "{text:?} is not in\n{stderr}");
        }
    };
    folder.write("wind.csv", "t,vxx,vy\n0,0,0\n1,1,1\n");
    refused(&["files.toml:26:", "disturbance.matched.1", "no column is called `vx`", "did you mean `vxx`?"]);
    folder.write("wind.csv", "t,vx,vy\n0,0,0\n1,x,1\n");
    refused(&["disturbance.matched.1", "wind.csv: line 3, column `vx`: expected a finite number, found \"x\""]);
    folder.write("wind.csv", "t,vx,vy\n0,0,0\n1,1,1\n");
    assert_eq!(folder.run(&["validate", "files.toml"]).code(), 0);
    folder.write("files.toml", &format!("{SCENARIO}\n[data]\n\"wind.csv\" = \"{}\"\n", "0".repeat(64)));
    refused(&["wind.csv: the file is another one than [data] of the scenario says"]);
    folder.write("files.toml", &format!("{SCENARIO}\n[data]\n\"wind.csv\" = 3\n"));
    refused(&["data.wind.csv", "expected a file in quotes and its SHA-256"]);
}

#[test]
fn a_law_reads_files_too() {
    let folder = Folder::new();
    folder.write("gain.csv", "t,k\n0,0\n1,2\n2,2\n");
    folder.write(
        "law.toml",
        r#"
name = "law"
agents = [{ x = 1 }, { x = -1 }]

[timing]
dt = 0.01
duration = 2

[vehicle]
kind = "equations"
states = { x = "m" }
inputs = { u = "m/s" }
d.x = "u"

[topology]
b = 0

[controller]
kind = "formulas"
law.u = 'table("gain.csv", "k", t)*sum(a_ij*(x_j - x))'
signals.gain = 'table("gain.csv", "k", t, "hold")'
"#,
    );
    let mut digests = Vec::new();
    for placement in ["single", "processes"] {
        let log = format!("{placement}.mcap");
        let run = folder.run(&["run", "law.toml", "--placement", placement, "--out", &log, "-q", "--json"]);
        assert_eq!(run.code(), 0, "{placement}: {}", run.stderr());
        digests.push(run.json()["sha256"].as_str().expect("a digest").to_string());
    }
    assert_eq!(digests[0], digests[1]);

    let log = recording::Log::open(&folder.path("processes.mcap")).expect("a log");
    let gain = log.signal("/agent_1/command", "gain").expect("a gain");
    assert_eq!([99, 100].map(|row| gain.row(row)[0]), [0.0, 2.0]);
    // d(x1 - x2)/dt = -2 k(t) (x1 - x2), and the integral of k over two seconds is 3.
    let end = log.signal("/agent_1/state", "x").expect("a state");
    assert!((end.row(end.len() - 1)[0] - (-6.0_f64).exp()).abs() < 5e-4);

    std::fs::remove_file(folder.path("gain.csv")).expect("it is removed");
    let end = folder.run(&["replay", "processes.mcap", "--only", "controller_2"]);
    assert_eq!(end.code(), 0, "{}{}", end.stdout(), end.stderr());
    let end = folder.run(&["validate", "law.toml"]);
    assert!(end.code() == 2 && end.stderr().contains("law.u") && end.stderr().contains("gain.csv"), "{}", end.stderr());
}

#[test]
fn a_log_is_a_data_file() {
    let folder = Folder::new();
    let end = folder.run(&["run", "triangle", "--duration", "2", "--out", "before.mcap", "-q", "--no-check"]);
    assert_eq!(end.code(), 0, "{}", end.stderr());
    let scenario = SCENARIO.replace("figure8.csv\", \"x\"", "before.mcap\", \"/agent_1/state.position[0]\"");
    files(&folder);
    folder.write("files.toml", &scenario);
    let end = folder.run(&["run", "files.toml", "--out", "after.mcap", "-q", "--duration", "2"]);
    assert_eq!(end.code(), 0, "{}", end.stderr());

    let open = |log: &str| recording::Log::open(&folder.path(log)).expect("a log");
    let (before, after) = (open("before.mcap"), open("after.mcap"));
    let (state, reference) =
        (before.signal("/agent_1/state", "position"), after.signal("/agent_2/reference", "position"));
    let (state, reference) = (state.expect("a state"), reference.expect("a reference"));
    for row in [0, 37, 200] {
        assert!((state.row(row)[0] - reference.row(row)[0]).abs() < 1e-12, "row {row}");
    }

    folder.write("files.toml", &scenario.replace("state.position[0]", "state.positoin[0]"));
    let end = folder.run(&["validate", "files.toml"]);
    assert!(end.code() == 2 && end.stderr().contains("did you mean `position`?"), "{}", end.stderr());
}
