//! Signals of one's own, parameters for programs, and names of several participants.

use recording::Log;

use crate::own_programs::{compile, library_folder, python, root};
use crate::program::{Finished, Folder};

const WORLD: &str = r#"
name = "world"
agents = [
    { position = [1, 1, 1], R = 0.1 },
    { position = [2, 2, 2], R = 0.1, with = { scale = 3 } },
    { position = [3, 3, 3], R = 0.1 },
]
[timing]
dt = 0.01
duration = 1
[vehicle]
kind = "integrator"
[topology]
b = 1
[reference]
position = ["i", "i", "0"]
[plant]
kind = "external"
signals = { imu = { size = 3, unit = "m/s^2" } }
with = { scale = 2 }
[planner]
kind = "reference"
[controller]
kind = "consensus"
k_x = 2
k_v = 2
"#;

fn world(folder: &Folder) {
    folder.write("world.toml", WORLD);
    compile(folder, "tests/system/programs/world.c", "world");
}

#[test]
fn a_run_that_nothing_plays_is_refused_with_the_line_to_add() {
    let folder = Folder::new();
    folder.write("world.toml", WORLD);
    let run = folder.run(&["run", "world.toml"]);
    assert_eq!(run.code(), 2, "{}", run.stderr());
    let message = run.stderr();
    assert!(message.contains("world.toml:18:") && message.contains("nothing plays plant"), "{message}");
    assert!(message.contains("\"plant\" = \"python3 my_plant.py\""), "{message}");
    assert!(!folder.path("runs").exists());
}

#[test]
fn one_world_several_worlds_and_a_world_per_agent_give_the_same_numbers() {
    let folder = Folder::new();
    world(&folder);
    let run = |out: &str, swaps: &[&str]| {
        let swaps: Vec<&str> = swaps.iter().flat_map(|swap| ["--swap", swap]).collect();
        let run = folder.run(&[&["run", "world.toml", "-q", "--json", "--out", out], &swaps[..]].concat());
        assert_eq!(run.code(), 0, "{}", run.stderr());
        run.json()["processes"].as_i64().expect("a number")
    };
    // Where the parameter of agent 2 holds, the world must serve agent 2 alone.
    assert_eq!(run("each.mcap", &["plant.*=./world"]), 8);
    assert_eq!(run("groups.mcap", &["plant.1-3=./world", "plant.2=./world"]), 7);
    assert_eq!(run("rest.mcap", &["plant=./world", "plant.2=./world"]), 7);
    for other in ["groups.mcap", "rest.mcap"] {
        let verify = folder.run(&["verify", "each.mcap", other]);
        assert_eq!(verify.code(), 0, "{}", verify.stdout());
    }
    assert_eq!(run("one.mcap", &["plant=./world"]), 6);
    let log = Log::open(&folder.path("each.mcap")).expect("a log");
    let at = |topic: &str, field: &str, step: usize| log.signal(topic, field).expect("a signal").row(step).to_vec();
    for (agent, scale) in [(1, 2.0), (2, 3.0), (3, 2.0)] {
        let before = at(&format!("/agent_{agent}/command"), "input", 9);
        let imu = at(&format!("/agent_{agent}/state"), "imu", 10);
        assert_eq!(imu, before.iter().map(|u| scale * u).collect::<Vec<_>>(), "agent {agent}");
    }
    let conform = folder.run(&["conform", "plant", "--scenario", "world.toml", "--steps", "20", "--", "./world"]);
    assert_eq!(conform.code(), 0, "{}{}", conform.stdout(), conform.stderr());
    let replay = folder.run(&["replay", "groups.mcap", "--only", "plant.1,3", "--swap", "plant.1,3=./world"]);
    assert_eq!(replay.code(), 0, "{}{}", replay.stdout(), replay.stderr());
}

#[test]
fn a_program_of_another_size_is_refused_with_both() {
    let folder = Folder::new();
    world(&folder);
    let text = WORLD.replace("signals = {", "standard = false\nsignals = { position = 4, velocity = 3,");
    let text = text.replace("kind = \"consensus\"\nk_x = 2\nk_v = 2", "kind = \"external\"\nreads = []");
    folder.write("world.toml", &text);
    let run = folder.run(&["run", "world.toml", "-q", "--swap", "plant=./world", "--swap", "controller=sleep 60"]);
    assert_eq!(run.code(), 3, "{}", run.stderr());
    assert!(run.stderr().contains("the output `position` (3)"), "{}", run.stderr());
    assert!(run.stderr().contains("position (4)"), "{}", run.stderr());
}

#[test]
fn the_predictive_controllers_give_the_same_bytes_in_every_placement() {
    let Some(python) = python() else { return };
    let folder = Folder::new();
    let example = root().join("examples/mpc-python");
    let scenario = std::fs::read_to_string(example.join("formation.toml")).expect("the example");
    folder.write("formation.toml", &scenario.replace("python3", &python));
    std::fs::copy(example.join("mpc.py"), folder.path("mpc.py")).expect("the program");
    let run = |placement: &str| {
        let out = format!("{placement}.mcap");
        let mut run =
            folder.phalanx(&["run", "formation.toml", "-q", "--json", "--placement", placement, "--out", &out]);
        run.env("PYTHONPATH", root().join("python/src")).env("PHALANX_LIBRARY", library_folder().join("libphalanx.so"));
        let run = Finished(run.output().expect("the program starts"));
        assert_eq!(run.code(), 0, "{}{}", run.stdout(), run.stderr());
        run.json()["sha256"].as_str().expect("a digest").to_string()
    };
    let [processes, agents, single] = ["processes", "agents", "single"].map(run);
    assert_eq!((&agents, &single), (&processes, &processes));
    let log = Log::open(&folder.path("single.mcap")).expect("a log");
    let plan = log.signal("/agent_2/command", "plan").expect("a plan");
    let position = log.signal("/agent_2/state", "position").expect("a position");
    // What is predicted a step ahead happens.
    assert!((plan.row(100)[0] - position.row(101)[0]).abs() < 1e-9);
}
