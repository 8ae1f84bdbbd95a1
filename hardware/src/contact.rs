//! What the bridge knows of its robot, and how it speaks with it.

use lockstep::Period;
use std::io;
use std::net::UdpSocket;
use std::time::{Duration, Instant};

use crate::frame::{Frame, MAX_FRAME};
use crate::link::{Connector, Link, LinkError, wait_readable};
use crate::message::{Clock, MAX_INPUTS, Message};
use crate::settings::Settings;
use crate::tracker::Tracker;

/// Time between two attempts to reach a robot that does not listen yet.
const RETRY: Duration = Duration::from_millis(100);
/// A command may follow the one before by a period less this share of it: delays of the scheduler are no second command.
const SLACK: u32 = 4;

/// What became of the commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LinkCounts {
    pub(crate) commands: u64,
    pub(crate) acknowledged: u64,
    pub(crate) unsent: u64,
    pub(crate) too_soon: u64,
    pub(crate) late: u64,
    pub(crate) reconnections: u64,
    pub(crate) watchdog: u64,
}

/// Admits one command per period: the generic cell rate algorithm.
struct Pacer {
    period: Duration,
    /// When the next command is due, if there was one.
    due: Option<Instant>,
}

impl Pacer {
    fn new(period: Duration) -> Self {
        Self { period, due: None }
    }

    /// Whether a command may be sent now, which counts as sent then.
    fn admits(&mut self, now: Instant) -> bool {
        let due = self.due.unwrap_or(now);
        if now + self.period / SLACK < due {
            return false;
        }
        self.due = Some(due.max(now) + self.period);
        true
    }
}

/// The state of a bridge, shared by its participants and its thread.
pub(crate) struct Contact {
    pub(crate) settings: Settings,
    pub(crate) tracker: Tracker,
    pub(crate) counts: LinkCounts,
    pub(crate) socket: UdpSocket,
    inputs: usize,
    /// Time between two commands, ns.
    period: Period,
    pacer: Pacer,
    link: Option<Box<dyn Link>>,
    /// Number of the last frame that was sent.
    sequence: u32,
    acknowledged: Option<u32>,
    /// Number of the newest command, and when it was sent.
    asked: Option<(u32, Instant)>,
    /// Since when the robot owes an answer.
    owing: Option<Instant>,
    /// From a command to its answer, s, as it took last.
    round_trip: f64,
    /// Whether the robot carries out what it is told, by its newest answer.
    obeys: bool,
    /// Whether the newest thing that it was told is a command.
    drives: bool,
    /// Pose frames that the emulator has sent by its last acknowledgement.
    frames: u32,
    /// The zero of the clock of the bridge.
    origin: Instant,
    /// When the robot was last told something.
    told: Option<Instant>,
    /// Since when there is no link.
    apart_since: Option<Instant>,
    /// The second in which poses are counted, and how many there were.
    rate: (u64, u32),
    pub(crate) ended: bool,
}

impl Contact {
    pub(crate) fn new(settings: &Settings, inputs: usize, period: Period) -> io::Result<Self> {
        Ok(Self {
            tracker: Tracker::new(settings.body, settings.gate),
            counts: LinkCounts::default(),
            socket: UdpSocket::bind(settings.mocap)?,
            settings: settings.clone(),
            inputs,
            period,
            pacer: Pacer::new(Duration::from_nanos(period.rounded_ns())),
            link: None,
            sequence: 0,
            acknowledged: None,
            asked: None,
            owing: None,
            round_trip: 0.0,
            obeys: true,
            drives: false,
            frames: 0,
            origin: Instant::now(),
            told: None,
            apart_since: None,
            rate: (0, 0),
            ended: false,
        })
    }

    /// The frame that asks for control; `stamp` is the instant of the first command in lockstep.
    pub(crate) fn hello(&self, stamp: u64) -> io::Result<Frame> {
        let Settings { body, clock, .. } = self.settings;
        let port = self.socket.local_addr()?.port();
        let hello = Message::Hello { body, inputs: self.inputs as u32, period: self.period.rounded_ns(), clock, port };
        Ok(hello.frame(self.sequence, stamp))
    }

    /// Time since the start of the bridge, ns.
    pub(crate) fn now(&self) -> u64 {
        self.origin.elapsed().as_nanos() as u64
    }

    pub(crate) fn is_connected(&self) -> bool {
        self.link.is_some()
    }

    /// Whether the robot carries out what it is told, by its newest answer.
    pub(crate) fn obeys(&self) -> bool {
        self.obeys
    }

    /// From a command to its answer, s, as it took last.
    pub(crate) fn round_trip(&self) -> f64 {
        self.round_trip
    }

    /// How long there has been no link.
    pub(crate) fn apart(&self) -> Duration {
        self.apart_since.map_or(Duration::ZERO, |since| since.elapsed())
    }

    /// Takes over a link on which control was granted.
    pub(crate) fn attach(&mut self, link: Box<dyn Link>) {
        if self.apart_since.take().is_some() {
            self.counts.reconnections += 1;
            self.say("connected again");
            if self.settings.clock == Clock::Wall {
                // Robot and cameras may have been switched on again; the poses will tell.
                self.tracker.restart();
            }
        }
        self.link = Some(link);
        (self.acknowledged, self.frames, self.asked, self.owing) = (None, 0, None, None);
    }

    /// Sends a command that holds from `stamp` on; with the clock on the wall not more than one per period, whatever the run
    /// does: one that comes too soon is left out, and the next one follows within a period.
    pub(crate) fn command(&mut self, stamp: u64, inputs: &[f64]) {
        if self.settings.clock == Clock::Wall && !self.pacer.admits(Instant::now()) {
            self.counts.too_soon += 1;
            return;
        }
        let mut values = [0.0; MAX_INPUTS];
        values[..inputs.len()].copy_from_slice(inputs);
        if self.send(&Message::Command { count: inputs.len(), inputs: values }, stamp) {
            self.counts.commands += 1;
            self.drives = true;
            let now = Instant::now();
            self.asked = Some((self.sequence, now));
            self.owing.get_or_insert(now);
        } else {
            self.counts.unsent += 1;
        }
    }

    /// Tells the robot to stop.
    pub(crate) fn halt(&mut self) {
        let stamp = self.now();
        self.send(&Message::Halt, stamp);
    }

    fn send(&mut self, message: &Message, stamp: u64) -> bool {
        let Some(link) = &mut self.link else { return false };
        self.sequence = self.sequence.wrapping_add(1);
        self.told = Some(Instant::now());
        let sent = link.send(&message.frame(self.sequence, stamp));
        sent.map_err(|error| self.lose(&error)).is_ok()
    }

    /// The link is gone.
    fn lose(&mut self, error: &LinkError) {
        if self.link.take().is_some() {
            self.apart_since = Some(Instant::now());
            self.say(&format!("connection lost: {error}; its own watchdog stops it"));
        }
    }

    /// Takes in acknowledgements: those that are there, or the one that is due, for which it waits until `deadline`.
    pub(crate) fn receive(&mut self, deadline: Option<Instant>) {
        while self.acknowledged != Some(self.sequence) || deadline.is_none() {
            let patience = deadline.map_or(Duration::ZERO, |end| end.saturating_duration_since(Instant::now()));
            let Some(link) = &mut self.link else { return };
            match link.receive(patience) {
                Ok(Some(frame)) => self.take_answer(&frame),
                Ok(None) => {
                    self.counts.late += u64::from(deadline.is_some());
                    return;
                }
                Err(error) => self.lose(&error),
            }
        }
    }

    fn take_answer(&mut self, frame: &Frame) {
        match Message::of(frame) {
            Ok(Message::Acknowledge { applies, frames }) => {
                self.counts.acknowledged += u64::from(applies);
                if applies != self.obeys {
                    self.obeys = applies;
                    self.say(if applies { "it carries out commands again" } else { "it says that it is halted" });
                }
                match self.asked {
                    Some((newest, sent)) if newest == frame.sequence => {
                        (self.owing, self.round_trip) = (None, sent.elapsed().as_secs_f64());
                    }
                    _ => self.owing = self.owing.map(|_| Instant::now()),
                }
                (self.acknowledged, self.frames) = (Some(frame.sequence), frames);
            }
            Ok(Message::Refused { reason }) => self.say(&format!("refused: {reason}")),
            Ok(_) => self.lose(&crate::frame::FrameError::Content("a robot does not send this").into()),
            Err(error) => self.lose(&error.into()),
        }
    }

    /// In lockstep: waits until all poses that the emulator has sent are there.
    pub(crate) fn receive_poses(&mut self, deadline: Instant) {
        loop {
            let behind = self.tracker.newest().map_or(0, |newest| newest.wrapping_add(1)) != self.frames;
            let left = if behind { deadline.saturating_duration_since(Instant::now()) } else { Duration::ZERO };
            match wait_readable(&self.socket, left) {
                Ok(true) => {
                    let mut bytes = [0; 2 * MAX_FRAME];
                    if let Ok(length) = self.socket.recv(&mut bytes) {
                        self.take_datagram(&bytes[..length]);
                    }
                }
                _ => {
                    self.counts.late += u64::from(behind && self.frames > 0 && self.is_connected());
                    return;
                }
            }
        }
    }

    /// Takes in what came from the cameras.
    pub(crate) fn take_datagram(&mut self, bytes: &[u8]) {
        let arrival = self.now();
        let second = arrival / 1_000_000_000;
        self.rate = if self.rate.0 == second { (second, self.rate.1.saturating_add(1)) } else { (second, 1) };
        // Simulated time may pass faster than the clock on the wall.
        if self.settings.clock == Clock::Wall && self.rate.1 > self.settings.mocap_max_rate {
            self.tracker.counts.too_many += 1;
            return;
        }
        let frame = Frame::decode(bytes);
        match frame.and_then(|frame| Message::of(&frame).map(|message| (frame, message))) {
            Ok((frame, Message::Pose(pose))) => {
                self.tracker.take(frame.sequence, frame.stamp, &pose, crate::tracker::seconds(arrival));
            }
            _ => self.tracker.counts.malformed += 1,
        }
    }

    /// Halts the robot if it was not told anything for too long, and gives a link up on which nothing is answered: closed, it
    /// makes the robot halt.
    pub(crate) fn watch(&mut self) {
        let patience = self.settings.acknowledge_within;
        if patience > 0.0 && self.owing.is_some_and(|since| since.elapsed().as_secs_f64() > patience) {
            self.lose(&LinkError::Silent(patience));
        }
        let limit = Duration::from_nanos(self.period.rounded_ns()).saturating_mul(self.settings.watchdog_periods);
        if self.link.is_some() && self.told.is_some_and(|told| told.elapsed() > limit) {
            // Said again and again, but counted once.
            self.counts.watchdog += u64::from(std::mem::take(&mut self.drives));
            self.halt();
        }
    }

    /// A line for the user.
    pub(crate) fn say(&self, text: &str) {
        eprintln!("robot {} at {}: {text}", self.settings.body, self.settings.robot);
    }

    /// What came of it all.
    pub(crate) fn summary(&self) -> String {
        let LinkCounts { commands, acknowledged, unsent, too_soon, late, reconnections, watchdog } = self.counts;
        format!(
            "{commands} commands, {acknowledged} acknowledged, {unsent} not sent, {too_soon} left out as a second one in a period, {late} late answers, {reconnections} \
             reconnections, {watchdog} halts by the watchdog; {}",
            self.tracker.counts
        )
    }
}

/// Opens a link and asks for control.
///
/// # Errors
/// Why there is none, in words.
pub(crate) fn open(
    connector: &mut dyn Connector,
    hello: &Frame,
    body: u32,
    patience: Duration,
) -> Result<Box<dyn Link>, String> {
    let target = connector.target();
    let link = connector.connect(patience).map_err(|error| format!("no robot answers at {target}: {error}"))?;
    greet(link, &target, hello, body, patience)
}

/// As [`open`], for a robot that may still be starting: tries until it listens, for `patience` at most.
///
/// # Errors
/// Why there is none, in words.
pub(crate) fn await_robot(
    connector: &mut dyn Connector,
    hello: &Frame,
    body: u32,
    patience: Duration,
) -> Result<Box<dyn Link>, String> {
    let (target, start) = (connector.target(), Instant::now());
    loop {
        // The system does not take zero for a time.
        let left = patience.saturating_sub(start.elapsed()).max(Duration::from_millis(1));
        match connector.connect(left) {
            Ok(link) => return greet(link, &target, hello, body, left),
            Err(error) if !may_come(&error) || start.elapsed() + RETRY >= patience => {
                let seconds = start.elapsed().as_secs_f64();
                return Err(format!("no robot answers at {target}, tried for {seconds:.1} s: {error}"));
            }
            Err(_) => std::thread::sleep(RETRY),
        }
    }
}

/// Whether it may be that the robot is only not there yet.
fn may_come(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionRefused, ConnectionReset, HostUnreachable, NetworkUnreachable, TimedOut};
    [ConnectionRefused, ConnectionReset, HostUnreachable, NetworkUnreachable, TimedOut].contains(&error.kind())
}

/// Asks for control over an open link.
fn greet(
    mut link: Box<dyn Link>,
    target: &str,
    hello: &Frame,
    body: u32,
    patience: Duration,
) -> Result<Box<dyn Link>, String> {
    let failed = |error: LinkError| format!("the robot at {target} does not answer as a robot does: {error}");
    link.send(hello).map_err(failed)?;
    let Some(frame) = link.receive(patience).map_err(failed)? else {
        return Err(format!("the robot at {target} does not answer"));
    };
    match Message::of(&frame).map_err(|error| failed(error.into()))? {
        Message::Welcome { body: found } if found == body => Ok(link),
        Message::Welcome { body: found } => Err(format!("the robot at {target} is number {found}, not {body}")),
        Message::Refused { reason } => Err(format!("the robot at {target} refuses: {reason}")),
        _ => Err(format!("the robot at {target} answers with something else than a welcome")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_gets_one_command_per_period_whatever_the_run_does() {
        let (period, start) = (Duration::from_millis(10), Instant::now());
        let sent = |times: &[u64]| {
            let mut pacer = Pacer::new(period);
            times.iter().filter(|&&micros| pacer.admits(start + Duration::from_micros(micros))).count()
        };
        // In time, with delays of the scheduler, and after a pause.
        assert_eq!(sent(&[0, 10_000, 20_000, 30_000]), 4);
        assert_eq!(sent(&[60, 10_000, 20_900, 30_000, 40_300, 50_000]), 6);
        assert_eq!(sent(&[0, 1_500_000, 1_510_000]), 3);
        // A burst of 100 commands within 50 ms after a stall.
        let burst: Vec<u64> = (0..100).map(|index| 1_500_000 + 500 * index).collect();
        assert!((5..=6).contains(&sent(&burst)), "{}", sent(&burst));
        // Commands half a period apart, for 10 s.
        let twice: Vec<u64> = (0..2000).map(|index| 5_000 * index).collect();
        assert!((999..=1001).contains(&sent(&twice)), "{}", sent(&twice));
    }
}
