//! An emulated robot at the other end of real sockets, as a program of its own.

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};

use crate::program::{Folder, wait_until};

/// `phalanx robot`; ended with the test.
pub(crate) struct Robot {
    process: Child,
    pub(crate) address: String,
}

impl Robot {
    /// Robot 2 of the scenario `compensated`, which listens at `listen`.
    pub(crate) fn start(folder: &Folder, listen: &str, record: &str) -> Self {
        Self::with(folder, &["--scenario", "compensated", "--agent", "2", "--listen", listen, "--record", record])
    }

    /// The robot that these arguments describe.
    pub(crate) fn with(folder: &Folder, arguments: &[&str]) -> Self {
        let mut command = folder.phalanx(&[&["robot"], arguments].concat());
        let mut process = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().expect("an emulator");
        let mut line = String::new();
        BufReader::new(process.stdout.take().expect("its output")).read_line(&mut line).expect("a line");
        let (_, address) = line.trim().split_once("listens at ").expect("its address");
        Self { address: address.to_string(), process }
    }

    /// Kills it.
    pub(crate) fn kill(&mut self) {
        self.process.kill().and_then(|()| self.process.wait()).expect("a running emulator");
    }

    /// A robot.toml for it.
    pub(crate) fn settings(&self, folder: &Folder, more: &str) {
        folder.write("robot2.toml", &settings(&self.address, "127.0.0.1:0", more));
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The text of a robot.toml of robot 2.
pub(crate) fn settings(robot: &str, mocap: &str, more: &str) -> String {
    format!("robot = \"{robot}\"\nmocap = \"{mocap}\"\nbody = 2\n{more}")
}

/// The largest wheel speed in the last recorded tick, m/s.
fn last_speed(folder: &Folder, record: &str) -> Option<f64> {
    let text = std::fs::read_to_string(folder.path(record)).ok()?;
    let (complete, _) = text.rsplit_once('\n')?;
    let row: Vec<f64> = complete.lines().last()?.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
    Some(row.get(4..7)?.iter().fold(0.0, |largest: f64, speed| largest.max(speed.abs())))
}

/// Waits until the robot drives.
pub(crate) fn drives(folder: &Folder, record: &str) {
    wait_until("the robot drives", || last_speed(folder, record) > Some(0.01));
}

/// Waits until it stands.
pub(crate) fn stands(folder: &Folder, record: &str) {
    wait_until("the robot stands", || last_speed(folder, record).is_some_and(|speed| speed < 1e-6));
}

/// A run in which robot 2 of `compensated` is the one that robot2.toml describes.
pub(crate) const REAL: [&str; 9] =
    ["run", "compensated", "--dt", "0.02", "--realtime", "--swap", "plant.2=hardware:robot2.toml", "--out", "a.mcap"];
