//! Robots behind sockets in the place of plants.

use std::time::Duration;

use hardware::link::{Connector, TcpConnector};
use hardware::message::{Clock, Message};
use recording::Log;

use crate::own_programs::compile;
use crate::program::{Finished, Folder};
use crate::robot::{REAL, Robot, drives, settings, stands};

const EXPERIMENT: [&str; 4] = ["run", "compensated-experiment", "-q", "--json"];

#[test]
fn sockets_change_no_bit() {
    let folder = Folder::new();
    let run = |more: &[&str]| folder.run(&[&EXPERIMENT[..], &["--duration", "20"], more].concat());
    let apart = run(&["--out", "a.mcap"]);
    let json = apart.json();
    assert_eq!(json["processes"], 11, "{}", apart.stderr());
    assert_eq!(json["sha256"], run(&["--out", "b.mcap", "--placement", "single"]).json()["sha256"]);
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    assert!(log.samples("/agent_1/hardware").is_none() && log.samples("/phalanx/pace").is_none());
    let status = log.signal("/agent_1/state", "status").expect("a status");
    // Robot 1 is not seen from 18.0 to 18.5 s; what arrives at a control tick was captured one period before.
    let held: Vec<usize> = (1..status.len()).filter(|&step| status.row(step) == [1.0]).collect();
    assert_eq!((held.first(), held.last(), held.len()), (Some(&901), Some(&925), 25), "{held:?}");
}

#[test]
fn a_robot_has_one_controller() {
    let folder = Folder::new();
    let robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    robot.settings(&folder, "");
    let mut link =
        TcpConnector(robot.address.parse().expect("an address")).connect(Duration::from_secs(5)).expect("a connection");
    let hello = Message::Hello { body: 2, inputs: 3, period: 20_000_000, clock: Clock::Lockstep, port: 0 };
    link.send(&hello.frame(0, 0)).expect("sent");
    let answer = link.receive(Duration::from_secs(5)).expect("a link").expect("an answer");
    assert_eq!(Message::of(&answer), Ok(Message::Welcome { body: 2 }));
    let second = folder.run(&[&REAL[..], &["-q"]].concat());
    assert_eq!(second.code(), 3);
    assert!(second.stderr().contains("refuses: another controller has it, from 127.0.0.1:"), "{}", second.stderr());
    // It still listens to the first.
    let inputs = [0.1, 0.0, 0.0, 0.0];
    link.send(&Message::Command { count: 3, inputs }.frame(1, 0)).expect("sent");
    let answer = link.receive(Duration::from_secs(5)).expect("a link").expect("an answer");
    assert_eq!(Message::of(&answer), Ok(Message::Acknowledge { applies: true, frames: 2 }));
}

/// The messages of the topic of events, one after the other.
fn events(folder: &Folder) -> Vec<u8> {
    let file = std::fs::read(folder.path("a.mcap")).expect("a log");
    let messages = mcap::MessageStream::new(&file).expect("a log").map(|message| message.expect("a message"));
    messages
        .filter(|message| message.channel.topic == "/phalanx/events")
        .flat_map(|message| message.data.to_vec())
        .collect()
}

#[test]
fn a_robot_that_is_started_again_is_connected_again() {
    let folder = Folder::new();
    let mut robot = Robot::start(&folder, "127.0.0.1:0", "first.csv");
    robot.settings(&folder, "lost_after = 50\n");
    let run = folder.start(&[&REAL[..], &["--duration", "8", "-q"]].concat());
    drives(&folder, "first.csv");
    robot.kill();
    std::thread::sleep(Duration::from_millis(300));
    let _again = Robot::start(&folder, &robot.address, "second.csv");
    drives(&folder, "second.csv");
    let end = Finished(run.wait_with_output().expect("an end"));
    // The ranges of the scenario are not meant for this.
    assert_eq!(end.code(), 0, "{}", end.stderr());
    let text = end.stderr();
    assert!(text.contains("connection lost") && text.contains("connected again"), "{text}");
    assert!(text.contains(" 1 reconnections"), "{text}");
    stands(&folder, "second.csv");
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    let status = log.signal("/agent_2/state", "status").expect("a status");
    let statuses: Vec<f64> = status.component(0).collect();
    assert_eq!(statuses.len(), 401);
    // The last pose stood for as long as the robot was away: at least ten samples in a row. Then it was there again.
    let held = statuses.windows(10).position(|ten| ten.iter().all(|status| *status == 1.0)).expect("a gap in the log");
    assert!(statuses[held..].contains(&0.0), "no pose came after the gap");
    let connected = log.signal("/agent_2/hardware", "connected").expect("how the robot is");
    assert!(connected.component(0).any(|flag| flag == 0.0) && connected.row(400) == [1.0]);
    let text = String::from_utf8_lossy(&events(&folder)).into_owned();
    assert!(text.contains("the connection to the robot is lost") && text.contains("connected again"), "{text}");
    let others = log.signal("/agent_1/state", "status").expect("a status");
    assert!(others.component(0).all(|status| status == 0.0), "the others went on");
}

#[test]
fn a_robot_takes_the_commands_of_a_program_of_the_user() {
    let folder = Folder::new();
    let robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    robot.settings(&folder, "");
    let source = folder.write(
        "still.c",
        "#include <phalanx.h>\nint main(void) {\nphalanx_participant *me = phalanx_open(\"controller\");\n\
         const int input = phalanx_output(me, 0, \"input\", 3);\nwhile (phalanx_next(me)) {\n\
         double *u = phalanx_write(me, input);\nfor (int j = 0; j < 3; ++j) u[j] = 0.0;\nphalanx_done(me);\n}\n\
         return phalanx_close(me);\n}\n",
    );
    let program = compile(&folder, source.to_str().expect("a path"), "still");
    let swap = format!("controller.2={program}");
    let run = folder.run(&[&REAL[..], &["--duration", "1", "-q", "--swap", &swap]].concat());
    assert!(run.code() <= 1, "{}", run.stderr());
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    let connected = log.signal("/agent_2/hardware", "connected").expect("how the robot is");
    assert_eq!(connected.row(50), [1.0]);
    stands(&folder, "truth.csv");
}

#[test]
fn an_emergency_stop_stops_the_robot() {
    let folder = Folder::new();
    let robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    robot.settings(&folder, "");
    let text = folder.run(&["validate", "compensated", "--dt", "0.02", "--duration", "80", "--print"]).stdout();
    folder.write("estop.toml", &text.replace("name = \"compensated\"", "name = \"estop-test\""));
    let arguments = ["run", "estop.toml", "--realtime", "--swap", "plant.2=hardware:robot2.toml", "-q"];
    let run = folder.start(&arguments);
    drives(&folder, "truth.csv");
    let told = folder.run(&["ctl", "estop", "estop-test"]);
    assert_eq!(told.code(), 0, "{}", told.stderr());
    let end = Finished(run.wait_with_output().expect("an end"));
    assert_eq!(end.code(), 3, "{}", end.stderr());
    assert!(end.stderr().contains("emergency stop at step"), "{}", end.stderr());
    stands(&folder, "truth.csv");
}

#[test]
fn a_robot_stops_when_everybody_else_dies() {
    let folder = Folder::new();
    let robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    robot.settings(&folder, "");
    let mut run = folder.start(&[&REAL[..], &["--duration", "80", "-q"]].concat());
    drives(&folder, "truth.csv");
    run.kill().and_then(|()| run.wait()).expect("a running program");
    stands(&folder, "truth.csv");
}

#[test]
fn feedback_that_is_lost_for_good_ends_the_run() {
    let folder = Folder::new();
    let mut robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    robot.settings(&folder, "lost_after = 0.4\n");
    let run = folder.start(&[&REAL[..], &["--duration", "80", "-q"]].concat());
    drives(&folder, "truth.csv");
    robot.kill();
    let end = Finished(run.wait_with_output().expect("an end"));
    assert_eq!(end.code(), 3, "{}", end.stderr());
    assert!(end.stderr().contains("lost_after = 0.4 s"), "{}", end.stderr());
}

#[test]
fn two_robots_are_real_and_four_are_simulated() {
    let folder = Folder::new();
    let arguments = ["run", "cida", "--duration", "1", "-q", "--json", "--out", "a.mcap"];
    let swaps = ["--swap", "plant.1=emulator", "--swap", "plant.4=emulator"];
    let run = folder.run(&[&arguments[..], &swaps].concat());
    assert_eq!(run.json()["processes"], 20, "{}", run.stderr());
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    for agent in 1..=6 {
        let state = log.signal(&format!("/agent_{agent}/state"), "status").expect("a status");
        let held = state.component(0).filter(|status| *status == 1.0).count();
        // At 1000 steps per second, a hundred poses of the cameras come per second; a simulated robot tells its own always.
        let expected = if agent == 1 || agent == 4 { 1001 - 100 } else { 0 };
        assert_eq!(held, expected, "agent {agent}");
    }
}

#[test]
fn the_experiment_runs_in_real_time() {
    let folder = Folder::new();
    let real = ["--variant", "COBFC-realtime", "--realtime", "--duration", "2", "--out", "a.mcap"];
    let run = folder.run(&[&EXPERIMENT[..], &real].concat());
    let json = run.json();
    assert_eq!((json["steps"].as_u64(), json["overruns"].is_u64()), (Some(100), true), "{}", run.stderr());
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    let pace = log.samples("/phalanx/pace").expect("how the steps kept their times");
    let misses = json["pace"]["overruns"].as_u64().expect("a count") as f64;
    assert_eq!((pace.len(), pace.row(100)[2]), (101, misses));
    let worst = pace.component(0).fold(0.0, f64::max);
    assert_eq!(json["pace"]["late_s"]["max"].as_f64(), Some(worst), "{json}");
    for agent in 1..=3 {
        let position = log.signal(&format!("/agent_{agent}/state"), "position").expect("a pose");
        assert_ne!(position.row(0), position.row(100), "robot {agent} moved");
    }
}

#[test]
fn a_robot_is_held_against_the_recording_of_another_flight() {
    let folder = Folder::new();
    let record =
        |more: &[&str]| folder.run(&[&["run", "compensated", "--duration", "1", "-q", "--out"], more].concat());
    assert_eq!(record(&["a.mcap", "--swap", "plant.2=emulator"]).code(), 0);
    let replay = |log: &str| folder.run(&["replay", log, "--only", "plant.2", "--swap", "plant.2=emulator"]);
    let same = replay("a.mcap");
    assert_eq!(same.code(), 0, "{}{}", same.stdout(), same.stderr());
    assert!(same.stdout().starts_with("equal: plant_2 gives all 6006 numbers"), "{}", same.stdout());
    // A flight of one simulated plant for all: the robot lags behind.
    assert_eq!(record(&["b.mcap"]).code(), 0);
    let other = replay("b.mcap");
    assert_eq!(other.code(), 1, "{}", other.stderr());
    assert!(other.stdout().contains("/agent_2/state position"), "{}", other.stdout());
}

#[test]
fn what_cannot_be_is_refused_before_anything_starts() {
    let folder = Folder::new();
    folder.write("robot2.toml", "robot = \"127.0.0.1:1\"\nmocap = \"127.0.0.1:0\"\nbody = 2\nwatchdog = 1\n");
    let refused = |arguments: &[&str], reason: &str| {
        let run = folder.run(arguments);
        assert_eq!(run.code(), 2, "{}", run.stderr());
        assert!(run.stderr().contains(reason), "{}", run.stderr());
    };
    refused(&REAL, "robot2.toml:4:1: watchdog: unknown field");
    folder.write("robot2.toml", "robot = \"127.0.0.1:1\"\nmocap = \"127.0.0.1:0\"\nbody = 2\nstart_patience = 1\n");
    refused(&["run", "compensated", "--swap", "plant.2=hardware:robot2.toml"], "add --realtime");
    refused(&["run", "compensated", "--swap", "plant=emulator"], "such as plant.2");
    refused(&["run", "uav", "--swap", "plant.2=emulator"], "cannot be emulated");
    refused(&["robot", "robot2.toml"], "missing section `[emulator]`");
    let nobody = folder.run(&REAL);
    assert_eq!(nobody.code(), 3);
    assert!(nobody.stderr().contains("no robot answers at 127.0.0.1:1"), "{}", nobody.stderr());
}

#[test]
fn a_robot_that_is_switched_on_late_is_waited_for() {
    let folder = Folder::new();
    // A free port: that of a socket which is closed again.
    let port = std::net::TcpListener::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("an address");
    folder.write("robot2.toml", &settings(&port.to_string(), "127.0.0.1:0", "start_patience = 60\n"));
    let run = folder.start(&[&REAL[..], &["--duration", "0.5", "-q", "--deadline", "60"]].concat());
    std::thread::sleep(std::time::Duration::from_millis(800));
    let _robot = Robot::start(&folder, &port.to_string(), "truth.csv");
    let end = Finished(run.wait_with_output().expect("an end"));
    // So short a run misses its ranges.
    assert_eq!(end.code(), 0, "{}", end.stderr());
}
