//! The robot itself, its clock, and the cameras that watch it.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use formation::scenario::Context;
use plant::Laboratory;
use plant::laboratory::{LaboratoryRobot, Sighting};

use super::{Options, Terms, since};
use crate::message::{Clock, Message, Pose};

/// More ticks at a time are not caught up with: the machine was asleep.
const MOST_TICKS: u64 = 2000;

pub(super) struct Body {
    number: u32,
    robot: LaboratoryRobot,
    /// The robot at its start.
    parked: LaboratoryRobot,
    /// Length of a tick, ns.
    tick: u64,
    cameras: UdpSocket,
    /// Where poses go whatever the controller says.
    target: Option<SocketAddr>,
    /// Where they go now.
    poses: Option<SocketAddr>,
    /// Number of the next pose frame.
    next: u32,
    watchdog: Duration,
    record: Option<BufWriter<File>>,
    switched_on: Instant,
    /// When real time began for the robot: at the first command.
    origin: Option<Instant>,
    /// When the newest command came, if it still holds.
    commanded: Option<Instant>,
    /// With the clock on the wall, before the first command: when the cameras look next.
    looking: Option<Instant>,
    camera_period: Duration,
}

impl Body {
    /// Number of inputs of the robots that can be emulated.
    pub(super) const INPUTS: usize = 3;

    pub(super) fn new(
        options: &Options,
        laboratory: &Laboratory,
        context: &Context,
        agent: usize,
        cameras: UdpSocket,
        record: Option<File>,
    ) -> io::Result<Self> {
        let robot = LaboratoryRobot::new(laboratory, context, agent);
        let mut record = record.map(BufWriter::new);
        if let Some(file) = &mut record {
            writeln!(file, "t,x,y,theta,v1,v2,v3")?;
        }
        Ok(Self {
            number: options.body,
            parked: robot.clone(),
            robot,
            tick: laboratory.tick_ns(),
            cameras,
            target: options.poses,
            poses: None,
            next: 0,
            watchdog: lockstep::duration(options.watchdog),
            record,
            switched_on: Instant::now(),
            origin: None,
            commanded: None,
            looking: None,
            camera_period: lockstep::duration(1.0 / laboratory.mocap_hz),
        })
    }

    pub(super) fn number(&self) -> u32 {
        self.number
    }

    /// Number of pose frames so far: that of the newest plus 1.
    pub(super) fn frames(&self) -> u32 {
        self.next
    }

    /// Checks what a controller asks for, and prepares for it.
    pub(super) fn agree(&mut self, body: u32, inputs: u32, terms: &Terms) -> Result<(), String> {
        if body != self.number {
            return Err(format!("this is robot {}, not {body}", self.number));
        }
        if inputs as usize != Self::INPUTS {
            return Err(format!("this robot has {} inputs, not {inputs}", Self::INPUTS));
        }
        if terms.clock == Clock::Lockstep {
            if terms.period == 0 || !terms.period.is_multiple_of(self.tick) || !terms.start.is_multiple_of(self.tick) {
                return Err(format!("{} ns are no whole number of ticks of {} ns", terms.period, self.tick));
            }
            let tick = terms.start / self.tick;
            if tick < self.robot.tick() {
                (self.robot, self.next) = (self.parked.clone(), 0);
            }
            if tick > self.robot.tick() {
                self.robot.skip_to(tick);
            }
            (self.origin, self.looking) = (None, None);
        } else if self.origin.is_none() {
            self.robot = self.parked.clone();
            self.looking = Some(Instant::now());
        }
        self.poses = self.target.or(terms.poses);
        Ok(())
    }

    /// A command; in lockstep its period passes now.
    pub(super) fn command(&mut self, stamp: u64, inputs: [f64; 3], terms: &Terms) -> Result<(), String> {
        if terms.clock == Clock::Lockstep {
            let time = self.robot.tick() * self.tick;
            if stamp != time {
                return Err(format!("a command for {stamp} ns, but it is {time} ns"));
            }
            self.robot.command(inputs);
            for _ in 0..terms.period / self.tick {
                self.advance();
                self.show();
            }
            return Ok(());
        }
        if self.origin.is_none() {
            (self.origin, self.looking) = (Some(Instant::now()), None);
        }
        self.commanded = Some(Instant::now());
        self.robot.command(inputs);
        Ok(())
    }

    /// Simulated time in lockstep, else time since the emulator was started, ns.
    pub(super) fn time(&self, terms: &Terms) -> u64 {
        match terms.clock {
            Clock::Lockstep => self.robot.tick() * self.tick,
            Clock::Wall => since(self.switched_on),
        }
    }

    /// Stops the motors.
    pub(super) fn halt(&mut self) {
        self.commanded = None;
        self.robot.halt();
    }

    /// How long until time wants something; `None` if it does not pass by itself.
    pub(super) fn due_in(&self) -> Option<Duration> {
        if let Some(origin) = self.origin {
            let next = Duration::from_nanos((self.robot.tick() + 1) * self.tick);
            return Some(next.saturating_sub(origin.elapsed()));
        }
        self.looking.map(|at| at.saturating_duration_since(Instant::now()))
    }

    /// With the clock on the wall: does what is due. Returns whether the watchdog stopped the robot just now.
    pub(super) fn pass_time(&mut self) -> bool {
        if let Some(at) = self.looking.filter(|at| *at <= Instant::now()) {
            self.looking = Some(at + self.camera_period);
            self.show_pose(Some(self.parked.pose()), since(self.switched_on));
        }
        let Some(origin) = self.origin else { return false };
        let late = self.commanded.is_some_and(|at| at.elapsed() > self.watchdog);
        if late {
            self.halt();
        }
        let due = since(origin) / self.tick;
        for _ in 0..due.saturating_sub(self.robot.tick()).min(MOST_TICKS) {
            self.advance();
        }
        let offset = (origin - self.switched_on).as_nanos() as u64;
        while let Some(sighting) = self.robot.take_sighting() {
            self.show_pose(sighting.pose, offset + sighting.captured * self.tick);
        }
        if due > self.robot.tick() {
            self.origin = Some(origin + Duration::from_nanos((due - self.robot.tick()) * self.tick));
        }
        late
    }

    fn advance(&mut self) {
        self.robot.advance();
        let Some(file) = &mut self.record else { return };
        let [x, y, theta] = self.robot.pose();
        let [v1, v2, v3] = self.robot.motors();
        let time = (self.robot.tick() * self.tick) as f64 / 1e9;
        // A full disk must not stop the robot.
        let _ = writeln!(file, "{time},{x},{y},{theta},{v1},{v2},{v3}");
        if self.robot.tick().is_multiple_of(100) {
            let _ = file.flush();
        }
    }

    /// In lockstep: sends the frames that are due, with their own numbers and times.
    fn show(&mut self) {
        while let Some(Sighting { number, captured, pose, .. }) = self.robot.take_sighting() {
            self.next = number as u32;
            self.show_pose(pose, captured * self.tick);
        }
    }

    fn show_pose(&mut self, pose: Option<[f64; 3]>, stamp: u64) {
        let [x, y, yaw] = pose.unwrap_or_default();
        let (position, orientation) = ([x, y, 0.0], [0.0, 0.0, yaw]);
        let message = Message::Pose(Pose { body: self.number, valid: pose.is_some(), position, orientation });
        if let Some(target) = self.poses {
            // A camera sends whether a host listens or not.
            let _ = self.cameras.send_to(&message.frame(self.next, stamp).encode(), target);
        }
        self.next = self.next.wrapping_add(1);
    }
}
