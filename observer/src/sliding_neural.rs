//! The neural sliding mode observer of section 7.2: estimates the lumped uncertainty of a vehicle of order 2.

use formation::nalgebra::{SMatrix, SVector};
use formation::scenario::Context;
use formation::vehicle::{MAX_COORDINATES, Vehicle};
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Slice, Step, Timing};
use schemars::JsonSchema;
use serde::Deserialize;

/// Gains of the observer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlidingNeural {
    /// λ̃, slope of the sliding surface, 1/s.
    pub lam_obs: f64,
    /// c̃, gain of the sliding variable, 1/s.
    pub c_obs: f64,
    /// k̃, gain of the position error, 1/s².
    pub k_obs: f64,
    /// η1, learning rate.
    pub eta1: f64,
    /// η2, leakage.
    pub eta2: f64,
}

/// The observer of one vehicle with `D` coordinates.
///
/// The network's regressor φ is the stacked state (x, v); its weights are kept as the two blocks that belong to x and to v.
#[derive(Clone, Debug)]
pub struct SlidingNeuralObserver<const D: usize> {
    gains: SlidingNeural,
    /// x̂.
    pub position: SVector<f64, D>,
    /// v̂.
    pub velocity: SVector<f64, D>,
    /// Ŵ, rows of x.
    weights_position: SMatrix<f64, D, D>,
    /// Ŵ, rows of v.
    weights_velocity: SMatrix<f64, D, D>,
    /// û, which is also the published estimate ŵ.
    pub estimate: SVector<f64, D>,
    /// Ŵᵀφ, the network's part of it.
    pub network: SVector<f64, D>,
    /// s̃.
    pub sliding: SVector<f64, D>,
}

impl<const D: usize> SlidingNeuralObserver<D> {
    /// An observer that starts at the measured position, at rest, with zero weights.
    pub fn new(gains: SlidingNeural, position: SVector<f64, D>) -> Self {
        Self {
            gains,
            position,
            velocity: SVector::zeros(),
            weights_position: SMatrix::zeros(),
            weights_velocity: SMatrix::zeros(),
            estimate: SVector::zeros(),
            network: SVector::zeros(),
            sliding: SVector::zeros(),
        }
    }

    /// Advances over the last `dt` seconds, in which `acceleration` (g u + drift) acted, and takes in the measurements of now.
    ///
    /// The weights see the sliding variable of the already advanced states (semi-implicit), which keeps coarse steps stable.
    pub fn advance(
        &mut self,
        dt: f64,
        acceleration: &SVector<f64, D>,
        position: &SVector<f64, D>,
        velocity: &SVector<f64, D>,
    ) {
        let SlidingNeural { eta1, eta2, .. } = self.gains;
        self.position += dt * self.velocity;
        self.velocity += dt * (acceleration + self.estimate); // (7.19)
        let (_, _, sliding) = self.errors(position, velocity);
        let leak = eta2 * sliding.norm();
        let learn = |weights: &mut SMatrix<f64, D, D>, regressor: &SVector<f64, D>| {
            *weights += dt * (eta1 * regressor * sliding.transpose() - leak * *weights); // (7.23)
        };
        learn(&mut self.weights_position, position);
        learn(&mut self.weights_velocity, velocity);
    }

    /// Forms the estimate from the measurements of now.
    pub fn update(&mut self, position: &SVector<f64, D>, velocity: &SVector<f64, D>) {
        let SlidingNeural { lam_obs, c_obs, k_obs, .. } = self.gains;
        let (position_error, velocity_error, sliding) = self.errors(position, velocity);
        self.network = self.weights_position.tr_mul(position) + self.weights_velocity.tr_mul(velocity);
        self.sliding = sliding;
        self.estimate = self.network + lam_obs * velocity_error + c_obs * sliding + k_obs * position_error; // (7.22)
    }

    /// Frobenius norm of the weights.
    pub fn weight_norm(&self) -> f64 {
        (self.weights_position.norm_squared() + self.weights_velocity.norm_squared()).sqrt()
    }

    /// x̃, ṽ and s̃.
    fn errors(
        &self,
        position: &SVector<f64, D>,
        velocity: &SVector<f64, D>,
    ) -> (SVector<f64, D>, SVector<f64, D>, SVector<f64, D>) {
        let position_error = position - self.position;
        let velocity_error = velocity - self.velocity;
        (position_error, velocity_error, velocity_error + self.gains.lam_obs * position_error)
    }
}

impl Component for SlidingNeural {
    fn check(&self, _: &Context) -> Checks {
        Checks::default()
            .positive("lam_obs", self.lam_obs)
            .positive("c_obs", self.c_obs)
            .positive("k_obs", self.k_obs)
            .not_negative("eta1", self.eta1)
            .not_negative("eta2", self.eta2)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        match context.agents[agent].vehicle.coordinates() {
            6 => published::<6>().fields(),
            _ => published::<3>().fields(),
        }
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        match context.agents[agent].vehicle.coordinates() {
            6 => Ok(Box::new(SlidingNeuralParticipant::<6>::new(self, context, agent, bind)?)),
            _ => Ok(Box::new(SlidingNeuralParticipant::<3>::new(self, context, agent, bind)?)),
        }
    }
}

fn published<const D: usize>() -> Outputs<SlidingNeuralObserver<D>> {
    Outputs::new()
        .vector("position", "", |observer: &SlidingNeuralObserver<D>| observer.position)
        .vector("velocity", "", |observer| observer.velocity)
        .vector("disturbance", "", |observer| observer.estimate)
        .vector("network", "", |observer| observer.network)
        .vector("sliding", "", |observer| observer.sliding)
        .scalar("weight_norm", "", SlidingNeuralObserver::weight_norm)
}

struct SlidingNeuralParticipant<const D: usize> {
    observer: SlidingNeuralObserver<D>,
    vehicle: Vehicle,
    /// Coordinates of the step before, at which the input of the last interval acted.
    position_before: SVector<f64, D>,
    position: In<D>,
    velocity: In<D>,
    input: Slice,
    outputs: BoundOutputs<SlidingNeuralObserver<D>>,
}

impl<const D: usize> SlidingNeuralParticipant<D> {
    fn new(gains: &SlidingNeural, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let nominal = &context.agents[agent].nominal;
        let start = SVector::from_column_slice(&context.agents[agent].estimate);
        Ok(Self {
            observer: SlidingNeuralObserver::new(gains.clone(), start),
            vehicle: nominal.clone(),
            position_before: start,
            position: bind.state(agent, "position")?,
            velocity: bind.state(agent, "velocity")?,
            input: bind.slice(
                formation::wiring::Role::Controller,
                agent,
                "input",
                nominal.inputs(),
                Timing::Delayed,
            )?,
            outputs: published().bind(agent, bind)?,
        })
    }

    /// g(x) u + drift of the last interval.
    fn acceleration(&self, input: &[f64]) -> SVector<f64, D> {
        let mut effect = [0.0; MAX_COORDINATES];
        self.vehicle.effect(self.position_before.as_slice(), input, &mut effect);
        SVector::from_fn(|j, _| effect[j] + self.vehicle.drift(j))
    }
}

impl<const D: usize> Participant for SlidingNeuralParticipant<D> {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let position = SVector::from(io.get(self.position));
        let velocity = SVector::from(io.get(self.velocity));
        if !step.is_first() {
            let acceleration = self.acceleration(io.slice(self.input));
            self.observer.advance(step.dt, &acceleration, &position, &velocity);
        }
        self.observer.update(&position, &velocity);
        self.position_before = position;
        self.outputs.write(io, &self.observer);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::nalgebra::Vector1;
    use proptest::prelude::*;

    const GAINS: SlidingNeural = SlidingNeural { lam_obs: 2.0, c_obs: 3.0, k_obs: 4.0, eta1: 2.0, eta2: 0.5 };

    proptest! {
        #[test]
        fn errors_decay_as_the_lyapunov_function_says(position in -5.0..5.0f64, velocity in -5.0..5.0f64) {
            // Weights of 0 are exact here: the uncertainty is 0.
            let mut observer = SlidingNeuralObserver::new(GAINS, Vector1::new(0.0));
            observer.update(&Vector1::new(position), &Vector1::new(velocity));
            let sliding = velocity + 2.0 * position;
            prop_assert_eq!(observer.sliding.x, sliding);
            // V = (s̃² + k̃ x̃²) / 2 along the motion.
            let change = sliding * (2.0 * velocity - observer.estimate.x) + 4.0 * position * velocity;
            let expected = -3.0 * sliding * sliding - 4.0 * 2.0 * position * position;
            prop_assert!((change - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn weights_learn_from_the_state_and_leak() {
        let mut observer = SlidingNeuralObserver::new(GAINS, Vector1::new(0.0));
        let (position, velocity) = (Vector1::new(1.0), Vector1::new(0.5));
        observer.update(&position, &velocity);
        // 0 + 2 · 0.5 + 3 · 2.5 + 4 · 1
        assert_eq!(observer.estimate.x, 12.5);
        observer.advance(0.1, &Vector1::new(1.0), &position, &velocity);
        assert!((observer.position.x - 0.0).abs() < 1e-15 && (observer.velocity.x - 1.35).abs() < 1e-12);
        // s̃ = -0.85 + 2 = 1.15, so the weights are 0.1 · 2 · 1.15 times the state.
        observer.update(&position, &velocity);
        assert!((observer.network.x - 0.23 * (1.0 + 0.25)).abs() < 1e-12);
        assert!((observer.weight_norm() - 0.23 * 1.25_f64.sqrt()).abs() < 1e-12);
        // With nothing to learn from, only the leak is left.
        let (before, zero) = (observer.weight_norm(), Vector1::new(0.0));
        (observer.position, observer.velocity, observer.estimate) = (Vector1::new(-1.0), zero, zero);
        observer.advance(0.1, &zero, &zero, &zero);
        assert!((observer.weight_norm() - (1.0 - 0.1 * 0.5 * 2.0) * before).abs() < 1e-12);
    }

    #[test]
    fn a_constant_uncertainty_is_estimated() {
        let mut observer = SlidingNeuralObserver::new(GAINS, Vector1::new(0.0));
        let (dt, input, uncertainty) = (0.001, 0.3, -1.7);
        let (mut position, mut velocity) = (Vector1::new(0.0), Vector1::new(0.0));
        for _ in 0..10_000 {
            observer.update(&position, &velocity);
            position += dt * velocity;
            velocity += Vector1::new(dt * (input + uncertainty));
            observer.advance(dt, &Vector1::new(input), &position, &velocity);
        }
        assert!((observer.estimate.x - uncertainty).abs() < 0.01, "{}", observer.estimate.x);
    }
}
