//! Sensors and actuators: what is seen of the plant, and what becomes of commands.

use recording::Log;

use crate::program::Folder;

/// A unicycle and a double integrator that track a point, with everything that sensors and actuators can do.
fn scenario(sections: &str) -> String {
    format!(
        r#"
name = "instruments"
seed = 9
agents = [{{ vehicle = "mass", p = 1, v = 0 }}, {{ vehicle = "mass", p = -1, v = 0 }}, {{ vehicle = "robot", x = 1, y = 0, theta = 0 }}]

[timing]
dt = 0.01
duration = 10

[vehicles.mass]
kind = "equations"
states = {{ p = "m", v = "m/s" }}
inputs = {{ u = "m/s^2" }}
d.p = "v"
d.v = "u"
position = ["p"]
outputs.energy = "v^2/2"
outputs.force = "2*u"

[vehicles.robot]
kind = "equations"
states = {{ x = "m", y = "m", theta = "rad" }}
inputs = {{ s = "m/s", omega = "rad/s" }}
d.x = "s*cos(theta)"
d.y = "s*sin(theta)"
d.theta = "omega"
angles = ["theta"]
position = ["x", "y"]

[controller]
kind = "formulas"
laws.mass.u = "-position[0] - 1.4*v"
laws.robot.s = "-x"
laws.robot.omega = "0.1 - 0.2*theta"

{sections}
"#
    )
}

const EVERYTHING: &str = r#"
[sensors."1,2".p]
noise = 0.01
noise_density = 0.001
bias = 0.02
bias_walk = 0.001
bias_instability = 0.01
bias_time = 3
outliers = 0.01
outlier_size = 0.5
quantum = 0.001
min = -5
max = 5
rate_hz = 50
dropout = 0.05
delay = 0.03

[sensors."2".v]
noise = 0.1

[sensors."3".position]
noise = 0.05

[sensors."3".theta]
scale = 0.1

[actuators]
lag = 0.05
max = 0.8
min = -0.8
quantum = 0.01

[actuators."3"]
lag = 0
natural_frequency = 20
damping = 0.7
rate_limit = 5

[actuators."3".omega]
stuck_from = 5
"#;

fn run(folder: &Folder, sections: &str, log: &str) -> Log {
    folder.write("instruments.toml", &scenario(sections));
    let end = folder.run(&["run", "instruments.toml", "--placement", "single", "--out", log, "-q"]);
    assert_eq!(end.code(), 0, "{}", end.stderr());
    Log::open(&folder.path(log)).expect("a log")
}

fn column(log: &Log, topic: &str, field: &str) -> Vec<f64> {
    let signal = log.signal(topic, field).unwrap_or_else(|| panic!("{topic} has no {field}"));
    (0..signal.len()).map(|row| signal.row(row)[0]).collect()
}

#[test]
fn everything_at_once_is_the_same_in_all_placements() {
    let folder = Folder::new();
    folder.write("instruments.toml", &scenario(EVERYTHING));
    let digests = ["single", "agents", "processes"].map(|placement| {
        let name = format!("{placement}.mcap");
        let end = folder.run(&["run", "instruments.toml", "--placement", placement, "--out", &name, "-q", "--json"]);
        assert_eq!(end.code(), 0, "{placement}: {}", end.stderr());
        end.json()["sha256"].as_str().expect("a digest").to_string()
    });
    assert!(digests.iter().all(|digest| *digest == digests[0]), "{digests:?}");
    for only in ["controller_2", "sensors", "actuators", "plant"] {
        let end = folder.run(&["replay", "processes.mcap", "--only", only]);
        assert_eq!(end.code(), 0, "{only}: {}{}", end.stdout(), end.stderr());
    }
}

#[test]
fn what_follows_from_a_measured_state_follows() {
    let folder = Folder::new();
    let log = run(
        &folder,
        "[sensors.\"1\".p]\nbias = 0.5\n[sensors.\"1\".v]\nscale = 1\n[sensors.\"3\".position]\nbias = 2",
        "seen.mcap",
    );
    let [truth, seen] = ["/agent_1/state", "/agent_1/measured/state"]
        .map(|topic| ["p", "v", "position", "velocity", "energy", "force"].map(|field| column(&log, topic, field)));
    for row in [1, 100, 700] {
        assert_eq!(seen[0][row], truth[0][row] + 0.5);
        assert_eq!(seen[1][row], 2.0 * truth[1][row]);
        // The position is p, its velocity v, the energy v^2/2; the force depends on the input, which no state tells.
        assert_eq!([seen[2][row], seen[3][row]], [seen[0][row], seen[1][row]]);
        assert!((seen[4][row] - 4.0 * truth[4][row]).abs() < 1e-12);
        assert_eq!(seen[5][row], truth[5][row]);
    }
    // The law of agent 1 uses what is measured, and that of agent 2 what is true.
    let command = column(&log, "/agent_1/command", "input");
    assert_eq!(command[300], -seen[2][300] - 1.4 * seen[1][300]);
    // A measured position is that of its states.
    let [x, seen] = [column(&log, "/agent_3/state", "x"), column(&log, "/agent_3/measured/state", "x")];
    assert_eq!(seen[500], x[500] + 2.0);
}

#[test]
fn commands_become_what_actuators_make_of_them() {
    let folder = Folder::new();
    let log = run(
        &folder,
        "[actuators]\nmin = -0.3\n[actuators.\"2\"]\nmin = -100\neffectiveness = 0.5\neffectiveness_from = 2",
        "acts.mcap",
    );
    let [asked, acts] = ["/agent_1/command", "/agent_1/applied/command"].map(|topic| column(&log, topic, "input"));
    assert!(asked.iter().zip(&acts).all(|(asked, acts)| *acts == asked.max(-0.3)));
    assert!(asked.iter().any(|asked| *asked < -0.3));
    let [asked, acts] = ["/agent_2/command", "/agent_2/applied/command"].map(|topic| column(&log, topic, "input"));
    for (row, (asked, acts)) in asked.iter().zip(&acts).enumerate() {
        assert_eq!(*acts, if row < 200 { *asked } else { 0.5 * asked }, "{row}");
    }
    // The plant of agent 1 has moved as the actuator says: dv/dt = u.
    let v = column(&log, "/agent_1/state", "v");
    let acts = column(&log, "/agent_1/applied/command", "input");
    assert!((0..1000).all(|row| (v[row + 1] - v[row] - 0.01 * acts[row]).abs() < 1e-12));
}

#[test]
fn mistakes_have_their_place() {
    let folder = Folder::new();
    let cases = [
        ("[sensors.q]\nnoise = 1", "sensors.q: the plant publishes no signal of this name"),
        ("[sensors.\"1\".p]\nnois = 1", "did you mean `noise`?"),
        ("[sensors.\"1\".p]\nnoise = -1", "sensors.p.noise: expected a number >= 0, found -1"),
        ("[sensors.\"1\".p]\ndropout = 1.5", "sensors.p.dropout: expected a number from 0 to 1, found 1.5"),
        ("[sensors.\"1\".p]\ndelay = 1e9", "sensors.p.delay: expected at most 100000 steps"),
        ("[sensors.\"7\".p]\nnoise = 1", "sensors.7: there is no agent 7, only 1-3"),
        ("[sensors]\nnoise = 1", "sensors.noise: the plant publishes no signal of this name"),
        ("[actuators]\nlag = -1", "actuators.lag: expected a number >= 0, found -1"),
        ("[actuators]\nmax = 1\nmin = 2", "actuators.min: expected a number < max = 1, found 2"),
        ("[actuators.\"1\".w]\nlag = 1", "the vehicle has no input of this name, expected one of u"),
        ("[actuators]\nlag = \"slow\"", "actuators.lag"),
    ];
    for (sections, expected) in cases {
        folder.write("instruments.toml", &scenario(sections));
        let end = folder.run(&["validate", "instruments.toml"]);
        let stderr = end.stderr();
        assert!(
            end.code() == 2 && stderr.contains(expected),
            "{sections}: expected {expected:?}, found {}\n{stderr}",
            end.code()
        );
        assert!(stderr.contains("instruments.toml:"), "{sections} has no place: {stderr}");
    }
}
