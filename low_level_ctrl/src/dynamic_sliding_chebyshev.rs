//! Dynamic sliding mode with a Chebyshev network for the uncertainty and an inverse model of the actuator. (2.22), (2.23)

use formation::math::{BoucWen, Projection};
use formation::nalgebra::Vector3;
use formation::networks::{ChebyshevRegressor, ProjectedLayer};
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::dynamic_sliding::{ErrorPorts, require_integrator};
use crate::{AccelerationSource, DynamicSlidingVariable, SlidingErrors};

/// Inputs of the network: three coordinates and three velocities.
const NETWORK_INPUTS: usize = 6;

/// Gains and options of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct DynamicSlidingChebyshev {
    /// k, 1/s.
    pub k: f64,
    /// λ, 1/s.
    pub lam: f64,
    /// c, gain of the sliding variable, 1/s.
    pub c: f64,
    /// Sign of the term kλδv: -1.
    pub kvsign: f64,
    /// Where the derivative of ρ comes from.
    pub accel: AccelerationSource,
    /// η1, tuning rate of the network.
    pub eta: f64,
    /// Nc, order of the polynomials.
    pub order: u32,
    /// Whether the weights are projected.
    pub project: bool,
    /// W^M, end of the linear range of the projection.
    pub W_max: f64,
    /// ψ, softness of the projection.
    pub psi_W: f64,
    /// Whether the hysteresis of the actuator is inverted; if not, the nominal input is the input.
    pub compensate: bool,
}

/// What the controller reads at one instant besides the errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChebyshevSignals {
    /// x and v of the agent: the inputs of the network.
    pub state: [f64; NETWORK_INPUTS],
    /// ddxd.
    pub acceleration: Vector3<f64>,
    /// dddxd.
    pub jerk: Vector3<f64>,
}

/// The input as wanted, as commanded, and the memory of the actuator as the controller imagines it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatedInput {
    /// π, what the actuator is to put out.
    pub nominal: Vector3<f64>,
    /// u.
    pub command: Vector3<f64>,
    /// ζ̄.
    pub memory: Vector3<f64>,
}

/// The controller of one agent.
#[derive(Clone, Debug)]
pub struct DynamicSlidingChebyshevController {
    gains: DynamicSlidingChebyshev,
    inverse: Option<BoucWen>,
    regressor: ChebyshevRegressor,
    network: ProjectedLayer<3>,
    /// ξ.
    pub sliding: DynamicSlidingVariable,
    /// The input of this instant.
    pub input: CompensatedInput,
    next: CompensatedInput,
    /// Ê.
    pub estimate: Vector3<f64>,
    /// Frobenius norm of the weights, not projected.
    pub weight_norm: f64,
}

impl DynamicSlidingChebyshevController {
    /// A controller with zero weights and the input 0 that inverts the hysteresis `inverse`, if there is one.
    pub fn new(gains: DynamicSlidingChebyshev, inverse: Option<BoucWen>) -> Self {
        let regressor = ChebyshevRegressor::new(gains.order as usize, NETWORK_INPUTS);
        let projection = gains.project.then(|| Projection::new(gains.W_max, gains.psi_W));
        Self {
            inverse,
            network: ProjectedLayer::new(regressor.len(), projection),
            regressor,
            sliding: DynamicSlidingVariable::new(gains.k, gains.lam),
            input: CompensatedInput::default(),
            next: CompensatedInput::default(),
            estimate: Vector3::zeros(),
            weight_norm: 0.0,
            gains,
        }
    }

    /// Puts the input of this instant in force and computes that of the next. At the first step nothing is advanced: there
    /// is no ρ before it.
    pub fn update(&mut self, step: &Step, errors: &SlidingErrors, signals: &ChebyshevSignals) {
        let DynamicSlidingChebyshev { k, lam, c, kvsign, eta, .. } = self.gains;
        let regressor = self.regressor.at(&signals.state); // (2.18)
        self.estimate = self.network.output(regressor); // (2.20), (2.21)
        self.weight_norm = self.network.weight_norm();
        self.sliding.update(step.dt, errors); // (2.14)
        self.input = self.next;
        if step.is_first() {
            return;
        }
        let rate = -self.estimate + signals.jerk + (k + lam) * signals.acceleration - (k + lam) * self.input.nominal
            + kvsign * k * lam * errors.own_velocity
            - c * self.sliding.value; // (2.22)
        self.network.learn(step.dt * eta, regressor, &self.sliding.value); // (2.23)
        self.advance(step.dt * rate);
    }

    /// Changes the nominal input, and the command so that the actuator follows.
    fn advance(&mut self, change: Vector3<f64>) {
        match &self.inverse {
            Some(model) => {
                for j in 0..3 {
                    let (command_change, memory) = model.inverse(self.input.memory[j], change[j]); // (2.22)
                    self.next.command[j] = self.input.command[j] + command_change;
                    self.next.memory[j] = memory;
                }
            }
            None => self.next.command = self.input.command + change,
        }
        self.next.nominal = self.input.nominal + change;
    }
}

impl Component for DynamicSlidingChebyshev {
    fn check(&self, context: &Context) -> Checks {
        let order = format!("expected an order from 1 to 20, found {}", self.order);
        let model = "needs the model of the actuators in `[vehicle.actuator]`";
        Checks::default()
            .positive("k", self.k)
            .positive("lam", self.lam)
            .positive("c", self.c)
            .finite("kvsign", self.kvsign)
            .not_negative("eta", self.eta)
            .require((1..=20).contains(&self.order), "order", order)
            .positive("W_max", self.W_max)
            .not_negative("psi_W", self.psi_W)
            .require(!self.compensate || context.actuator.is_some(), "compensate", model)
            .led(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        require_integrator(context, agent)?;
        let inverse = context.actuator.filter(|_| self.compensate).map(|actuator| actuator.bouc_wen);
        Ok(Box::new(DynamicSlidingChebyshevParticipant {
            controller: DynamicSlidingChebyshevController::new(self.clone(), inverse),
            errors: ErrorPorts::formation(context, agent, bind, self.accel)?,
            state: [bind.state(agent, "position")?, bind.state(agent, "velocity")?],
            reference: [bind.reference(agent, "acceleration")?, bind.reference(agent, "jerk")?],
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

/// What a step results in.
struct Outcome {
    input: CompensatedInput,
    network: Vector3<f64>,
    sliding: Vector3<f64>,
    error: Vector3<f64>,
    weight_norm: f64,
}

fn published(context: &Context, agent: usize) -> Outputs<Outcome> {
    let acceleration = "m/s^2, m/s^2, rad/s^2";
    Outputs::new()
        .field(context.agents[agent].vehicle.input_field(), |outcome: &Outcome| outcome.input.command)
        .vector("nominal", acceleration, |outcome| outcome.input.nominal)
        .vector("memory", "", |outcome| outcome.input.memory)
        .vector("network", "m/s^3, m/s^3, rad/s^3", |outcome| outcome.network)
        .vector("sliding", acceleration, |outcome| outcome.sliding)
        .vector("error", "m, m, rad", |outcome| outcome.error)
        .scalar("weight_norm", "", |outcome| outcome.weight_norm)
}

struct DynamicSlidingChebyshevParticipant {
    controller: DynamicSlidingChebyshevController,
    errors: ErrorPorts,
    state: [In<3>; 2],
    reference: [In<3>; 2],
    outputs: BoundOutputs<Outcome>,
}

impl Participant for DynamicSlidingChebyshevParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let [[px, py, theta], [vx, vy, omega]] = self.state.map(|signal| io.get(signal));
        let [acceleration, jerk] = self.reference.map(|signal| Vector3::from(io.get(signal)));
        let signals = ChebyshevSignals { state: [px, py, theta, vx, vy, omega], acceleration, jerk };
        let errors = self.errors.read(io);
        let controller = &mut self.controller;
        controller.update(step, &errors, &signals);
        let outcome = Outcome {
            input: controller.input,
            network: controller.estimate,
            sliding: controller.sliding.value,
            error: errors.position,
            weight_norm: controller.weight_norm,
        };
        self.outputs.write(io, &outcome);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: BoucWen =
        BoucWen { direct: 1.5, hysteretic: 3.0, width: 1.0, slant: 0.5, smoothness: 2.0, substep: 0.01 };

    fn gains() -> DynamicSlidingChebyshev {
        DynamicSlidingChebyshev {
            k: 2.5,
            lam: 2.0,
            c: 10.0,
            kvsign: -1.0,
            accel: AccelerationSource::Difference,
            eta: 0.1,
            order: 3,
            project: true,
            W_max: 20.0,
            psi_W: 0.1,
            compensate: true,
        }
    }

    fn errors() -> SlidingErrors {
        let [own_velocity, position, velocity] = [0.2, 1.0, 0.5].map(Vector3::repeat);
        SlidingErrors { own_velocity, position, velocity, acceleration: None }
    }

    const SIGNALS: ChebyshevSignals = ChebyshevSignals {
        state: [2.0, 3.0, 0.0, 0.0, 0.0, 0.0],
        acceleration: Vector3::new(0.3, 0.3, 0.3),
        jerk: Vector3::new(-0.1, -0.1, -0.1),
    };

    #[test]
    fn two_steps_by_hand() {
        let mut controller = DynamicSlidingChebyshevController::new(gains(), Some(MODEL));
        let dt = 5e-4;
        for index in 0..3 {
            controller.update(&Step { index, dt }, &errors(), &SIGNALS);
        }
        let sliding = 2.0 * (0.5 + 2.5);
        let change = dt * (-0.1 + 4.5 * 0.3 - 5.0 * 0.2 - 10.0 * sliding);
        let (command, memory) = MODEL.inverse(0.0, change);
        let values = [controller.input.nominal[1], controller.input.command[1], controller.input.memory[1]];
        for (value, expected) in values.into_iter().zip([change, command, memory]) {
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
        }
        let square = 1.0 + 4.0 + 9.0 + 49.0 + 289.0 + 4.0 + 26.0 * 26.0 + 99.0 * 99.0;
        assert!((controller.estimate[2] - dt * 0.1 * sliding * square).abs() < 1e-9);
        let norm = dt * 0.1 * sliding * f64::sqrt(3.0 * square);
        assert!((controller.weight_norm - norm).abs() < 1e-9);
    }

    #[test]
    fn without_compensation_the_command_is_the_nominal_input() {
        let mut controller = DynamicSlidingChebyshevController::new(gains(), None);
        for index in 0..50 {
            controller.update(&Step { index, dt: 1e-3 }, &errors(), &SIGNALS);
        }
        assert_eq!(controller.input.command, controller.input.nominal);
        assert_eq!(controller.input.memory, Vector3::zeros());
        assert!(controller.input.command.norm() > 0.1);
    }
}
