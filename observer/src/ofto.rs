//! The finite-time observer without a network that section 4.5 compares with: the disturbance is a third state. (4.41)

use formation::math::{DifferentiatorGains, sig_vector};
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::wiring::{Bind, Checks, Component, Refusal};
use lockstep::{Fault, Field, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::position_feedback::{Estimates, Interval, PositionFeedback};
use crate::reference_rates::ReferenceRates;

/// Gains of the observer, and of the differentiator of the reference beside it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ofto {
    /// β1, exponent of the position innovation; β2 = 2 β1 - 1 is that of the others.
    pub beta1: f64,
    /// α1, gain of the position innovation.
    pub alpha1: f64,
    /// α2, gain of the velocity innovation.
    pub alpha2: f64,
    /// α3, gain of the disturbance innovation.
    pub alpha3: f64,
    /// α1 to α4 of the differentiator.
    pub diff_alpha: [f64; 4],
    /// β of the differentiator, a bound of the reference's third derivative, m/s³.
    pub diff_beta: f64,
}

/// The observer of one robot.
#[derive(Clone, Debug)]
pub struct OftoObserver {
    gains: Ofto,
    /// x̂, m and rad.
    pub position: Vector3<f64>,
    /// v̂, m/s and rad/s.
    pub velocity: Vector3<f64>,
    /// ŵ, m/s² and rad/s².
    pub estimate: Vector3<f64>,
}

impl OftoObserver {
    /// An observer with these initial estimates, and no disturbance.
    pub fn new(gains: Ofto, position: Vector3<f64>, velocity: Vector3<f64>) -> Self {
        Self { gains, position, velocity, estimate: Vector3::zeros() }
    }

    /// One explicit Euler step. All right-hand sides use the states and the measurement of the start.
    ///
    /// The thesis prints minus signs before the innovations, with which the errors `x̃ = x - x̂` would grow.
    pub fn advance(&mut self, interval: &Interval) {
        let Ofto { beta1, alpha1, alpha2, alpha3, .. } = self.gains;
        let Interval { dt, position, acceleration } = interval;
        let error = position - self.position;
        let strong = sig_vector(&error, beta1);
        let weak = sig_vector(&error, 2.0 * beta1 - 1.0);
        self.position += *dt * (self.velocity + alpha1 * strong); // (4.41)
        self.velocity += *dt * (self.estimate + alpha2 * weak + acceleration); // (4.41)
        self.estimate += *dt * (alpha3 * weak); // (4.41)
    }
}

impl Ofto {
    fn differentiator(&self) -> DifferentiatorGains<4> {
        DifferentiatorGains { alpha: self.diff_alpha, beta: self.diff_beta }
    }
}

impl Component for Ofto {
    fn check(&self, _: &Context) -> Checks {
        let checks = Checks::default()
            .between("beta1", self.beta1, 0.5, 1.0)
            .positive("alpha1", self.alpha1)
            .positive("alpha2", self.alpha2)
            .positive("alpha3", self.alpha3);
        ReferenceRates::check(checks, &self.differentiator())
    }

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        PositionFeedback::outputs().into_iter().chain(ReferenceRates::outputs()).collect()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let feedback = PositionFeedback::new("ofto", context, agent, bind)?;
        let rates = ReferenceRates::new(self.differentiator(), agent, bind)?;
        let start = |values: &[f64]| Vector3::from_column_slice(values);
        let row = &context.agents[agent];
        let observer = OftoObserver::new(self.clone(), start(&row.estimate), start(&row.estimate_velocity));
        Ok(Box::new(OftoParticipant { observer, feedback, rates }))
    }
}

struct OftoParticipant {
    observer: OftoObserver,
    feedback: PositionFeedback,
    rates: ReferenceRates,
}

impl Participant for OftoParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let (_, interval) = self.feedback.read(io, step.dt);
        if !step.is_first() {
            self.observer.advance(&interval);
        }
        let OftoObserver { position, velocity, estimate: disturbance, .. } = self.observer;
        self.feedback.publish(io, &Estimates { position, velocity, disturbance });
        self.rates.step(step, io);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gains() -> Ofto {
        Ofto {
            beta1: 2.0 / 3.0,
            alpha1: 8.0,
            alpha2: 8.0,
            alpha3: 6.0,
            diff_alpha: [6.0, 8.0, 8.0, 6.0],
            diff_beta: 0.1,
        }
    }

    #[test]
    fn one_step_uses_old_states_everywhere() {
        let mut observer = OftoObserver::new(gains(), Vector3::zeros(), Vector3::repeat(0.5));
        observer.estimate = Vector3::repeat(-1.0);
        let interval = Interval { dt: 0.01, position: Vector3::repeat(-0.008), acceleration: Vector3::repeat(2.0) };
        observer.advance(&interval);
        // sig(-0.008, 2/3) = -0.04, sig(-0.008, 1/3) = -0.2
        assert!((observer.position - Vector3::repeat(0.01 * (0.5 - 0.32))).norm() < 1e-12);
        assert!((observer.velocity - Vector3::repeat(0.5 + 0.01 * (-1.0 - 1.6 + 2.0))).norm() < 1e-12);
        assert!((observer.estimate - Vector3::repeat(-1.0 - 0.01 * 1.2)).norm() < 1e-12);
    }

    #[test]
    fn a_constant_push_is_found() {
        let mut observer = OftoObserver::new(gains(), Vector3::repeat(0.3), Vector3::zeros());
        let dt = 1e-3;
        for k in 0..20_000 {
            let t = f64::from(k) * dt;
            let position = Vector3::repeat(0.5 * 0.7 * t * t);
            observer.advance(&Interval { dt, position, acceleration: Vector3::zeros() });
        }
        assert!((observer.velocity - Vector3::repeat(0.7 * 20.0)).norm() < 1e-2, "{}", observer.velocity);
        assert!((observer.estimate - Vector3::repeat(0.7)).norm() < 1e-2, "{}", observer.estimate);
    }
}
