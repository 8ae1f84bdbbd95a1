//! The bridge: stands for the robot in a run. Two participants in one process: at the start of a step the one publishes the
//! pose that the cameras tell, at its end the other sends the command that was computed meanwhile.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use formation::scenario::Context;
use formation::wiring::{Bind, Refusal, Role};
use lockstep::{Fault, Io, Out, Participant, Period, Slice, Step, Timing};

use crate::contact::{Contact, await_robot, open};
use crate::frame::MAX_FRAME;
use crate::health;
use crate::link::{Connector, TcpConnector};
use crate::message::Clock;
use crate::settings::Settings;
use crate::tracker::{Seen, seconds};

/// How long the thread of the bridge sleeps at most.
const NAP: Duration = Duration::from_millis(2);
/// How often it tries to connect again.
const RETRY: Duration = Duration::from_millis(100);
/// How long a new connection may take while the run goes on.
const RECONNECT_PATIENCE: Duration = Duration::from_millis(250);

/// A connected robot. Dropping it stops the robot.
struct Bridge {
    core: Arc<Mutex<Contact>>,
    /// In lockstep: how to connect again. Else the thread does it.
    connector: Option<Box<dyn Connector>>,
    thread: Option<JoinHandle<()>>,
}

fn lock(core: &Mutex<Contact>) -> MutexGuard<'_, Contact> {
    // A panic in between ends the process; what it leaves is good enough to stop the robot.
    core.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Bridge {
    /// Connects; with the clock on the wall, also waits for the first pose.
    fn start(
        mut connector: Box<dyn Connector>,
        settings: &Settings,
        inputs: usize,
        period: Period,
    ) -> Result<Self, String> {
        let failed = |error: std::io::Error| format!("listen to the cameras at {}: {error}", settings.mocap);
        let mut core = Contact::new(settings, inputs, period).map_err(failed)?;
        let patience = lockstep::duration(settings.start_patience);
        let hello = core.hello(0).map_err(failed)?;
        core.attach(await_robot(&mut *connector, &hello, settings.body, patience)?);
        let core = Arc::new(Mutex::new(core));
        if settings.clock == Clock::Lockstep {
            return Ok(Self { core, connector: Some(connector), thread: None });
        }
        let shared = Arc::clone(&core);
        let thread = std::thread::Builder::new().name("bridge".into()).spawn(move || attend(&shared, connector));
        let thread = Some(thread.map_err(|error| format!("start a thread: {error}"))?);
        let bridge = Self { core, connector: None, thread };
        let start = Instant::now();
        while lock(&bridge.core).tracker.last().is_none() {
            if start.elapsed() > patience {
                let counts = lock(&bridge.core).tracker.counts;
                let (body, seconds) = (settings.body, settings.start_patience);
                return Err(format!("no valid pose of body {body} came within {seconds} s ({counts})"));
            }
            std::thread::sleep(NAP);
        }
        Ok(bridge)
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        {
            let mut core = lock(&self.core);
            core.halt();
            core.ended = true;
            if core.settings.clock == Clock::Wall {
                core.say(&core.summary());
            }
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        // A connection that is closed with something unread may take the Halt with it.
        lock(&self.core).receive(None);
    }
}

/// With the clock on the wall: takes in poses and answers, watches, connects again, until the bridge ends.
fn attend(shared: &Mutex<Contact>, mut connector: Box<dyn Connector>) {
    let Ok(socket) = lock(shared).socket.try_clone() else { return };
    let mut tried = Instant::now();
    loop {
        let mut bytes = [0; 2 * MAX_FRAME];
        let came = crate::link::wait_readable(&socket, NAP).unwrap_or(false);
        let length = if came { socket.recv(&mut bytes).ok() } else { None };
        let again = {
            let mut core = lock(shared);
            if core.ended {
                return;
            }
            length.into_iter().for_each(|length| core.take_datagram(&bytes[..length]));
            core.receive(None);
            core.watch();
            let due = !core.is_connected() && tried.elapsed() > RETRY;
            due.then(|| core.hello(core.now()).ok().map(|hello| (hello, core.settings.body))).flatten()
        };
        if let Some((hello, body)) = again {
            // Without the lock: the run must not wait for this.
            let opened = open(&mut *connector, &hello, body, RECONNECT_PATIENCE);
            tried = Instant::now();
            if let Ok(link) = opened {
                lock(shared).attach(link);
            }
        }
    }
}

/// The participants that stand for the robot of `agent` (from 0): the one that publishes its poses in the place of the plant,
/// bound by `poses`, and the one that sends its commands at the end of a step, bound by `commands`.
///
/// # Errors
/// Why the robot cannot be reached, or does not fit the scenario.
pub fn participants(
    settings: &Settings,
    context: &Context,
    agent: usize,
    poses: &mut Bind,
    commands: &mut Bind,
) -> Result<[Box<dyn Participant>; 2], Refusal> {
    let row = &context.agents[agent];
    let (coordinates, inputs) = (row.vehicle.coordinates(), row.vehicle.inputs());
    let offered = |bind: &Bind, name| bind.offers(Role::Plant, agent, name);
    let position = poses.slice_out(agent, "position", coordinates)?;
    let velocity = offered(poses, "velocity").then(|| poses.slice_out(agent, "velocity", coordinates)).transpose()?;
    let age = offered(poses, "age").then(|| poses.out(agent, "age")).transpose()?;
    let connected = offered(poses, "connected").then(|| poses.out(agent, "connected")).transpose()?;
    let input = commands.slice(Role::Controller, agent, "input", inputs, Timing::SameStep)?;
    let connector = Box::new(TcpConnector(settings.robot));
    let period = context.timing.period();
    let bridge = Arc::new(Mutex::new(Bridge::start(connector, settings, inputs, period).map_err(Refusal)?));
    let eyes = Eyes {
        bridge: Arc::clone(&bridge),
        period,
        seen: None,
        start: row.position.clone(),
        rate: vec![0.0; coordinates],
        position,
        velocity,
        age,
        connected,
    };
    // A lockstep run tells the same whether there are sockets or not.
    let health = (settings.clock == Clock::Wall).then(|| Slice::new(0, 0, health::layout().words()));
    Ok([Box::new(eyes), Box::new(Hand { bridge, period, input, health })])
}

/// Publishes the newest pose.
struct Eyes {
    bridge: Arc<Mutex<Bridge>>,
    /// Length of a step.
    period: Period,
    /// What was published last.
    seen: Option<Seen>,
    /// What is published before the first pose.
    start: Vec<f64>,
    /// Difference quotient of the last two poses.
    rate: Vec<f64>,
    position: Slice,
    velocity: Option<Slice>,
    age: Option<Out<1>>,
    connected: Option<Out<1>>,
}

impl Participant for Eyes {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let shared = Arc::clone(&self.bridge);
        let bridge = shared.lock().unwrap_or_else(PoisonError::into_inner);
        let mut core = lock(&bridge.core);
        let time = self.period.time_ns(step.index);
        if core.settings.clock == Clock::Lockstep && !step.is_first() {
            let deadline = Instant::now() + lockstep::duration(core.settings.deadline);
            core.receive(Some(deadline));
            core.receive_poses(deadline);
        }
        let newest = core.tracker.last().copied();
        let fresh = newest.map(|seen| (seen.number, seen.stamp)) != self.seen.map(|seen| (seen.number, seen.stamp));
        if fresh && let Some(seen) = newest {
            self.take(&seen);
        }
        let age = match core.settings.clock {
            Clock::Lockstep => seconds(time.saturating_sub(newest.map_or(0, |seen| seen.stamp))),
            Clock::Wall => {
                let latency = core.settings.mocap_latency;
                core.tracker.age(seconds(core.now()), latency).unwrap_or(0.0)
            }
        };
        let limit = core.settings.lost_after;
        if age > limit {
            core.halt();
            return Err(Fault(format!(
                "no valid pose of robot {} for {age:.3} s, more than lost_after = {limit} s; it was told to stop ({})",
                core.settings.body,
                core.summary()
            )));
        }
        if core.apart().as_secs_f64() > limit {
            return Err(Fault(format!(
                "no connection to robot {} at {} for more than lost_after = {limit} s; its own watchdog stops it ({})",
                core.settings.body,
                core.settings.robot,
                core.summary()
            )));
        }
        self.publish(age, core.is_connected(), fresh, io);
        Ok(())
    }
}

impl Eyes {
    /// Takes in a new pose.
    fn take(&mut self, seen: &Seen) {
        if let Some(before) = self.seen.filter(|before| before.stamp < seen.stamp) {
            let span = seconds(seen.stamp - before.stamp);
            let quotients = chosen(&seen.pose, self.rate.len()).zip(chosen(&before.pose, self.rate.len()));
            self.rate.iter_mut().zip(quotients).for_each(|(rate, (now, then))| *rate = (now - then) / span);
        }
        self.seen = Some(*seen);
    }

    fn publish(&self, age: f64, connected: bool, fresh: bool, io: &mut Io) {
        let place = io.slice_mut(self.position);
        match &self.seen {
            Some(seen) => {
                let length = place.len();
                place.iter_mut().zip(chosen(&seen.pose, length)).for_each(|(place, value)| *place = value);
            }
            None => place.copy_from_slice(&self.start),
        }
        if let Some(port) = self.velocity {
            io.slice_mut(port).copy_from_slice(&self.rate);
        }
        if let Some(port) = self.age {
            io.set(port, [age]);
        }
        if let Some(port) = self.connected {
            io.set(port, [f64::from(u8::from(connected))]);
        }
        if !fresh {
            io.mark_slice_held(self.position);
        }
    }
}

/// The coordinates of a vehicle: x, y and yaw of three, all of six.
fn chosen(pose: &[f64; 6], coordinates: usize) -> impl Iterator<Item = f64> {
    let places: &[usize] = if coordinates == 3 { &[0, 1, 5] } else { &[0, 1, 2, 3, 4, 5] };
    places.iter().map(|&place| pose[place])
}

/// Sends the command of a step.
struct Hand {
    bridge: Arc<Mutex<Bridge>>,
    /// Length of a step.
    period: Period,
    input: Slice,
    /// Where it tells how the robot is.
    health: Option<Slice>,
}

impl Participant for Hand {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let mut bridge = self.bridge.lock().unwrap_or_else(PoisonError::into_inner);
        let Bridge { core, connector, .. } = &mut *bridge;
        let mut core = lock(core);
        let lockstep = core.settings.clock == Clock::Lockstep;
        let stamp = if lockstep { self.period.time_ns(step.index) } else { core.now() };
        if let (false, Some(connector), Ok(hello)) = (core.is_connected(), connector, core.hello(stamp))
            && let Ok(link) = open(&mut **connector, &hello, core.settings.body, RECONNECT_PATIENCE)
        {
            core.attach(link);
        }
        core.command(stamp, io.slice(self.input));
        if let Some(port) = self.health {
            io.slice_mut(port).copy_from_slice(&health::sample(&core));
        }
        Ok(())
    }
}
