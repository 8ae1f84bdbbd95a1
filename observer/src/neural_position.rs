//! The finite-time neural observer of section 4.4.1: velocity and disturbance from positions alone. (4.10), (4.13)

use formation::config::PerAgent;
use formation::math::{DifferentiatorGains, sig_vector};
use formation::nalgebra::{Vector3, Vector6};
use formation::networks::{Leak, RadialBasis, RadialNetwork};
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::gain_levels::{GainLevels, Gains};
use crate::position_feedback::{Estimates, Interval, PositionFeedback};
use crate::reference_rates::ReferenceRates;

/// Where the gains of the network come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GainChoice {
    /// `eta1_static` and `eta2_static` (NBOSP).
    Static,
    /// `eta1_levels` and `eta2_levels`, by the size of the error (NBOVP).
    Levels,
}

/// Gains of the observer, and of the differentiator of the reference beside it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct NeuralPosition {
    /// β1, exponent of the position innovation; β2 = 2 β1 - 1 is that of the velocity.
    pub beta1: f64,
    /// α1, gain of the position innovation.
    pub alpha1: f64,
    /// α2, gain of the velocity innovation.
    pub alpha2: f64,
    /// Number of Gaussian functions.
    pub n_rbf: usize,
    /// Centre j (from 1) is at j - rbf_shift in every direction.
    pub rbf_shift: f64,
    /// μ, width of the Gaussian functions.
    pub mu: f64,
    /// Initial value of all weights.
    pub What0: PerAgent,
    /// Which of the gains below hold.
    pub gains: GainChoice,
    /// η1, learning rate, of NBOSP.
    pub eta1_static: f64,
    /// η2, leakage, of NBOSP.
    pub eta2_static: f64,
    /// Decade of the first level of NBOVP: errors >= 10^(cv - 1).
    pub cv: f64,
    /// η1 of every level of NBOVP.
    pub eta1_levels: Vec<f64>,
    /// η2 of every level of NBOVP.
    pub eta2_levels: Vec<f64>,
    /// α1 to α4 of the differentiator.
    pub diff_alpha: [f64; 4],
    /// β of the differentiator, a bound of the reference's third derivative, m/s³.
    pub diff_beta: f64,
}

/// The observer of one robot.
#[derive(Clone, Debug)]
pub struct NeuralPositionObserver {
    gains: NeuralPosition,
    levels: GainLevels,
    network: RadialNetwork<3>,
    /// x̂, m and rad.
    pub position: Vector3<f64>,
    /// v̂, m/s and rad/s.
    pub velocity: Vector3<f64>,
    /// ŵ, m/s² and rad/s².
    pub estimate: Vector3<f64>,
    /// Level of the gains, from 1.
    pub level: usize,
}

impl NeuralPositionObserver {
    /// An observer with these initial estimates, and all weights equal to `weight`.
    pub fn new(gains: NeuralPosition, position: Vector3<f64>, velocity: Vector3<f64>, weight: f64) -> Self {
        let levels = match gains.gains {
            GainChoice::Static => {
                GainLevels::constant(Gains { learning: gains.eta1_static, leakage: gains.eta2_static })
            }
            GainChoice::Levels => GainLevels::new(gains.cv, &gains.eta1_levels, &gains.eta2_levels),
        };
        let basis = RadialBasis::on_diagonal(gains.n_rbf, gains.rbf_shift, gains.mu);
        let network = RadialNetwork::new(basis, weight);
        Self { gains, levels, network, position, velocity, estimate: Vector3::zeros(), level: 1 }
    }

    /// One explicit Euler step. All right-hand sides use the states and the measurement of the start, φ and ŵ included.
    pub fn advance(&mut self, interval: &Interval) {
        let NeuralPosition { beta1, alpha1, alpha2, .. } = self.gains;
        let Interval { dt, position, acceleration } = interval;
        let error = position - self.position;
        let strong = sig_vector(&error, beta1);
        let weak = sig_vector(&error, 2.0 * beta1 - 1.0);
        let (_, Gains { learning, leakage }) = self.levels.at(strong.norm());
        self.position += *dt * (self.velocity + alpha1 * strong); // (4.10)
        self.velocity += *dt * (alpha2 * weak + acceleration + self.estimate); // (4.10)
        self.network.learn(*dt, learning, &strong, Leak::ByError(leakage)); // (4.13)
    }

    /// Forms ŵ = Ŵᵀφ(x, v̂) with the measurement of now; the level is the one of the step that starts now.
    pub fn update(&mut self, position: &Vector3<f64>) {
        let mut input = Vector6::zeros();
        input.fixed_rows_mut::<3>(0).copy_from(position);
        input.fixed_rows_mut::<3>(3).copy_from(&self.velocity);
        self.estimate = self.network.output(&input); // (4.6)
        let strong = sig_vector(&(position - self.position), self.gains.beta1);
        (self.level, _) = self.levels.at(strong.norm()); // (4.22)
    }

    /// Frobenius norm of the weights.
    pub fn weight_norm(&self) -> f64 {
        self.network.weights.norm()
    }
}

impl NeuralPosition {
    fn differentiator(&self) -> DifferentiatorGains<4> {
        DifferentiatorGains { alpha: self.diff_alpha, beta: self.diff_beta }
    }
}

impl Component for NeuralPosition {
    fn check(&self, context: &Context) -> Checks {
        let levels = self.eta1_levels.len();
        let lengths = format!("expected as many as in `eta1_levels` ({levels}), found {}", self.eta2_levels.len());
        let weights = context.resolve(&self.What0).err().unwrap_or_default();
        let checks = Checks::default()
            .between("beta1", self.beta1, 0.5, 1.0)
            .positive("alpha1", self.alpha1)
            .positive("alpha2", self.alpha2)
            .require((1..=1000).contains(&self.n_rbf), "n_rbf", format!("expected 1 to 1000, found {}", self.n_rbf))
            .finite("rbf_shift", self.rbf_shift)
            .positive("mu", self.mu)
            .require(weights.is_empty(), "What0", weights)
            .not_negative("eta1_static", self.eta1_static)
            .not_negative("eta2_static", self.eta2_static)
            .finite("cv", self.cv)
            .require(levels > 0, "eta1_levels", "expected at least one level")
            .require(self.eta2_levels.len() == levels, "eta2_levels", lengths);
        let checks = self.eta1_levels.iter().fold(checks, |checks, eta| checks.not_negative("eta1_levels", *eta));
        let checks = self.eta2_levels.iter().fold(checks, |checks, eta| checks.not_negative("eta2_levels", *eta));
        ReferenceRates::check(checks, &self.differentiator())
    }

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        [PositionFeedback::outputs(), ReferenceRates::outputs(), published().fields()].concat()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let weight = context.value(&self.What0, agent).map_err(Refusal)?;
        let start = |values: &[f64]| Vector3::from_column_slice(values);
        let feedback = PositionFeedback::new("neural_position", context, agent, bind)?;
        let row = &context.agents[agent];
        let (position, velocity) = (start(&row.estimate), start(&row.estimate_velocity));
        Ok(Box::new(NeuralPositionParticipant {
            observer: NeuralPositionObserver::new(self.clone(), position, velocity, weight),
            feedback,
            rates: ReferenceRates::new(self.differentiator(), agent, bind)?,
            outputs: published().bind(agent, bind)?,
        }))
    }
}

/// What is published beside the estimates.
fn published() -> Outputs<NeuralPositionObserver> {
    Outputs::new()
        .scalar("weight_norm", "", NeuralPositionObserver::weight_norm)
        .scalar("level", "", |observer| observer.level as f64)
}

struct NeuralPositionParticipant {
    observer: NeuralPositionObserver,
    feedback: PositionFeedback,
    rates: ReferenceRates,
    outputs: BoundOutputs<NeuralPositionObserver>,
}

impl Participant for NeuralPositionParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let (position, interval) = self.feedback.read(io, step.dt);
        let observer = &mut self.observer;
        if !step.is_first() {
            observer.advance(&interval);
        }
        observer.update(&position);
        let NeuralPositionObserver { position, velocity, estimate: disturbance, .. } = *observer;
        self.feedback.publish(io, &Estimates { position, velocity, disturbance });
        self.outputs.write(io, observer);
        self.rates.step(step, io);
        Ok(())
    }
}

#[cfg(test)]
#[path = "neural_position/tests.rs"]
mod tests;
