//! The neural observer with a terminal sliding surface, which settles in finite time. (6.9), (6.13), (6.16), (6.17)

use formation::math::sig_vector;
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
pub struct NeuralTerminalSurface {
    /// λ̃1, slope of the linear part of the surface, 1/s.
    pub lt1: f64,
    /// λ̃2, weight of the power in the surface.
    pub lt2: f64,
    /// Numerator of the exponent p.
    pub p1: f64,
    /// Denominator of the exponent p.
    pub p2: f64,
    /// Limit of |x̃|^(p-1), the slope of the power without the factor p.
    pub h: f64,
    /// c̃1, gain of the sliding variable, 1/s.
    pub ct1: f64,
    /// c̃2, gain of its power.
    pub ct2: f64,
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

/// s̃ = ṽ + λ̃1 x̃ + λ̃2 x̃^p, approached at the rates c̃1 and c̃2. Powers are odd: they keep the sign.
#[derive(Clone, Debug, PartialEq)]
pub struct TerminalSurface {
    /// λ̃1, 1/s.
    pub slope: f64,
    /// λ̃2.
    pub power_weight: f64,
    /// p, between 0 and 1.
    pub exponent: f64,
    /// h.
    pub slope_limit: f64,
    /// c̃1, 1/s.
    pub gain: f64,
    /// c̃2.
    pub power_gain: f64,
}

impl TerminalSurface {
    /// |x̃|^(p-1), limited to h; infinite without the limit where x̃ = 0.
    fn limited_slope(&self, position: f64) -> f64 {
        libm::pow(position.abs(), self.exponent - 1.0).min(self.slope_limit)
    }
}

impl Surface for TerminalSurface {
    fn sliding<const D: usize>(&self, position: &SVector<f64, D>, velocity: &SVector<f64, D>) -> SVector<f64, D> {
        velocity + self.slope * position + self.power_weight * sig_vector(position, self.exponent) // (6.16)
    }

    fn correction<const D: usize>(
        &self,
        position: &SVector<f64, D>,
        velocity: &SVector<f64, D>,
        sliding: &SVector<f64, D>,
    ) -> SVector<f64, D> {
        let slope = position.map(|value| self.limited_slope(value));
        self.gain * sliding
            + self.power_gain * sig_vector(sliding, self.exponent)
            + position
            + self.slope * velocity
            + self.exponent * self.power_weight * slope.component_mul(velocity) // (6.17)
    }
}

impl NeuralTerminalSurface {
    fn family(&self) -> Family<'_> {
        let tuning = Tuning { rate: self.eta1, leak: self.eta2 };
        Family { tuning, initial_weights: &self.initial_weights, published: self.published }
    }
}

impl Component for NeuralTerminalSurface {
    fn check(&self, context: &Context) -> Checks {
        let exponent = format!("expected p1 < p2, an exponent p1/p2 below 1, found {}/{}", self.p1, self.p2);
        let checks = Checks::default()
            .positive("lt1", self.lt1)
            .not_negative("lt2", self.lt2)
            .positive("p1", self.p1)
            .positive("p2", self.p2)
            .require(self.p1 < self.p2, "p1", exponent)
            .positive("h", self.h)
            .positive("ct1", self.ct1)
            .not_negative("ct2", self.ct2)
            .not_negative("eta1", self.eta1)
            .not_negative("eta2", self.eta2);
        self.family().check(checks, context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        self.family().outputs::<TerminalSurface>(&context.agents[agent].vehicle)
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let surface = TerminalSurface {
            slope: self.lt1,
            power_weight: self.lt2,
            exponent: self.p1 / self.p2,
            slope_limit: self.h,
            gain: self.ct1,
            power_gain: self.ct2,
        };
        self.family().build(surface, context, agents[0], bind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::nalgebra::Vector1;
    use proptest::prelude::*;

    const SURFACE: TerminalSurface =
        TerminalSurface { slope: 1.5, power_weight: 0.5, exponent: 0.6, slope_limit: 1.0, gain: 3.0, power_gain: 3.0 };

    proptest! {
        /// Both are odd functions of the errors, however small: no power of a negative number.
        #[test]
        fn odd(position in -2.0..2.0f64, velocity in -2.0..2.0f64) {
            let value = |position: f64, velocity: f64| {
                let (position, velocity) = (Vector1::new(position), Vector1::new(velocity));
                let sliding = SURFACE.sliding(&position, &velocity);
                [sliding.x, SURFACE.correction(&position, &velocity, &sliding).x]
            };
            let (plus, minus) = (value(position, velocity), value(-position, -velocity));
            prop_assert_eq!(plus, minus.map(|value| -value));
            prop_assert!(plus.iter().all(|value| value.is_finite()));
        }
    }

    #[test]
    fn written_out_for_one_coordinate() {
        let (position, velocity) = (Vector1::new(-0.4), Vector1::new(0.1));
        let sliding = SURFACE.sliding(&position, &velocity);
        let s = 0.1 - 1.5 * 0.4 - 0.5 * libm::pow(0.4, 0.6);
        assert!((sliding.x - s).abs() < 1e-15);
        // |x̃|^(p-1) = 1.44 is beyond the limit 1.
        let expected = 3.0 * s - 3.0 * libm::pow(-s, 0.6) - 0.4 + 1.5 * 0.1 + 0.6 * 0.5 * 1.0 * 0.1;
        assert!((SURFACE.correction(&position, &velocity, &sliding).x - expected).abs() < 1e-14);
        assert_eq!([SURFACE.limited_slope(0.0), SURFACE.limited_slope(2.0)], [1.0, libm::pow(2.0, -0.4)]);
    }
}
