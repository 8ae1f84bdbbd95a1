//! Clipping, and the smooth projection that replaces it where a derivative is needed.

use nalgebra::SVector;

/// `value` limited to `[-limit, limit]`.
pub fn clip(value: f64, limit: f64) -> f64 {
    value.clamp(-limit, limit)
}

/// [`clip`] of every element.
pub fn clip_vector<const D: usize>(vector: &SVector<f64, D>, limit: f64) -> SVector<f64, D> {
    vector.map(|value| clip(value, limit))
}

/// The bounded projection: the identity up to `limit`, then exponentially towards `limit + softness`. (2.21), (5.28), (7.16)
///
/// Continuously differentiable, increasing, and `|P(e)| < limit + softness`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// End of the linear range.
    pub limit: f64,
    /// Length scale of the bend; 0 means plain clipping.
    pub softness: f64,
}

impl Projection {
    /// A projection that is linear up to `limit` and bends over `softness`.
    pub fn new(limit: f64, softness: f64) -> Self {
        Self { limit, softness }
    }

    /// The projected value.
    pub fn value(&self, e: f64) -> f64 {
        let Self { limit, softness } = *self;
        if e > limit {
            if softness == 0.0 { limit } else { limit + softness * (1.0 - libm::exp((limit - e) / softness)) }
        } else if e < -limit {
            if softness == 0.0 { -limit } else { softness * (libm::exp((limit + e) / softness) - 1.0) - limit }
        } else {
            e
        }
    }

    /// The derivative of [`Projection::value`].
    pub fn slope(&self, e: f64) -> f64 {
        let Self { limit, softness } = *self;
        let beyond = e.abs() - limit;
        if beyond > 0.0 { if softness == 0.0 { 0.0 } else { libm::exp(-beyond / softness) } } else { 1.0 }
    }

    /// [`Projection::value`] of every element.
    pub fn vector<const D: usize>(&self, e: &SVector<f64, D>) -> SVector<f64, D> {
        e.map(|value| self.value(value))
    }

    /// [`Projection::slope`] of every element.
    pub fn slopes<const D: usize>(&self, e: &SVector<f64, D>) -> SVector<f64, D> {
        e.map(|value| self.slope(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bounded_increasing_and_odd(e in -50.0..50.0f64, step in 0.0..1.0f64, limit in 0.01..5.0f64, softness in 0.001..1.0f64) {
            let p = Projection::new(limit, softness);
            prop_assert!(p.value(e).abs() <= limit + softness);
            prop_assert!(p.value(e + step) >= p.value(e));
            prop_assert!((p.value(-e) + p.value(e)).abs() < 1e-12);
            prop_assert!((0.0..=1.0).contains(&p.slope(e)));
        }

        #[test]
        fn continuous_with_its_slope_at_the_switching_point(limit in 0.01..5.0f64, softness in 0.001..1.0f64) {
            let p = Projection::new(limit, softness);
            let h = 1e-9;
            prop_assert!((p.value(limit + h) - p.value(limit - h)).abs() < 3e-9);
            prop_assert!((p.slope(limit + h) - 1.0).abs() < 2.0 * h / softness);
        }
    }

    #[test]
    fn without_softness_it_clips() {
        let p = Projection::new(0.2, 0.0);
        assert_eq!([p.value(0.3), p.value(-7.0), p.value(0.1)], [0.2, -0.2, 0.1]);
        assert_eq!(clip(f64::INFINITY, 2.0), 2.0);
    }
}
