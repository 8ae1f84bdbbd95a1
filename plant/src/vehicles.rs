//! Vehicles under held inputs, integrated with fixed steps.

use formation::formula::Formula;
use formation::math::{Integrator, Method};
use formation::scenario::{Agent, Context};
use formation::vehicle::{MAX_COORDINATES, Vehicle};
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal, Role};
use lockstep::{Fault, Field, Io, Participant, Slice, Step, Timing};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::Actuators;
use crate::model_body::{ModelBody, outputs as model_outputs};

/// Parameters of the plant.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vehicles {
    /// The method of integration.
    #[serde(default)]
    pub integrator: Method,
    /// Steps of the integrator within one step of the run.
    #[serde(default = "one")]
    pub substeps: u32,
    /// Whether the acceleration at the end of each step, still under the command of that step, is published too.
    #[serde(default)]
    pub acceleration: bool,
}

fn one() -> u32 {
    1
}

impl Component for Vehicles {
    fn check(&self, context: &Context) -> Checks {
        let found = format!("expected 1 to 1000 steps, found {}", self.substeps);
        let mut vehicles = context.agents.iter().map(|agent| &agent.vehicle);
        let accelerate = vehicles.clone().all(|vehicle| vehicle.order() == 2 && vehicle.model().is_none());
        let slow = match self.integrator {
            Method::SemiImplicit => vehicles.find(|vehicle| vehicle.order() == 1),
            _ => None,
        };
        let slow = slow.map(|vehicle| {
            format!(
                "semi_implicit needs velocities among the states, which the vehicle `{}` does not name",
                vehicle.kind()
            )
        });
        Checks::default()
            .require((1..=1000).contains(&self.substeps), "substeps", found)
            .require(
                accelerate || !self.acceleration,
                "acceleration",
                "vehicles of order 1 and those by equations have no acceleration to publish",
            )
            .require(slow.is_none(), "integrator", slow.unwrap_or_default())
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        match context.agents[agent].vehicle.model() {
            Some(model) => model_outputs(model).fields(),
            None => self.published(context, agent).fields(),
        }
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let bodies = agents.iter().map(|&agent| self.body(context, agent, bind)).collect::<Result<_, _>>()?;
        Ok(Box::new(VehiclesParticipant { bodies, substeps: self.substeps }))
    }
}

fn units(vehicle: &Vehicle) -> [&'static str; 3] {
    match vehicle {
        Vehicle::Omni(_) => ["m, m, rad", "m/s, m/s, rad/s", "m/s^2, m/s^2, rad/s^2"],
        Vehicle::Quadcopter(_) | Vehicle::Model(_) => ["m, rad", "m/s, rad/s", "m/s^2, rad/s^2"],
    }
}

/// Integrates the vehicles of its agents, each by itself.
pub struct VehiclesParticipant {
    bodies: Vec<Body>,
    substeps: u32,
}

impl Participant for VehiclesParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for body in &mut self.bodies {
            if !step.is_first() {
                let before = (step.index - 1) as f64 * step.dt;
                body.advance(before, step.dt, self.substeps, io);
            }
            body.publish(step.time(), io);
        }
        Ok(())
    }
}

/// One vehicle.
enum Body {
    /// One of the thesis.
    Standard(Box<StandardBody>),
    /// One by equations.
    Model(Box<ModelBody>),
}

impl Body {
    fn advance(&mut self, time: f64, dt: f64, substeps: u32, io: &Io) {
        match self {
            Self::Standard(body) => body.advance(time, dt, substeps, io),
            Self::Model(body) => body.advance(time, dt, substeps, io),
        }
    }

    fn publish(&mut self, time: f64, io: &mut Io) {
        match self {
            Self::Standard(body) => body.publish(time, io),
            Self::Model(body) => body.publish(time, io),
        }
    }
}

/// One vehicle of the thesis and its ports.
struct StandardBody {
    motion: Motion,
    integrator: Integrator,
    command: Slice,
    outputs: BoundOutputs<Motion>,
}

/// A vehicle and its state.
struct Motion {
    dynamics: Dynamics,
    /// Coordinates, then velocities (order 2).
    state: Vec<f64>,
    /// Time derivative of the state, if it is published.
    slope: Option<Vec<f64>>,
}

/// What turns a state and an input into a time derivative.
struct Dynamics {
    vehicle: Vehicle,
    matched: Vec<Formula>,
    mismatched: Vec<Formula>,
    actuators: Actuators,
    /// The parts of the disturbance formulas that depend on time alone; several stages of the integrator share them.
    timed: Vec<Formula>,
    /// Arguments of the disturbance formulas: t, coordinates, velocities, the values of the parts above.
    arguments: Vec<f64>,
}

impl Vehicles {
    fn published(&self, context: &Context, agent: usize) -> Outputs<Motion> {
        let vehicle = &context.agents[agent].vehicle;
        let (length, inputs) = (vehicle.coordinates(), vehicle.inputs());
        let [position, velocity, acceleration] = units(vehicle);
        let mut outputs = Outputs::new().slice("position", length, position, move |motion: &Motion, place| {
            place.copy_from_slice(&motion.state[..length]);
        });
        if vehicle.order() == 2 {
            outputs = outputs.slice("velocity", length, velocity, move |motion, place| {
                place.copy_from_slice(&motion.state[length..]);
            });
        }
        let matched_unit = if vehicle.order() == 2 { acceleration } else { velocity };
        outputs = outputs.slice("disturbance", length, matched_unit, |Motion { dynamics, .. }, place| {
            evaluate(&dynamics.matched, &dynamics.arguments, place);
        });
        if !context.disturbance[agent].mismatched.is_empty() {
            outputs = outputs.slice("mismatched", length, velocity, |Motion { dynamics, .. }, place| {
                evaluate(&dynamics.mismatched, &dynamics.arguments, place);
            });
        }
        if context.actuator.is_some() {
            outputs = outputs
                .slice("actuator", inputs, "", move |motion, place| {
                    place.copy_from_slice(&motion.dynamics.actuators.output[..inputs]);
                })
                .slice("memory", inputs, "", move |motion, place| {
                    place.copy_from_slice(&motion.dynamics.actuators.memory[..inputs]);
                });
        }
        if self.acceleration {
            outputs = outputs.slice("acceleration", length, acceleration, move |motion, place| {
                let slope = motion.slope.as_deref().unwrap_or_default();
                place.copy_from_slice(&slope[length..]);
            });
        }
        outputs
    }

    fn body(&self, context: &Context, agent: usize, bind: &mut Bind) -> Result<Body, Refusal> {
        match context.agents[agent].vehicle.model() {
            Some(model) => Ok(Body::Model(Box::new(ModelBody::new(agent, model, self.integrator, bind)?))),
            None => Ok(Body::Standard(Box::new(self.standard_body(context, agent, bind)?))),
        }
    }

    fn standard_body(&self, context: &Context, agent: usize, bind: &mut Bind) -> Result<StandardBody, Refusal> {
        let Agent { vehicle, position, velocity, .. } = &context.agents[agent];
        let length = vehicle.coordinates();
        let mut state = position.clone();
        if vehicle.order() == 2 {
            state.extend_from_slice(velocity);
        }
        let disturbance = &context.disturbance[agent];
        let command = bind.slice(Role::Controller, agent, "input", vehicle.inputs(), Timing::Delayed)?;
        let outputs = self.published(context, agent).bind(agent, bind)?;
        let mut timed = Vec::new();
        let mut extract = |formulas: &[Formula]| -> Vec<Formula> {
            let formulas = formulas.iter().map(|formula| {
                let (rest, parts) = formula.extract(0, 1 + 2 * length + timed.len());
                timed.extend(parts);
                rest
            });
            formulas.collect()
        };
        let (matched, mismatched) = (extract(&disturbance.matched), extract(&disturbance.mismatched));
        let mut arguments = vec![0.0; 1 + 2 * length + timed.len()];
        // No time at all: the parts are not computed yet.
        arguments[0] = f64::NAN;
        let actuators = Actuators::new(context);
        let dynamics = Dynamics { vehicle: vehicle.clone(), matched, mismatched, actuators, timed, arguments };
        let slope = self.acceleration.then(|| vec![0.0; state.len()]);
        let leading: Vec<bool> = (0..state.len()).map(|place| place >= length).collect();
        let integrator = Integrator::new(self.integrator, state.len(), &leading);
        Ok(StandardBody { integrator, motion: Motion { dynamics, state, slope }, command, outputs })
    }
}

impl StandardBody {
    /// Advances from `time` by `dt` with the command of the step before held.
    fn advance(&mut self, time: f64, dt: f64, substeps: u32, io: &Io) {
        let Self { motion: Motion { dynamics, state, .. }, integrator, .. } = self;
        dynamics.actuators.apply(io.slice(self.command));
        let length = dt / f64::from(substeps);
        for substep in 0..substeps {
            integrator.step(time + f64::from(substep) * length, length, state, |t, x, out| dynamics.slope(t, x, out));
        }
    }

    fn publish(&mut self, time: f64, io: &mut Io) {
        let Motion { dynamics, state, slope } = &mut self.motion;
        dynamics.set_arguments(time, state);
        if let Some(slope) = slope {
            dynamics.slope(time, state, slope);
        }
        self.outputs.write(io, &self.motion);
    }
}

impl Dynamics {
    fn set_arguments(&mut self, time: f64, state: &[f64]) {
        self.arguments[1..=state.len()].copy_from_slice(state);
        if self.arguments[0] != time {
            self.arguments[0] = time;
            let first = self.arguments.len() - self.timed.len();
            let (arguments, values) = self.arguments.split_at_mut(first);
            evaluate(&self.timed, arguments, values);
        }
    }

    fn slope(&mut self, time: f64, state: &[f64], out: &mut [f64]) {
        let length = self.vehicle.coordinates();
        self.set_arguments(time, state);
        let mut effect = [0.0; MAX_COORDINATES];
        self.vehicle.effect(&state[..length], &self.actuators.output, &mut effect);
        let mut disturbance = [0.0; MAX_COORDINATES];
        evaluate(&self.matched, &self.arguments, &mut disturbance);
        let driven = out.len() - length;
        if driven > 0 {
            let mut mismatched = [0.0; MAX_COORDINATES];
            evaluate(&self.mismatched, &self.arguments, &mut mismatched);
            for j in 0..length {
                out[j] = state[length + j] + mismatched[j];
            }
        }
        for j in 0..length {
            out[driven + j] = effect[j] + self.vehicle.drift(j) + disturbance[j];
        }
    }
}

/// Writes the value of each formula, and 0 where a formula is missing.
fn evaluate(formulas: &[Formula], arguments: &[f64], out: &mut [f64]) {
    for (index, value) in out.iter_mut().enumerate() {
        *value = formulas.get(index).map_or(0.0, |formula| formula.evaluate(arguments));
    }
}
