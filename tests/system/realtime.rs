//! What becomes of a robot when the run stalls.

use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::process::Command;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hardware::link::{Link, TcpLink};
use hardware::message::{Message, Pose};
use recording::Log;

use crate::program::{Finished, Folder, children, unique, wait_until};
use crate::robot::settings;

/// A period of the runs here, ns.
const PERIOD: u64 = 20_000_000;

/// A robot that stands still, acknowledges everything, and keeps the stamps of its commands: when the bridge sent them.
struct Robot {
    address: SocketAddr,
    stamps: Arc<Mutex<Vec<u64>>>,
    /// Ends when the bridge has gone.
    gone: Receiver<()>,
}

impl Robot {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let (stamps, (end, gone)) = (Arc::new(Mutex::new(Vec::new())), channel());
        let kept = Arc::clone(&stamps);
        std::thread::spawn(move || {
            let _end = end;
            let (stream, _) = listener.accept().expect("a bridge");
            play(TcpLink::new(stream).expect("a link"), &kept);
        });
        Self { address, stamps, gone }
    }

    fn commands(&self) -> usize {
        self.stamps.lock().expect("the stamps").len()
    }
}

fn play(mut link: TcpLink, stamps: &Mutex<Vec<u64>>) {
    let cameras = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let (mut target, mut frames) = (None, 0);
    loop {
        match link.receive(Duration::from_millis(10)) {
            Ok(Some(frame)) => match Message::of(&frame).expect("a message") {
                Message::Hello { body, port, .. } => {
                    target = Some(("127.0.0.1", port));
                    link.send(&Message::Welcome { body }.frame(0, 0)).expect("a bridge");
                }
                Message::Command { .. } => {
                    stamps.lock().expect("the stamps").push(frame.stamp);
                    let answer = Message::Acknowledge { applies: true, frames };
                    if link.send(&answer.frame(frame.sequence, 0)).is_err() {
                        return;
                    }
                }
                _ => {}
            },
            Ok(None) => {}
            Err(_) => return,
        }
        if let Some(target) = target {
            let pose = Pose { body: 2, valid: true, position: [0.1, 1.4, 0.0], orientation: [0.0; 3] };
            let frame = Message::Pose(pose).frame(frames, u64::from(frames));
            cameras.send_to(&frame.encode(), target).expect("a datagram");
            frames += 1;
        }
    }
}

/// Runs with the robot, and stops the process of another participant for 1.5 s in the meantime. `section` is added to the
/// scenario.
fn stalled(folder: &Folder, robot: &Robot, section: &str) -> Finished {
    folder.write("robot2.toml", &settings(&robot.address.to_string(), "127.0.0.1:0", "lost_after = 50\n"));
    let text = folder.run(&["validate", "compensated", "--dt", "0.02", "--duration", "5", "--print"]).stdout();
    let name = unique("stalled");
    folder.write(
        "stalled.toml",
        &format!("{section}\n{}", text.replace("name = \"compensated\"", &format!("name = \"{name}\""))),
    );
    let arguments = ["run", "stalled.toml", "--realtime", "--swap", "plant.2=hardware:robot2.toml"];
    let run = folder.start(&[&arguments[..], &["-q", "--json", "--out", "a.mcap"]].concat());
    wait_until("the robot gets commands", || robot.commands() > 40);
    let is_first = |pid: &u32| {
        let environment = std::fs::read_to_string(format!("/proc/{pid}/environ")).unwrap_or_default();
        environment.split('\0').any(|entry| entry == "PHALANX_WORKER=0")
    };
    let process = children(run.id()).into_iter().find(is_first).expect("the process of plant 1").to_string();
    let signal = |name: &str| assert!(Command::new("kill").args([name, &process]).status().expect("kill").success());
    signal("-STOP");
    std::thread::sleep(Duration::from_millis(1500));
    signal("-CONT");
    Finished(run.wait_with_output().expect("an end"))
}

/// The most commands that the bridge sent within 0.2 s.
fn densest(robot: &Robot) -> usize {
    let stamps = robot.stamps.lock().expect("the stamps");
    let within =
        |start: usize| stamps[start..].iter().take_while(|stamp| **stamp < stamps[start] + 10 * PERIOD).count();
    (0..stamps.len()).map(within).max().unwrap_or(0)
}

#[test]
fn after_a_stall_a_robot_gets_one_command_per_period_and_no_step_is_lost() {
    let (folder, robot) = (Folder::new(), Robot::start());
    let end = stalled(&folder, &robot, "");
    assert_eq!(end.code(), 0, "{}", end.stderr());
    let gone = robot.gone.recv_timeout(Duration::from_secs(20));
    assert_eq!(gone, Err(RecvTimeoutError::Disconnected), "the bridge is still there");
    assert!(densest(&robot) <= 11, "{} commands within ten periods", densest(&robot));
    let json = end.json();
    let skipped = json["pace"]["skipped"].as_u64().expect("a count");
    // Half a period of the stall may have been waited for anyway.
    assert!(skipped >= 70, "{skipped} periods were skipped");
    assert!(json["wall_s"].as_f64() >= Some(5.0 + 70.0 * 0.02), "{}", json["wall_s"]);
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    assert_eq!(log.times().len(), 251);
    let logged = log.signal("/phalanx/pace", "skipped").expect("the pace");
    assert_eq!(logged.row(250), [skipped as f64]);
}

#[test]
fn a_run_that_catches_up_does_not_hand_the_burst_on_to_the_robot() {
    let (folder, robot) = (Folder::new(), Robot::start());
    let end = stalled(&folder, &robot, "realtime = { overrun = \"catch_up\" }");
    assert_eq!(end.code(), 0, "{}", end.stderr());
    assert!(densest(&robot) <= 11, "{} commands within ten periods", densest(&robot));
    assert_eq!(end.json()["pace"]["skipped"], 0);
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    let left_out = log.signal("/agent_2/hardware", "too_soon").expect("how the robot is");
    assert!(left_out.row(250)[0] >= 50.0, "{:?} commands were left out", left_out.row(250));
}

#[test]
fn a_run_that_must_not_be_late_ends_with_the_step_that_is() {
    let (folder, robot) = (Folder::new(), Robot::start());
    let end = stalled(&folder, &robot, "realtime = { overrun = \"abort\" }");
    assert_eq!(end.code(), 3, "{}", end.stderr());
    let text = end.stderr();
    assert!(text.contains("the run stopped: step ") && text.contains("overrun = \"abort\""), "{text}");
    assert!(Log::open(&folder.path("a.mcap")).expect("a log").times().len() > 40);
}

#[test]
fn what_to_do_about_late_steps_is_checked() {
    let folder = Folder::new();
    let text = folder.run(&["validate", "compensated", "--print"]).stdout();
    folder.write("wrong.toml", &format!("realtime = {{ overrun = \"hurry\" }}\n{text}"));
    let refused = folder.run(&["validate", "wrong.toml"]);
    assert_eq!(refused.code(), 2);
    let text = refused.stderr();
    assert!(text.contains("realtime.overrun") && text.contains("skip") && text.contains("catch_up"), "{text}");
}
