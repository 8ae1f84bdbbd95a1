//! A laboratory in the place of ideal vehicles: robots with motors and links that lag, watched by cameras that are late, noisy
//! and sometimes blind. What it publishes is what a camera system would tell, never the true poses.

mod model;

pub use model::{LaboratoryRobot, Sighting};

use formation::config::{Node, Problems, read};
use formation::nalgebra::Vector3;
use formation::scenario::{Context, Scenario};
use formation::vehicle::{Drive, Vehicle};
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault as Failing, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What scenario files call it.
pub const KIND: &str = "laboratory";

/// Parameters of the laboratory. The defaults are those of the thesis' experiment as it is emulated, without faults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Laboratory {
    /// Step of the emulation, s.
    pub tick: f64,
    /// Poses per second.
    pub mocap_hz: f64,
    /// From the capture of a pose to its arrival, s.
    pub mocap_latency: f64,
    /// From a command to its arrival at the motors, s.
    pub command_delay: f64,
    /// Time constant of the motors, s; 0: they follow at once.
    pub motor_tau: f64,
    /// Noise of positions, uniform in [-value, value], m.
    pub noise_pos: f64,
    /// Noise of angles, uniform in [-value, value], rad.
    pub noise_ang: f64,
    /// Seed of the noise.
    pub noise_seed: u64,
    /// What goes wrong with the cameras.
    pub faults: Vec<CameraFault>,
}

/// A span in which the cameras do not see a robot, or see it elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraFault {
    /// Number of the robot, from 1.
    pub robot: u32,
    /// When it begins, s.
    pub start: f64,
    /// How long it lasts, s.
    pub duration: f64,
    /// What it is.
    pub kind: FaultKind,
    /// Where a jump shifts the pose, m, m, rad.
    #[serde(default)]
    pub offset: [f64; 3],
}

/// The kinds of camera faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FaultKind {
    /// The robot is not seen.
    Dropout,
    /// The robot is seen where it is not.
    Jump,
}

impl Default for Laboratory {
    fn default() -> Self {
        Self {
            tick: 1e-3,
            mocap_hz: 100.0,
            mocap_latency: 0.01,
            command_delay: 0.01,
            motor_tau: 0.05,
            noise_pos: 3e-4,
            noise_ang: 1e-3,
            noise_seed: 1,
            faults: Vec::new(),
        }
    }
}

impl CameraFault {
    /// Whether it is active at `time` s. Times of ticks are sums of fractions that are not exact, hence the tolerance.
    pub fn is_active(&self, time: f64) -> bool {
        const TOLERANCE: f64 = 1e-9;
        self.start - TOLERANCE <= time && time < self.start + self.duration - TOLERANCE
    }
}

impl Laboratory {
    /// The laboratory of a scenario, if that is its plant.
    pub fn of(scenario: &Scenario) -> Option<Self> {
        let mut section = scenario.section("plant")?.clone();
        if section.at("kind").and_then(Node::as_str) != Some(KIND) {
            return None;
        }
        let table = section.as_table_mut()?;
        for of_every_role in ["kind", "every", "offset", "per_agent", "groups", "with"] {
            table.remove(of_every_role);
        }
        read(&section, "plant", &mut Problems::default())
    }

    /// A tick in ns.
    pub fn tick_ns(&self) -> u64 {
        (self.tick * 1e9).round() as u64
    }

    /// `span` s in ticks, if it is a whole number of them.
    pub fn ticks(&self, span: f64) -> Option<u64> {
        let ticks = span / self.tick;
        let whole = ticks.round();
        ((ticks - whole).abs() < 1e-6 && (0.0..1e9).contains(&whole)).then_some(whole as u64)
    }

    /// The message for a step that is not a whole number of ticks.
    fn wrong_step(&self, dt: f64) -> String {
        let tick = self.tick;
        let below = (dt / tick).floor().max(1.0);
        let near = |ticks: f64| format!("{} s", (ticks * tick * 1e9).round() / 1e9);
        format!(
            "expected a whole number of ticks of the laboratory, {tick} s each, found {dt} s; the nearest are {} and {}, or set \
             plant.tick",
            near(below),
            near(below + 1.0)
        )
    }

    /// What is wrong with the parameters: field and message.
    pub fn findings(&self) -> Vec<(&'static str, String)> {
        let nanoseconds = self.tick * 1e9;
        if !((1.0..1e9).contains(&nanoseconds) && (nanoseconds - nanoseconds.round()).abs() < 1e-3) {
            return vec![("tick", format!("expected a whole number of ns, less than 1 s, found {} s", self.tick))];
        }
        let mut findings = Vec::new();
        let period = 1.0 / self.mocap_hz;
        if !(period.is_finite() && period > 0.0 && self.ticks(period).is_some_and(|ticks| ticks > 0)) {
            let message = format!(
                "expected a rate > 0 whose period is a whole number of ticks of {} s, found {}",
                self.tick, self.mocap_hz
            );
            findings.push(("mocap_hz", message));
        }
        let whole = [("mocap_latency", self.mocap_latency), ("command_delay", self.command_delay)];
        for (field, value) in whole {
            if self.ticks(value).is_none() {
                let tick = self.tick;
                findings.push((field, format!("expected a time >= 0 in whole ticks of {tick} s, found {value}")));
            }
        }
        let least = [("motor_tau", self.motor_tau), ("noise_pos", self.noise_pos), ("noise_ang", self.noise_ang)];
        for (field, value) in least {
            if !(value.is_finite() && value >= 0.0) {
                findings.push((field, format!("expected a number >= 0, found {value}")));
            }
        }
        let sound = |fault: &CameraFault| {
            fault.robot >= 1
                && fault.start.is_finite()
                && fault.duration.is_finite()
                && fault.offset.iter().all(|value| value.is_finite())
        };
        if let Some(at) = self.faults.iter().position(|fault| !sound(fault)) {
            findings.push(("faults", format!("number {}: expected robot >= 1 and finite numbers", at + 1)));
        }
        findings
    }
}

/// Whether the laboratory has a model of this vehicle.
pub fn is_emulated(vehicle: &Vehicle) -> bool {
    vehicle.omni().is_some_and(|omni| omni.drive == Drive::Speed)
}

impl Component for Laboratory {
    fn check(&self, context: &Context) -> Checks {
        let mut checks = Checks::default();
        for (field, message) in self.findings() {
            checks = checks.require(false, field, message);
        }
        let vehicles = context.agents.iter().all(|agent| is_emulated(&agent.vehicle));
        let step = self.ticks(context.timing.dt).is_some_and(|ticks| ticks > 0);
        checks
            .require(vehicles, "/vehicle", "the laboratory emulates robots with wheel speeds: kind \"omni\", order 1")
            .require(step, "/timing.dt", self.wrong_step(context.timing.dt))
    }

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        published().fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let ticks = self.ticks(context.timing.dt).unwrap_or(1);
        let mut robots = Vec::new();
        for &agent in agents {
            let robot = LaboratoryRobot::new(self, context, agent);
            robots.push(ObservedRobot {
                seen: robot.pose(),
                seen_at: 0,
                robot,
                command: bind.command_before(agent, "input")?,
                outputs: published().bind(agent, bind)?,
            });
        }
        Ok(Box::new(LaboratoryParticipant { robots, ticks, tick_ns: self.tick_ns() }))
    }
}

/// What the cameras report of a robot in a step.
struct CameraReport {
    position: Vector3<f64>,
    /// Since the capture of the position, s.
    age: f64,
}

fn published() -> Outputs<CameraReport> {
    Outputs::new()
        .vector("position", "m, m, rad", |report: &CameraReport| report.position)
        .scalar("age", "s", |report| report.age)
        .scalar("connected", "", |_| 1.0)
}

struct LaboratoryParticipant {
    robots: Vec<ObservedRobot>,
    /// Ticks of a step.
    ticks: u64,
    /// Length of a tick, ns.
    tick_ns: u64,
}

/// A robot, and the last report of the cameras.
struct ObservedRobot {
    robot: LaboratoryRobot,
    seen: [f64; 3],
    /// The tick of its capture.
    seen_at: u64,
    command: In<3>,
    outputs: BoundOutputs<CameraReport>,
}

impl Participant for LaboratoryParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Failing> {
        for observed in &mut self.robots {
            if !step.is_first() {
                observed.robot.command(io.get(observed.command));
                (0..self.ticks).for_each(|_| observed.robot.advance());
            }
            let mut fresh = false;
            while let Some(sighting) = observed.robot.take_sighting() {
                if let Some(pose) = sighting.pose {
                    (observed.seen, observed.seen_at, fresh) = (pose, sighting.captured, true);
                }
            }
            let age = ((observed.robot.tick() - observed.seen_at) * self.tick_ns) as f64 / 1e9;
            observed.outputs.write(io, &CameraReport { position: observed.seen.into(), age });
            if !fresh {
                observed.outputs.mark_held(io);
            }
        }
        Ok(())
    }
}
