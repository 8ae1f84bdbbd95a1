//! One emulated robot and what the cameras see of it, tick by tick.

use std::collections::VecDeque;

use formation::formula::Formula;
use formation::math::{Rk4, SplitMix64, clip};
use formation::scenario::Context;
use formation::vehicle::Vehicle;

use super::{CameraFault, FaultKind, Laboratory};

/// What the cameras tell of one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Number of the frame, from 0.
    pub number: u64,
    /// The tick of its capture.
    pub captured: u64,
    /// The tick at which it arrives.
    pub ready: u64,
    /// The pose, m, m, rad; `None` if the robot was not seen.
    pub pose: Option<[f64; 3]>,
}

/// A robot with wheel speeds behind a delayed link, and the cameras above it. Robots do not touch each other, so each can be
/// emulated in a program of its own; all draw from the same stream of noise and use their part of it.
#[derive(Clone, Debug)]
pub struct LaboratoryRobot {
    parameters: Laboratory,
    vehicle: Vehicle,
    disturbance: Vec<Formula>,
    limit: f64,
    faults: Vec<CameraFault>,
    /// Place among the robots, from 0, and their number.
    place: (usize, usize),
    mocap_ticks: u64,
    latency_ticks: u64,
    delay_ticks: u64,
    tick: u64,
    pose: Vec<f64>,
    motors: [f64; 3],
    arrived: [f64; 3],
    /// Commands on their way: tick of arrival, wheel speeds.
    under_way: VecDeque<(u64, [f64; 3])>,
    sightings: VecDeque<Sighting>,
    noise: SplitMix64,
    integrator: Rk4,
}

impl LaboratoryRobot {
    /// The robot of `agent` (from 0) at its start, at tick 0, which the cameras have captured already.
    ///
    /// The parameters and the vehicle must be such that [`Laboratory::findings`] and
    /// [`is_emulated`](super::is_emulated) have nothing against them.
    pub fn new(parameters: &Laboratory, context: &Context, agent: usize) -> Self {
        let row = &context.agents[agent];
        let faults = parameters.faults.iter().filter(|fault| fault.robot == row.id).cloned().collect();
        let ticks = |span| parameters.ticks(span).unwrap_or(0);
        let mut robot = Self {
            vehicle: row.vehicle.clone(),
            disturbance: context.disturbance[agent].matched.clone(),
            limit: context.input_limit.unwrap_or(f64::INFINITY),
            faults,
            place: (agent, context.agents.len()),
            mocap_ticks: ticks(1.0 / parameters.mocap_hz).max(1),
            latency_ticks: ticks(parameters.mocap_latency),
            delay_ticks: ticks(parameters.command_delay),
            tick: 0,
            pose: row.position.clone(),
            motors: [0.0; 3],
            arrived: [0.0; 3],
            under_way: VecDeque::new(),
            sightings: VecDeque::new(),
            noise: SplitMix64::new(parameters.noise_seed),
            integrator: Rk4::new(3),
            parameters: parameters.clone(),
        };
        robot.capture();
        robot
    }

    /// Number of ticks since the start.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// The true pose, m, m, rad. For evaluation: no controller may know it.
    pub fn pose(&self) -> [f64; 3] {
        [self.pose[0], self.pose[1], self.pose[2]]
    }

    /// The wheel speeds that the motors have reached, m/s.
    pub fn motors(&self) -> [f64; 3] {
        self.motors
    }

    /// Sends wheel speeds (m/s) to the motors, where they arrive after the delay of the link.
    pub fn command(&mut self, speeds: [f64; 3]) {
        self.under_way.push_back((self.tick + self.delay_ticks, speeds));
    }

    /// Stops the motors now: nothing that is under way arrives any more.
    pub fn halt(&mut self) {
        self.under_way.clear();
        self.arrived = [0.0; 3];
    }

    /// Starts from `tick` on at the pose of now; what was under way is lost. For a robot that is switched on in the middle of
    /// a run.
    pub fn skip_to(&mut self, tick: u64) {
        self.halt();
        self.sightings.clear();
        while self.tick < tick {
            self.tick += 1;
            self.capture();
        }
    }

    /// One tick: arrivals, motion under the motor speeds of before, motors, cameras.
    pub fn advance(&mut self) {
        while let Some(&(arrival, speeds)) = self.under_way.front()
            && arrival <= self.tick
        {
            self.arrived = speeds;
            self.under_way.pop_front();
        }
        let wanted = self.arrived.map(|speed| clip(speed, self.limit));
        let Self { vehicle, disturbance, motors, integrator, pose, parameters, .. } = self;
        let (length, lag) = (parameters.tick, parameters.motor_tau);
        if lag == 0.0 {
            *motors = wanted;
        }
        let mut arguments = [0.0; 7];
        integrator.step(self.tick as f64 * length, length, pose, |time, pose, slope| {
            vehicle.effect(pose, &*motors, slope);
            arguments[0] = time;
            arguments[1..4].copy_from_slice(pose);
            for (slope, formula) in slope.iter_mut().zip(&*disturbance) {
                *slope += formula.evaluate(&arguments);
            }
        });
        if lag > 0.0 {
            let rest = libm::exp(-length / lag);
            *motors = std::array::from_fn(|j| wanted[j] + (motors[j] - wanted[j]) * rest);
        }
        self.tick += 1;
        self.capture();
    }

    /// The oldest frame that has arrived by now.
    pub fn take_sighting(&mut self) -> Option<Sighting> {
        let arrived = self.sightings.front().is_some_and(|sighting| sighting.ready <= self.tick);
        if arrived { self.sightings.pop_front() } else { None }
    }

    fn capture(&mut self) {
        if !self.tick.is_multiple_of(self.mocap_ticks) {
            return;
        }
        let (own, count) = self.place;
        // Everybody's noise is drawn, also that of robots that are not seen.
        let mut drawn = [0.0; 3];
        for robot in 0..count {
            let three = std::array::from_fn(|_| self.noise.symmetric());
            if robot == own {
                drawn = three;
            }
        }
        let time = self.tick as f64 * self.parameters.tick;
        let active = |kind| self.faults.iter().filter(move |fault| fault.kind == kind && fault.is_active(time));
        let Laboratory { noise_pos, noise_ang, .. } = self.parameters;
        let scale = [noise_pos, noise_pos, noise_ang];
        let mut seen: [f64; 3] = std::array::from_fn(|j| self.pose[j] + scale[j] * drawn[j]);
        for fault in active(FaultKind::Jump) {
            seen.iter_mut().zip(fault.offset).for_each(|(value, offset)| *value += offset);
        }
        let pose = if active(FaultKind::Dropout).next().is_some() { None } else { Some(seen) };
        let number = self.tick / self.mocap_ticks;
        self.sightings.push_back(Sighting { number, captured: self.tick, ready: self.tick + self.latency_ticks, pose });
    }
}
