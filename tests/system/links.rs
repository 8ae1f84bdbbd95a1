//! Links between agents: delay, loss, rates, and what is seen of them.

use std::process::Command;

use recording::Log;
use rustix::process::{Pid, Signal, kill_process};

use crate::own_programs::{compile, library_folder, python, root};
use crate::program::{Finished, Folder, children, wait_until};

/// Consensus of agents on a ring, over links that do everything.
fn scenario(agents: &str, graph: &str, links: &str) -> String {
    format!(
        r#"
name = "links"
seed = 5
agents = [{agents}]

[timing]
dt = 0.01
duration = 20

[vehicle]
kind = "equations"
states = {{ x = "m", y = "m" }}
inputs = {{ u = "m/s", w = "m/s" }}
d.x = "u"
d.y = "w"
position = ["x", "y"]

[topology]
graph = {graph}
b = 0

[controller]
kind = "formulas"
law.u = "sum(a_ij*(x_j - x))"
law.w = "sum(a_ij*(y_j - y))"
signals.age = "sum(state_j.link_age)"

[links]
{links}
"#
    )
}

const FOUR: &str = "{ x = 3, y = 1 }, { x = -1, y = 0 }, { x = 1, y = -2 }, { x = -1, y = 2 }";
const RING: &str = "\"two_way_ring\"";
const EVERYTHING: &str = r#"
delay = { kind = "normal", mean = 0.05, standard_deviation = 0.02 }
reordering = true
loss = { kind = "gilbert_elliott", p = 0.05, r = 0.3 }
rate_hz = 40
noise = { x = 0.01 }
quantum = 0.005
bandwidth = 50000
missing = "linear"
range = 100

[[links.outage]]
from = 2
until = 3
agents = [2]

[links."1 -> *"]
trigger = "norm(x - sent.x) > 0.01*exp(-t) or norm(command.input) > 5"
delay = "0.01 + 0.001*distance + 0.01*(i + j)"

[links."3 -> 4"]
interval = "0.05 + 0.1*abs(x)"
loss = "0.3*step(t - 1)"
"#;

fn log(folder: &Folder, name: &str) -> Log {
    Log::open(&folder.path(name)).expect("a log")
}

/// The last value of a number about a link.
fn at_end(log: &Log, topic: &str, field: &str) -> f64 {
    let signal = log.signal(topic, field).unwrap_or_else(|| panic!("{topic} has no {field}"));
    signal.row(signal.len() - 1)[0]
}

#[test]
fn everything_at_once_is_the_same_in_all_placements() {
    let folder = Folder::new();
    folder.write("links.toml", &scenario(FOUR, RING, EVERYTHING));
    let mut digests = Vec::new();
    for placement in ["single", "agents", "processes"] {
        let name = format!("{placement}.mcap");
        let run = folder.run(&["run", "links.toml", "--placement", placement, "--out", &name, "-q", "--json"]);
        assert_eq!(run.code(), 0, "{placement}: {}", run.stderr());
        digests.push(run.json()["sha256"].as_str().expect("a digest").to_string());
    }
    assert!(digests.iter().all(|digest| *digest == digests[0]), "{digests:?}");
    for only in ["controller_2", "links_state", "plant"] {
        let end = folder.run(&["replay", "processes.mcap", "--only", only]);
        assert_eq!(end.code(), 0, "{only}: {}{}", end.stdout(), end.stderr());
    }
    // What the law asks for is what the link says.
    let log = log(&folder, "single.mcap");
    let asked = log.signal("/agent_2/command", "age").expect("an age");
    let told =
        ["/agent_2/from_1/state", "/agent_2/from_3/state"].map(|topic| log.signal(topic, "link_age").expect("an age"));
    for row in [0, 250, 1999] {
        assert_eq!(asked.row(row)[0], told[0].row(row)[0] + told[1].row(row)[0]);
    }
    // In the outage nothing arrives.
    assert!(told[0].row(299)[0] > 0.9);
}

#[test]
fn what_was_asked_for_is_what_happens() {
    let folder = Folder::new();
    let run = |name: &str, links: &str| {
        folder.write("links.toml", &scenario(FOUR, RING, links));
        let end = folder.run(&["run", "links.toml", "--placement", "single", "--out", name, "-q"]);
        assert_eq!(end.code(), 0, "{}", end.stderr());
        log(&folder, name)
    };
    let topic = "/agent_1/from_2/state";

    let exact = run("delay.mcap", "delay = 0.1");
    let (sent, received) = (exact.signal("/agent_2/state", "x"), exact.signal(topic, "x"));
    let (sent, received) = (sent.expect("a state"), received.expect("what is received"));
    assert!((10..2001).all(|row| received.row(row)[0] == sent.row(row - 10)[0]));
    // Before the first message: as if nothing had happened before.
    assert!((0..10).all(|row| received.row(row)[0] == -1.0));

    let lossy = run("loss.mcap", "loss = 0.2\nrate_hz = 50");
    assert_eq!(at_end(&lossy, topic, "link_sent"), 1001.0);
    let share = at_end(&lossy, topic, "link_lost") / 1001.0;
    assert!((share - 0.2).abs() < 4.0 * (0.16_f64 / 1001.0).sqrt(), "{share}");

    let event = run("event.mcap", "trigger = \"norm(x - sent.x) > 0.1\"");
    let count = at_end(&event, topic, "link_sent");
    assert!((2.0..50.0).contains(&count), "{count}");
    let (sent, received) = (event.signal("/agent_2/state", "x"), event.signal(topic, "x"));
    let (sent, received) = (sent.expect("a state"), received.expect("what is received"));
    assert!((0..2001).all(|row| (sent.row(row)[0] - received.row(row)[0]).abs() <= 0.1));

    // Both directions of a pair fail together, or by themselves.
    for (links, is_together) in [("loss = 0.5\nsymmetric = true", true), ("loss = 0.5", false)] {
        let log = run(if is_together { "pair.mcap" } else { "single.mcap" }, links);
        let lost = [topic, "/agent_2/from_1/state"].map(|topic| log.signal(topic, "link_lost").expect("losses"));
        assert_eq!((0..2001).all(|row| lost[0].row(row) == lost[1].row(row)), is_together);
    }
}

#[test]
fn another_agent_changes_no_random_number() {
    let folder = Folder::new();
    let links = "loss = 0.3\nnoise = 0.1\ndelay = { kind = \"gamma\", shape = 2, scale = 0.01 }";
    let graph = "{ links = [[1, 2], [2, 3], [3, 4], [4, 1]] }";
    let five = format!("{FOUR}, {{ x = 7, y = 7 }}");
    let more = "{ links = [[1, 2], [2, 3], [3, 4], [4, 1], [4, 5], [1, 5]] }";
    for (name, agents, graph) in [("four.mcap", FOUR, graph), ("five.mcap", five.as_str(), more)] {
        let graph = graph.replace("]] }", "]], directed = true }");
        folder.write("links.toml", &scenario(agents, &graph, links));
        let end = folder.run(&["run", "links.toml", "--placement", "single", "--out", name, "-q"]);
        assert_eq!(end.code(), 0, "{}", end.stderr());
    }
    let [four, five] = ["four.mcap", "five.mcap"].map(|name| log(&folder, name));
    for topic in ["/agent_2/from_1/state", "/agent_1/from_4/state"] {
        for field in ["x", "y", "link_age", "link_lost"] {
            let [four, five] = [&four, &five].map(|log| log.signal(topic, field).expect("a signal"));
            assert!((0..2001).all(|row| four.row(row) == five.row(row)), "{topic} {field}");
        }
    }
}

#[test]
fn mistakes_have_their_place() {
    let folder = Folder::new();
    folder.write("trace.csv", "ms,lost\n10,0\n-3,2\n");
    let cases = [
        ("delay = -0.1", "links.delay: expected a time >= 0 s, found -0.1"),
        ("delay = \"0.1*distanc\"", "did you mean `distance`?"),
        ("delay = \"1/(t - t)\"", "its value at t = 0 and distance = 1 is inf"),
        ("delay = 5000", "expected at most 1000 s, 100000 messages on their way, found 5000 s"),
        (
            "delay = { kind = \"uniform\", low = 0.2, high = 0.1 }",
            "links.delay.high: expected a time >= 0.2 s, found 0.1",
        ),
        ("delay = { kind = \"normal\", mean = 0.1, variance = 0.1 }", "links.delay.variance: unknown field"),
        (
            "delay = { kind = \"trace\", file = \"trace.csv\", column = \"ms\", factor = 1e-3 }",
            "expected times >= 0 s, found -0.003",
        ),
        ("delay = { kind = \"trace\", file = \"none.csv\", column = \"ms\" }", "links.delay.file: cannot read"),
        ("loss = 1.5", "links.loss: expected a probability from 0 to 1, found 1.5"),
        (
            "loss = { kind = \"gilbert_elliott\", p = 2, r = 0.1 }",
            "links.loss.p: expected a probability from 0 to 1, found 2",
        ),
        (
            "loss = { kind = \"trace\", file = \"trace.csv\", column = \"lost\" }",
            "links.loss.column: expected 0 or 1, found 2",
        ),
        ("los = 0.1", "did you mean `loss`?"),
        ("rate_hz = 0", "links.rate_hz: expected a rate > 0 Hz, found 0"),
        ("noise = { z = 0.1 }", "no signal is called `z`, expected one of position, velocity, x, y"),
        ("noise = { x = -0.1 }", "links.noise.x: expected a number >= 0, found -0.1"),
        ("trigger = \"norm(x) > \"", "links.trigger"),
        ("trigger = \"sent.z > 1\"", "expected a signal of the sender"),
        ("missing = \"last\"", "links.missing"),
        ("\"2 > 3\" = { delay = 0.1 }", "links.\"2 > 3\": unknown field"),
        ("\"2 -> x\" = { delay = 0.1 }", "expected links such as \"2 -> 5\""),
        ("\"2 -> 9\" = { delay = 0.1 }", "there is no agent 9, only 1-4"),
        ("\"1 -> 2\" = { delay = -1 }", "links.delay: expected a time >= 0 s, found -1"),
        ("outage = [{ from = 3, until = 2 }]", "expected a time > 3 s, found 2"),
        ("outage = [{ from = 3, links = [\"7 -> 1\"] }]", "there is no agent 7"),
        ("carries = [\"states\"]", "did you mean `state`?"),
    ];
    for (links, expected) in cases {
        folder.write("links.toml", &scenario(FOUR, RING, links));
        let end = folder.run(&["validate", "links.toml"]);
        let stderr = end.stderr();
        assert!(
            end.code() == 2 && stderr.contains(expected),
            "{links}: expected {expected:?}, found {}\n{stderr}",
            end.code()
        );
        assert!(stderr.contains("links.toml:"), "{links} has no place: {stderr}");
    }
}

/// A program of the same law in Python.
const PYTHON: &str = r#"
import phalanx

with phalanx.Participant("controller") as me:
    near = me.neighbours()
    x, y = me.state("x"), me.state("y")
    heard = [(me.state("x", agent=j), me.read("plant", "y", agent=j), me.read("plant", "link_age", agent=j)) for j in near]
    u, age = me.output("input"), me.output("age")
    for step in me:
        dx = dy = old = 0.0
        for x_j, y_j, age_j in heard:
            dx += x_j.value[0] - x.value[0]
            dy += y_j.value[0] - y.value[0]
            old += age_j.value[0]
        u.value, age.value = [dx, dy], old
"#;

#[test]
fn programs_of_any_language_hear_what_the_law_hears() {
    let folder = Folder::new();
    folder.write("links.toml", &scenario(FOUR, RING, EVERYTHING));
    folder.write("hears.py", PYTHON);
    let mut programs = vec![compile(&folder, "tests/system/programs/hears.c", "hears")];
    programs.extend(python().map(|python| format!("{python} hears.py")));
    let digest = |swaps: &[String]| {
        let swaps = swaps.iter().flat_map(|swap| ["--swap", swap]);
        let arguments = ["run", "links.toml", "-q", "--out", "links.mcap", "--set", "timing.duration=5"];
        let mut run: Command = folder.phalanx(&arguments.into_iter().chain(swaps).collect::<Vec<_>>());
        run.env("PYTHONPATH", root().join("python/src")).env("PHALANX_LIBRARY", library_folder().join("libphalanx.so"));
        let end = Finished(run.output().expect("the program starts"));
        assert_eq!(end.code(), 0, "{}", end.stderr());
        folder.samples("links.mcap")
    };
    let plain = digest(&[]);
    for program in programs {
        assert_eq!(digest(&[format!("controller.2={program}"), format!("controller.4={program}")]), plain, "{program}");
        let end = folder.run(&["replay", "links.mcap", "--only", "controller.2", "--swap", "controller.2=builtin"]);
        assert_eq!(end.code(), 0, "{}{}", end.stdout(), end.stderr());
    }
}

#[test]
fn a_kill_in_mid_run_changes_nothing() {
    let folder = Folder::new();
    folder.write("links.toml", &scenario(FOUR, RING, EVERYTHING));
    let calm = ["run", "links.toml", "--placement", "single", "-q", "--json", "--out", "calm.mcap"];
    let calm = folder.run(&calm).json()["sha256"].clone();
    let disturbed =
        ["run", "links.toml", "--on-failure", "restart", "--realtime", "10", "-q", "--json", "--out", "disturbed.mcap"];
    let run = folder.start(&disturbed);
    wait_until("the log grows", || {
        std::fs::metadata(folder.path("disturbed.mcap")).is_ok_and(|file| file.len() > 30_000)
    });
    // The last one carries the links.
    let processes = children(run.id());
    for victim in [processes.len() - 1, 2] {
        let pid = Pid::from_raw(processes[victim] as i32).expect("a process id");
        kill_process(pid, Signal::KILL).expect("it runs");
    }
    let end = Finished(run.wait_with_output().expect("an end"));
    assert_eq!(end.json()["sha256"], calm, "{}", end.stderr());
    let replaced = end.json()["replaced"].to_string();
    assert!(replaced.contains("effects") || replaced.contains("links"), "{replaced}");
}

#[test]
fn a_formation_over_a_radio_keeps_its_distances_roughly() {
    let folder = Folder::new();
    let file = root().join("examples/own-systems/pentagon.toml");
    let file = file.to_str().expect("a path");
    for (variant, code) in [("direct", 0), ("radio", 0)] {
        let arguments =
            ["run", file, "--variant", variant, "--placement", "single", "--strict", "-q", "--out", "log.mcap"];
        assert_eq!(folder.run(&arguments).code(), code, "{variant}");
    }
    let links = folder.run(&["links", "log.mcap", "--json"]).json();
    let all = links.as_array().expect("a list");
    assert_eq!(all.len(), 14);
    for link in all {
        let number = |path: &str| link.pointer(path).and_then(serde_json::Value::as_f64).expect("a number");
        assert_eq!((number("/sent"), number("/rate_hz/asked")), (201.0, 10.0));
        assert!((number("/rate_hz/measured") - 10.0).abs() < 1e-9 && (number("/delay_s/measured") - 0.05).abs() < 1e-9);
        assert!((number("/loss/measured") - 0.05).abs() < 4.0 * (0.0475_f64 / 201.0).sqrt(), "{link}");
    }
}
