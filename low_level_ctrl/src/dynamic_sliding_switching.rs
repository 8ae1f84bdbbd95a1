//! The nominal dynamic sliding mode: knows bounds of the uncertainty and switches between them. (2.10)

use formation::math::sign_vector;
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::dynamic_sliding::{ErrorPorts, require_integrator};
use crate::{AccelerationSource, DynamicSlidingVariable, SlidingErrors};

/// Gains of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct DynamicSlidingSwitching {
    /// k, 1/s.
    pub k: f64,
    /// λ, 1/s.
    pub lam: f64,
    /// w1M, bound of the uncertainty, m/s².
    pub w1M: f64,
    /// w2M, bound of its rate, m/s³.
    pub w2M: f64,
    /// Sign of the term kλδv: -1.
    pub kvsign: f64,
    /// Where the derivative of ρ comes from.
    pub accel: AccelerationSource,
}

/// The controller of one agent, which reads no other agent. The input is its state.
#[derive(Clone, Debug)]
pub struct DynamicSlidingSwitchingController {
    gains: DynamicSlidingSwitching,
    /// ξ.
    pub sliding: DynamicSlidingVariable,
    /// u at this instant.
    pub input: Vector3<f64>,
    next_input: Vector3<f64>,
}

impl DynamicSlidingSwitchingController {
    /// A controller with the input 0.
    pub fn new(gains: DynamicSlidingSwitching) -> Self {
        let sliding = DynamicSlidingVariable::new(gains.k, gains.lam);
        Self { gains, sliding, input: Vector3::zeros(), next_input: Vector3::zeros() }
    }

    /// Puts the input of this instant in force and computes that of the next; at the first step there is none to compute.
    pub fn update(&mut self, step: &Step, errors: &SlidingErrors, acceleration: &Vector3<f64>, jerk: &Vector3<f64>) {
        let DynamicSlidingSwitching { k, lam, w1M: bound, w2M: rate_bound, kvsign, .. } = self.gains;
        self.sliding.update(step.dt, errors); // (2.9)
        self.input = self.next_input;
        if step.is_first() {
            return;
        }
        let switch = sign_vector(&self.sliding.value);
        let rate = -rate_bound * switch
            + jerk
            + (k + lam) * (acceleration - bound * switch - self.input)
            + kvsign * k * lam * errors.own_velocity; // (2.10)
        self.next_input = self.input + step.dt * rate;
    }
}

impl Component for DynamicSlidingSwitching {
    fn check(&self, _: &Context) -> Checks {
        Checks::default()
            .positive("k", self.k)
            .positive("lam", self.lam)
            .not_negative("w1M", self.w1M)
            .not_negative("w2M", self.w2M)
            .finite("kvsign", self.kvsign)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        require_integrator(context, agent)?;
        Ok(Box::new(DynamicSlidingSwitchingParticipant {
            controller: DynamicSlidingSwitchingController::new(self.clone()),
            errors: ErrorPorts::alone(agent, bind, self.accel)?,
            reference: [bind.reference(agent, "acceleration")?, bind.reference(agent, "jerk")?],
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

/// What a step results in.
struct Outcome {
    input: Vector3<f64>,
    sliding: Vector3<f64>,
    error: Vector3<f64>,
}

fn published(context: &Context, agent: usize) -> Outputs<Outcome> {
    Outputs::new()
        .field(context.agents[agent].vehicle.input_field(), |outcome: &Outcome| outcome.input)
        .vector("sliding", "m/s^2, m/s^2, rad/s^2", |outcome| outcome.sliding)
        .vector("error", "m, m, rad", |outcome| outcome.error)
}

struct DynamicSlidingSwitchingParticipant {
    controller: DynamicSlidingSwitchingController,
    errors: ErrorPorts,
    reference: [In<3>; 2],
    outputs: BoundOutputs<Outcome>,
}

impl Participant for DynamicSlidingSwitchingParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let [acceleration, jerk] = self.reference.map(|signal| Vector3::from(io.get(signal)));
        let errors = self.errors.read(io);
        let controller = &mut self.controller;
        controller.update(step, &errors, &acceleration, &jerk);
        let (input, sliding) = (controller.input, controller.sliding.value);
        self.outputs.write(io, &Outcome { input, sliding, error: errors.position });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_step_by_hand() {
        let accel = AccelerationSource::Difference;
        let gains = DynamicSlidingSwitching { k: 3.0, lam: 2.0, w1M: 5.0, w2M: 0.5, kvsign: -1.0, accel };
        let mut controller = DynamicSlidingSwitchingController::new(gains);
        let velocity = Vector3::new(0.1, -0.1, 0.0);
        let errors = SlidingErrors { own_velocity: velocity, position: velocity, velocity, acceleration: None };
        let (acceleration, jerk) = (Vector3::repeat(0.3), Vector3::repeat(-0.2));
        for index in 0..2 {
            controller.update(&Step { index, dt: 0.01 }, &errors, &acceleration, &jerk);
            assert_eq!(controller.input, Vector3::zeros());
        }
        let expected =
            |switch: f64, velocity: f64| 0.01 * (-0.5 * switch - 0.2 + 5.0 * (0.3 - 5.0 * switch) - 6.0 * velocity);
        let wanted = Vector3::new(expected(1.0, 0.1), expected(-1.0, -0.1), expected(0.0, 0.0));
        assert!((controller.next_input - wanted).norm() < 1e-14);
    }
}
