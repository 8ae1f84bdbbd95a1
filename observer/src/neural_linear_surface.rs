//! The neural observer with a linear sliding surface. (6.9), (6.11) to (6.13)

use formation::nalgebra::SVector;
use formation::networks::InitialWeights;
use formation::scenario::Context;
use formation::wiring::{Bind, Checks, Component, Refusal};
use lockstep::{Field, Participant};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::neural_surface::{Family, Published, Surface, Tuning};

/// Gains of the observer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NeuralLinearSurface {
    /// λ̃1, slope of the surface, 1/s.
    pub lt1: f64,
    /// c̃1, gain of the sliding variable, 1/s.
    pub ct1: f64,
    /// η1, learning rate.
    pub eta1: f64,
    /// η2, leakage, 1/s.
    pub eta2: f64,
    /// Ŵ(0).
    #[serde(rename = "What0")]
    pub initial_weights: InitialWeights,
    /// Which part of the imaginary input is the estimate.
    pub published: Published,
}

/// s̃ = ṽ + λ̃1 x̃, approached at the rate c̃1.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSurface {
    /// λ̃1, 1/s.
    pub slope: f64,
    /// c̃1, 1/s.
    pub gain: f64,
}

impl Surface for LinearSurface {
    fn sliding<const D: usize>(&self, position: &SVector<f64, D>, velocity: &SVector<f64, D>) -> SVector<f64, D> {
        velocity + self.slope * position // (6.11)
    }

    fn correction<const D: usize>(
        &self,
        position: &SVector<f64, D>,
        velocity: &SVector<f64, D>,
        sliding: &SVector<f64, D>,
    ) -> SVector<f64, D> {
        self.slope * velocity + self.gain * sliding + position // (6.12)
    }
}

impl NeuralLinearSurface {
    fn family(&self) -> Family<'_> {
        let tuning = Tuning { rate: self.eta1, leak: self.eta2 };
        Family { tuning, initial_weights: &self.initial_weights, published: self.published }
    }
}

impl Component for NeuralLinearSurface {
    fn check(&self, context: &Context) -> Checks {
        let checks = Checks::default()
            .positive("lt1", self.lt1)
            .positive("ct1", self.ct1)
            .not_negative("eta1", self.eta1)
            .not_negative("eta2", self.eta2);
        self.family().check(checks, context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        self.family().outputs::<LinearSurface>(&context.agents[agent].vehicle)
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let surface = LinearSurface { slope: self.lt1, gain: self.ct1 };
        self.family().build(surface, context, agents[0], bind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NeuralSurfaceObserver;
    use formation::nalgebra::Vector3;
    use formation::networks::OutputLayer;

    /// The imaginary input becomes a constant uncertainty.
    #[test]
    fn finds_a_constant() {
        let surface = LinearSurface { slope: 2.0, gain: 3.0 };
        let tuning = Tuning { rate: 10.0, leak: 1.0 };
        let truth = Vector3::new(0.4, -0.2, 0.1);
        let start = Vector3::new(0.3, -0.1, 0.2);
        let zero = Vector3::zeros();
        let mut observer = NeuralSurfaceObserver::<_, 6, 3>::new(surface, tuning, zero, zero, OutputLayer::default());
        let (dt, mut position, mut velocity) = (1e-3, start, zero);
        for _ in 0..20_000 {
            observer.update(&position, &velocity);
            // A known acceleration that keeps the vehicle near its start.
            let known = -4.0 * (position - start) - 4.0 * velocity - truth;
            observer.advance(dt, &known);
            position += dt * velocity + 0.5 * dt * dt * (known + truth);
            velocity += dt * (known + truth);
        }
        assert!((observer.input - truth).norm() < 1e-6, "{}", observer.input);
        // The leak keeps the network from the whole truth; a lasting error x̃ drives the rest, (c̃1 λ̃1 + 1) x̃.
        let rest = truth - observer.network;
        assert!(rest.norm() > 1e-3);
        assert!((7.0 * (position - observer.position) - rest).norm() < 1e-6);
    }
}
