//! Derivatives of the attitude reference: saturated slopes, per step or held over several. (7.32), (7.33), Algorithm 4

use formation::math::clip_vector;
use formation::nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

/// How the attitude reference is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Differentiation {
    /// A slope at every step.
    Slope,
    /// A slope over `n_diff` steps, held that long. Algorithm 4, corrected.
    Smoothed,
    /// Algorithm 4 as printed: the slope spans one step but is divided by `n_diff` steps.
    Printed,
}

/// Settings of both derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifferentiatorSettings {
    /// The method.
    pub method: Differentiation,
    /// Steps over which a smoothed slope is taken and held.
    pub hold: u64,
    /// Limit of the first derivative, rad/s.
    pub rate_limit: f64,
    /// Limit of the second derivative, rad/s².
    pub acceleration_limit: f64,
}

/// One saturated derivative of a sampled vector.
#[derive(Clone, Debug)]
pub struct HeldSlope {
    method: Differentiation,
    hold: u64,
    limit: f64,
    /// Steps (after the first) without a slope yet.
    delay: u64,
    before: Vector3<f64>,
    slope: Vector3<f64>,
    slopes_taken: u64,
}

impl HeldSlope {
    /// A derivative that stays 0 up to and including step `delay`, limited element by element.
    pub fn new(method: Differentiation, hold: u64, limit: f64, delay: u64) -> Self {
        Self { method, hold, limit, delay, before: Vector3::zeros(), slope: Vector3::zeros(), slopes_taken: 0 }
    }

    /// The derivative at step `index`, where the signal has the value `input`.
    pub fn update(&mut self, index: u64, dt: f64, input: &Vector3<f64>) -> Vector3<f64> {
        let held = self.hold as f64 * dt;
        if index <= self.delay {
            self.slope = Vector3::zeros();
            self.before = *input;
        } else if self.method == Differentiation::Slope {
            self.slope = (input - self.before) / dt;
            self.before = *input;
        } else if index >= self.slopes_taken * self.hold {
            self.slope = (input - self.before) / held;
            self.before = *input;
            self.slopes_taken += 1;
        } else if self.method == Differentiation::Printed {
            self.before = *input;
        }
        clip_vector(&self.slope, self.limit)
    }
}

/// First and second derivative: the second is that of the limited first.
#[derive(Clone, Debug)]
pub struct SlopePair {
    first: HeldSlope,
    second: HeldSlope,
}

impl SlopePair {
    /// Both derivatives, zero at first.
    pub fn new(settings: &DifferentiatorSettings) -> Self {
        let DifferentiatorSettings { method, hold, rate_limit, acceleration_limit } = *settings;
        Self {
            first: HeldSlope::new(method, hold, rate_limit, 1),
            second: HeldSlope::new(method, hold, acceleration_limit, 2),
        }
    }

    /// ξ1 and ξ2 at step `index`.
    pub fn update(&mut self, index: u64, dt: f64, input: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let rate = self.first.update(index, dt, input);
        let acceleration = self.second.update(index, dt, &rate);
        (rate, acceleration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(method: Differentiation, steps: u64) -> Vec<f64> {
        let mut slope = HeldSlope::new(method, 10, 100.0, 1);
        (0..steps).map(|k| slope.update(k, 0.1, &Vector3::repeat((k * k) as f64 * 0.01))[0]).collect()
    }

    #[test]
    fn per_step_slopes_start_after_the_delay() {
        let slopes = run(Differentiation::Slope, 4);
        assert_eq!(slopes[..2], [0.0, 0.0]);
        assert!((slopes[2] - 0.3).abs() < 1e-12 && (slopes[3] - 0.5).abs() < 1e-12);
    }

    /// Slopes are taken at steps 2, 10, 20, ...; the first spans one step only.
    #[test]
    fn smoothed_slopes_are_held() {
        let slopes = run(Differentiation::Smoothed, 21);
        assert!((slopes[2] - 0.03).abs() < 1e-12);
        assert_eq!(slopes[9], slopes[2]);
        assert!((slopes[10] - 0.96).abs() < 1e-12, "{}", slopes[10]);
        assert_eq!(slopes[19], slopes[10]);
        assert!((slopes[20] - 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_printed_form_is_ten_times_too_small() {
        let slopes = run(Differentiation::Printed, 21);
        assert!((slopes[20] - 0.39).abs() < 1e-12);
    }

    #[test]
    fn limits_hold() {
        let mut slope = HeldSlope::new(Differentiation::Slope, 1, 0.2, 1);
        slope.update(1, 0.1, &Vector3::zeros());
        assert_eq!(slope.update(2, 0.1, &Vector3::new(1.0, -1.0, 0.0)), Vector3::new(0.2, -0.2, 0.0));
    }
}
