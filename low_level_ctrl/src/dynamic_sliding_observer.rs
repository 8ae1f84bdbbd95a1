//! Dynamic sliding mode with a disturbance observer: designs the rate of the input, which therefore stays smooth. (2.15)

use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::dynamic_sliding::ErrorPorts;
use crate::{AccelerationSource, DynamicSlidingVariable, SlidingErrors};

/// Gains of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DynamicSlidingObserver {
    /// k, 1/s.
    pub k: f64,
    /// λ, 1/s.
    pub lam: f64,
    /// c, gain of the sliding variable, 1/s.
    pub c: f64,
    /// Sign of the term kλδv: -1; +1 is what (2.15) prints.
    pub kvsign: f64,
    /// Where the derivative of ρ comes from.
    pub accel: AccelerationSource,
}

/// What the controller reads at one instant besides the errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicSlidingSignals {
    /// ddxd.
    pub acceleration: Vector3<f64>,
    /// dddxd.
    pub jerk: Vector3<f64>,
    /// γ2, estimate of the uncertainty.
    pub disturbance: Vector3<f64>,
    /// γ3, estimate of its rate.
    pub disturbance_rate: Vector3<f64>,
}

/// The controller of one agent. The input is its state.
#[derive(Clone, Debug)]
pub struct DynamicSlidingObserverController {
    gains: DynamicSlidingObserver,
    /// ξ.
    pub sliding: DynamicSlidingVariable,
    /// u at this instant.
    pub input: Vector3<f64>,
    /// u at the next step.
    pub next_input: Vector3<f64>,
}

impl DynamicSlidingObserverController {
    /// A controller with the input 0.
    pub fn new(gains: DynamicSlidingObserver) -> Self {
        let sliding = DynamicSlidingVariable::new(gains.k, gains.lam);
        Self { gains, sliding, input: Vector3::zeros(), next_input: Vector3::zeros() }
    }

    /// Puts the input of this instant in force and computes that of the next. At the first step nothing is advanced: there
    /// is no ρ before it.
    pub fn update(&mut self, step: &Step, errors: &SlidingErrors, signals: &DynamicSlidingSignals) {
        let DynamicSlidingObserver { k, lam, c, kvsign, .. } = self.gains;
        self.sliding.update(step.dt, errors); // (2.14)
        self.input = self.next_input;
        if step.is_first() {
            return;
        }
        let rate = -signals.disturbance_rate + signals.jerk
            - (k + lam) * (self.input + signals.disturbance - signals.acceleration)
            + kvsign * k * lam * errors.own_velocity
            - c * self.sliding.value; // (2.15)
        self.next_input = self.input + step.dt * rate;
    }
}

impl Component for DynamicSlidingObserver {
    fn check(&self, context: &Context) -> Checks {
        Checks::default()
            .positive("k", self.k)
            .positive("lam", self.lam)
            .positive("c", self.c)
            .finite("kvsign", self.kvsign)
            .led(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        crate::dynamic_sliding::require_integrator(context, agent)?;
        Ok(Box::new(DynamicSlidingObserverParticipant {
            controller: DynamicSlidingObserverController::new(self.clone()),
            errors: ErrorPorts::formation(context, agent, bind, self.accel)?,
            signals: [
                bind.reference(agent, "acceleration")?,
                bind.reference(agent, "jerk")?,
                bind.estimate(agent, "disturbance")?,
                bind.estimate(agent, "disturbance_rate")?,
            ],
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

/// What a step results in.
struct Outcome {
    input: Vector3<f64>,
    next_input: Vector3<f64>,
    sliding: Vector3<f64>,
    error: Vector3<f64>,
}

fn published(context: &Context, agent: usize) -> Outputs<Outcome> {
    let input = context.agents[agent].vehicle.input_field();
    let next_input = Field { name: "next_input".into(), ..input.clone() };
    Outputs::new()
        .field(input, |outcome: &Outcome| outcome.input)
        .field(next_input, |outcome| outcome.next_input)
        .vector("sliding", "m/s^2, m/s^2, rad/s^2", |outcome| outcome.sliding)
        .vector("error", "m, m, rad", |outcome| outcome.error)
}

struct DynamicSlidingObserverParticipant {
    controller: DynamicSlidingObserverController,
    errors: ErrorPorts,
    signals: [In<3>; 4],
    outputs: BoundOutputs<Outcome>,
}

impl Participant for DynamicSlidingObserverParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let [acceleration, jerk, disturbance, disturbance_rate] =
            self.signals.map(|signal| Vector3::from(io.get(signal)));
        let signals = DynamicSlidingSignals { acceleration, jerk, disturbance, disturbance_rate };
        let errors = self.errors.read(io);
        let controller = &mut self.controller;
        controller.update(step, &errors, &signals);
        let DynamicSlidingObserverController { input, next_input, .. } = *controller;
        let sliding = controller.sliding.value;
        self.outputs.write(io, &Outcome { input, next_input, sliding, error: errors.position });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: DynamicSlidingObserver =
        DynamicSlidingObserver { k: 3.0, lam: 2.0, c: 1.5, kvsign: -1.0, accel: AccelerationSource::Difference };

    fn at(index: u64) -> Step {
        Step { index, dt: 0.01 }
    }

    #[test]
    fn one_step_by_hand_after_one_without_effect() {
        let mut controller = DynamicSlidingObserverController::new(GAINS);
        let errors = SlidingErrors {
            own_velocity: Vector3::repeat(0.2),
            position: Vector3::repeat(1.0),
            velocity: Vector3::repeat(0.5),
            acceleration: None,
        };
        let signals = DynamicSlidingSignals {
            acceleration: Vector3::repeat(0.3),
            jerk: Vector3::repeat(-0.1),
            disturbance: Vector3::repeat(0.7),
            disturbance_rate: Vector3::repeat(0.4),
        };
        controller.update(&at(0), &errors, &signals);
        assert_eq!(controller.next_input, Vector3::zeros());
        controller.update(&at(1), &errors, &signals);
        assert_eq!(controller.input, Vector3::zeros());
        let sliding = 2.0 * 3.5;
        let rate = -0.4 - 0.1 - 5.0 * (0.7 - 0.3) - 6.0 * 0.2 - 1.5 * sliding;
        assert!((controller.next_input[0] - 0.01 * rate).abs() < 1e-14);
        controller.update(&at(2), &errors, &signals);
        assert!((controller.input[0] - 0.01 * rate).abs() < 1e-14);
    }
}
