//! Every participant can be exchanged by one option: by a program, a recording, or a robot.

use std::path::Path;

use recording::Log;

use crate::own_programs::{compile, library_folder, python, root};
use crate::program::{Finished, Folder};
use crate::robot::{Robot, settings};

/// The SHA-256 of the log of a run that is short.
fn digest(run: &Finished) -> String {
    assert!(run.code() <= 1, "{}", run.stderr());
    run.json()["sha256"].as_str().expect("a digest").to_string()
}

#[test]
fn one_option_exchanges_a_program_a_recording_or_a_robot() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("runs")).expect("a folder");
    let short = ["run", "uav", "--duration", "1", "-q", "--json"];
    let plain = digest(&folder.run(&[&short[..], &["--out", "runs/yesterday.mcap"]].concat()));
    compile(&folder, "examples/controller-cpp/controller.cpp", "my_controller");
    for swap in ["controller.3=./my_controller", "controller.1=replay:runs/yesterday.mcap"] {
        let run = folder.run(&[&short[..], &["--swap", swap, "--out", "again.mcap"]].concat());
        assert_ne!(digest(&run), plain, "{swap}: the log names the programs");
        let verify = folder.run(&["verify", "runs/yesterday.mcap", "again.mcap"]);
        assert_eq!(verify.code(), 0, "{swap}: {}", verify.stdout());
    }
    if let Some(python) = python() {
        let new = folder.run(&["new", "observer", "mine", "--lang", "python", "--scenario", "uav"]);
        assert_eq!(new.code(), 0, "{}", new.stderr());
        std::fs::copy(folder.path("mine/main.py"), folder.path("my_observer.py")).expect("a program");
        let mut run = folder.phalanx(&[&short[..], &["--swap", "observer.2=python3 my_observer.py"]].concat());
        let beside = Path::new(&python).parent().expect("a folder").display().to_string();
        let path = format!("{beside}:{}", std::env::var("PATH").unwrap_or_default());
        run.env("PATH", path).env("PYTHONPATH", root().join("python/src"));
        run.env("PHALANX_LIBRARY", library_folder().join("libphalanx.so"));
        assert_ne!(digest(&Finished(run.output().expect("the program starts"))), plain, "it estimates nothing yet");
    }
    let robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    folder.write("robot2.toml", &settings(&robot.address, "127.0.0.1:0", "lost_after = 20\n"));
    let swap = ["--swap", "plant.2=hardware:robot2.toml", "--realtime"];
    let run = folder.run(&[&["run", "compensated", "--duration", "1", "-q"], &swap[..]].concat());
    assert_eq!(run.code(), 0, "{}", run.stderr());
}

#[test]
fn one_plant_per_agent_changes_no_number() {
    let folder = Folder::new();
    // Distances to others decide on links, on forces, and on an assertion.
    for scenario in ["limited-information", "rca", "uav"] {
        let run = |more: &[&str]| folder.run(&[&["run", scenario, "--duration", "1", "-q", "--json"], more].concat());
        let one = run(&["--placement", "single", "--out", "one.mcap"]);
        let many = run(&["--set", "plant.per_agent=true", "--out", "many.mcap"]);
        assert!(one.code() <= 1 && many.code() <= 1, "{scenario}: {}{}", one.stderr(), many.stderr());
        assert_eq!(one.json()["assertions"], many.json()["assertions"], "{scenario}");
        let verify = folder.run(&["verify", "one.mcap", "many.mcap"]);
        assert_eq!(verify.code(), 0, "{scenario}: {}", verify.stdout());
    }
}

#[test]
fn two_robots_with_clocks_of_their_own_fly_beside_four_simulated_ones() {
    let folder = Folder::new();
    // The nearest other agent may be real or not.
    let assertion = "assert=[{ name = \"nobody is near\", metric = \"distance\", min = 0.01 }]";
    let options = ["--swap", "plant.1=emulator:free", "--swap", "plant.4=emulator:free", "--realtime"];
    let options = [&options[..], &["-q", "--json", "--out", "a.mcap"]].concat();
    let run =
        folder.run(&[&["run", "cida", "--duration", "2", "--dt", "0.02", "--set", assertion], &options[..]].concat());
    assert_eq!(run.json()["processes"], 20, "{}", run.stderr());
    let found = run.json()["assertions"].to_string();
    assert!(found.contains("nobody is near"), "{found}");
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    for agent in 1..=6 {
        let health = log.signal(&format!("/agent_{agent}/hardware"), "connected");
        assert_eq!(health.is_some(), agent == 1 || agent == 4, "agent {agent}");
        let position = log.signal(&format!("/agent_{agent}/state"), "position").expect("a position");
        assert_ne!(position.row(0), position.row(100), "agent {agent} moved");
    }
}
