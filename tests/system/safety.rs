//! Robots stop when they should, whatever happens between them and their run, and no participant reads their true state.

use std::collections::HashSet;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::thread::spawn;
use std::time::Duration;

use recording::Log;
use rustix::process::{Pid, Signal, kill_process};

use crate::program::{Finished, Folder, wait_until};
use crate::robot::{REAL, Robot, drives, settings, stands};

/// A scenario of its own name, beside runs of other tests.
fn renamed(folder: &Folder, name: &str) -> String {
    let text = folder.run(&["validate", "compensated", "--dt", "0.02", "--duration", "80", "--print"]).stdout();
    folder.write(&format!("{name}.toml"), &text.replace("name = \"compensated\"", &format!("name = \"{name}\"")));
    format!("{name}.toml")
}

fn last(log: &Log, topic: &str, field: &str) -> f64 {
    let signal = log.signal(topic, field).unwrap_or_else(|| panic!("{topic} {field}"));
    signal.row(signal.len() - 1)[0]
}

#[test]
fn control_c_stops_the_robot() {
    let folder = Folder::new();
    let robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    robot.settings(&folder, "");
    let run = folder.start(&[&REAL[..], &["--duration", "80", "-q"]].concat());
    drives(&folder, "truth.csv");
    kill_process(Pid::from_raw(run.id() as i32).expect("a process id"), Signal::INT).expect("a running program");
    let end = Finished(run.wait_with_output().expect("an end"));
    assert_ne!(end.code(), 0, "{}", end.stderr());
    stands(&folder, "truth.csv");
}

#[test]
fn a_paused_run_stops_the_robot_and_goes_on_with_it() {
    let folder = Folder::new();
    let robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    robot.settings(&folder, "");
    let scenario = renamed(&folder, "pause-test");
    let swap = ["--realtime", "--swap", "plant.2=hardware:robot2.toml", "--out", "a.mcap", "-q"];
    let run = folder.start(&[&["run", &scenario], &swap[..]].concat());
    drives(&folder, "truth.csv");
    assert_eq!(folder.run(&["ctl", "pause", "pause-test"]).code(), 0);
    stands(&folder, "truth.csv");
    let swapped = folder.run(&["ctl", "swap", "plant.2=/bin/true", "pause-test"]);
    assert!(swapped.code() == 2 && swapped.stderr().contains("it is a robot"), "{}", swapped.stderr());
    assert_eq!(folder.run(&["ctl", "resume", "pause-test"]).code(), 0);
    drives(&folder, "truth.csv");
    assert_eq!(folder.run(&["ctl", "stop", "pause-test"]).code(), 0);
    run.wait_with_output().expect("an end");
    stands(&folder, "truth.csv");
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    assert!(last(&log, "/agent_2/hardware", "watchdog") >= 1.0, "the log tells of the halt");
}

#[test]
fn cameras_that_stay_blind_end_the_run_with_a_robot_that_stands() {
    let folder = Folder::new();
    let fault = "faults = [{ robot = 2, start = 0.8, duration = 1000, kind = \"dropout\" }]";
    let emulator = format!("[emulator]\nscenario = \"compensated\"\nagent = 2\nlaboratory = {{ {fault} }}\n");
    folder.write("there.toml", &settings("127.0.0.1:0", "127.0.0.1:0", &emulator));
    let robot = Robot::with(&folder, &["there.toml", "--record", "truth.csv"]);
    robot.settings(&folder, "lost_after = 0.5\n");
    let end = folder.run(&[&REAL[..], &["--duration", "80", "-q"]].concat());
    assert_eq!(end.code(), 3, "{}", end.stderr());
    assert!(end.stderr().contains("no valid pose of robot 2 for"), "{}", end.stderr());
    stands(&folder, "truth.csv");
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    assert_eq!(last(&log, "/agent_2/state", "status"), 1.0, "the last pose is marked as held");
    assert!(last(&log, "/agent_2/hardware", "not_seen") > 10.0);
}

/// A cable between the bridge and a robot that can be cut: nothing passes then, and neither side is informed.
struct Cable {
    address: String,
    is_cut: Arc<AtomicBool>,
}

impl Cable {
    fn to(robot: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address").to_string();
        let is_cut = Arc::new(AtomicBool::new(false));
        let (robot, cut) = (robot.to_string(), Arc::clone(&is_cut));
        spawn(move || {
            for host in listener.incoming().flatten() {
                let Ok(robot) = TcpStream::connect(&robot) else { continue };
                let back = (robot.try_clone().expect("a socket"), host.try_clone().expect("a socket"));
                let (there, here) = (Arc::clone(&cut), Arc::clone(&cut));
                spawn(move || pass(host, robot, &there));
                spawn(move || pass(back.0, back.1, &here));
            }
        });
        Self { address, is_cut }
    }
}

fn pass(mut from: TcpStream, mut to: TcpStream, is_cut: &AtomicBool) {
    let mut bytes = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut bytes) {
        if !is_cut.load(SeqCst) && to.write_all(&bytes[..count]).is_err() {
            break;
        }
    }
    // The end is passed on, even over a cut cable: the test is about silence before it.
    let _ = to.shutdown(std::net::Shutdown::Both);
}

#[test]
fn a_robot_behind_a_cut_cable_stops_and_is_found_again() {
    let folder = Folder::new();
    let robot = Robot::start(&folder, "127.0.0.1:0", "truth.csv");
    let cable = Cable::to(&robot.address);
    let more = "lost_after = 60\nacknowledge_within = 1.0\n";
    folder.write("robot2.toml", &settings(&cable.address, "127.0.0.1:0", more));
    let scenario = renamed(&folder, "cable-test");
    let swap = ["--realtime", "--swap", "plant.2=hardware:robot2.toml", "--out", "a.mcap", "-q"];
    let run = folder.start(&[&["run", &scenario], &swap[..]].concat());
    drives(&folder, "truth.csv");
    cable.is_cut.store(true, SeqCst);
    // By itself: its connection is still there, and so is that of the bridge.
    stands(&folder, "truth.csv");
    std::thread::sleep(Duration::from_millis(1500));
    cable.is_cut.store(false, SeqCst);
    drives(&folder, "truth.csv");
    assert_eq!(folder.run(&["ctl", "stop", "cable-test"]).code(), 0);
    let end = Finished(run.wait_with_output().expect("an end"));
    let told = end.stderr();
    assert!(told.contains("no command was acknowledged for 1 s") && told.contains("connected again"), "{told}");
    stands(&folder, "truth.csv");
}

/// Passes poses on from one port to another, and does to them what networks do.
fn unruly_network(to: &str) -> String {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let (address, to) = (socket.local_addr().expect("an address").to_string(), to.to_string());
    spawn(move || {
        let (mut bytes, mut kept, mut count) = ([0; 512], None, 0_u32);
        while let Ok(length) = socket.recv(&mut bytes) {
            let frame = bytes[..length].to_vec();
            let send = |frame: &[u8]| drop(socket.send_to(frame, &to));
            count += 1;
            match count % 10 {
                // Twice.
                2 => (0..2).for_each(|_| send(&frame)),
                // Later than the next one.
                4 => kept = Some(frame),
                5 => {
                    send(&frame);
                    kept.take().iter().for_each(|frame| send(frame));
                }
                // Broken, with the sound one behind it.
                7 => {
                    let mut broken = frame.clone();
                    broken[length / 2] ^= 0x10;
                    send(&broken);
                    send(&frame);
                }
                // Never.
                9 => {}
                _ => send(&frame),
            }
        }
    });
    address
}

#[test]
fn poses_that_come_doubled_disordered_or_broken_are_sorted_out() {
    let folder = Folder::new();
    // A free port for the bridge: that of a socket which is closed again.
    let port = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("an address").to_string();
    let network = unruly_network(&port);
    let emulator = "[emulator]\nscenario = \"compensated\"\nagent = 2\n";
    folder.write("there.toml", &settings("127.0.0.1:0", &network, emulator));
    let robot = Robot::with(&folder, &["there.toml", "--record", "truth.csv"]);
    folder.write("robot2.toml", &settings(&robot.address, &port, ""));
    let end = folder.run(&[&REAL[..], &["--duration", "3", "-q"]].concat());
    assert_eq!(end.code(), 0, "{}", end.stderr());
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    for field in ["duplicates", "out_of_order", "malformed", "missing"] {
        assert!(last(&log, "/agent_2/hardware", field) >= 10.0, "{field}: {}", end.stderr());
    }
    let drops = last(&log, "/agent_2/hardware", "out_of_order") + last(&log, "/agent_2/hardware", "missing");
    assert!(last(&log, "/agent_2/hardware", "poses") > drops, "{}", end.stderr());
    // What was taken is where the robot was: no pose goes back by more than noise and a period of driving.
    let position = log.signal("/agent_2/state", "position").expect("poses");
    let steps: Vec<f64> = position.component(0).collect();
    assert!(steps.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.1), "{steps:?}");
}

/// How many numbers of the log are numbers of the true path of the robot, bit by bit.
fn leaks(folder: &Folder, laboratory: &str) -> usize {
    let more = format!(
        "clock = \"lockstep\"\n[emulator]\nscenario = \"compensated\"\nagent = 2\nlaboratory = {{ {laboratory} }}\n"
    );
    folder.write("there.toml", &settings("127.0.0.1:0", "127.0.0.1:0", &more));
    let mut robot = Robot::with(folder, &["there.toml", "--record", "truth.csv"]);
    folder.write("robot2.toml", &settings(&robot.address, "127.0.0.1:0", "clock = \"lockstep\"\n"));
    let run = ["run", "compensated", "--dt", "0.02", "--swap", "plant.2=hardware:robot2.toml", "--out", "a.mcap"];
    let end = folder.run(&[&run[..], &["--duration", "4", "-q"]].concat());
    assert_eq!(end.code(), 0, "{}", end.stderr());
    wait_until("the path is written", || {
        std::fs::read_to_string(folder.path("truth.csv")).is_ok_and(|text| text.lines().count() > 4000)
    });
    robot.kill();
    let text = std::fs::read_to_string(folder.path("truth.csv")).expect("the true path");
    let number = |word: &str| word.parse::<f64>().ok();
    let truth: HashSet<u64> = text
        .lines()
        .flat_map(|line| line.split(',').skip(1).take(3).filter_map(number).map(f64::to_bits).collect::<Vec<_>>())
        .collect();
    assert!(truth.len() > 10_000, "{}", truth.len());
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    let topics = log.channels().iter().filter(|channel| channel.layout.is_some()).map(|channel| &channel.topic);
    let samples: Vec<_> = topics.filter_map(|topic| log.samples(topic)).collect();
    let rows = samples.iter().flat_map(|samples| (1..samples.len()).flat_map(|row| samples.row(row)));
    rows.filter(|number| truth.contains(&number.to_bits())).count()
}

#[test]
fn nothing_of_a_run_is_where_the_robot_truly_is() {
    let folder = Folder::new();
    // Everything that crossed a channel is in the log. With cameras as they are, none of it is a true coordinate ...
    assert_eq!(leaks(&folder, "noise_seed = 3"), 0);
    // ... which would be found: cameras without noise tell the truth.
    assert!(leaks(&folder, "noise_pos = 0, noise_ang = 0") > 500);
}
