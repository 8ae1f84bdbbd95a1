//! An output layer whose weights count only up to a bound. (2.20), (2.21), (2.23)

use nalgebra::SVector;

use crate::math::Projection;

/// Weights from any number of regressors to `D` outputs: `ŵ = τ(Ŵ)ᵀ φ`, tuned by `dŴ/dt = η1 φ eᵀ`.
///
/// What is tuned is the weights themselves; the projection τ, element by element, is applied where they are used.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectedLayer<const D: usize> {
    /// Ŵ, one row per regressor.
    weights: Vec<SVector<f64, D>>,
    projection: Option<Projection>,
}

impl<const D: usize> ProjectedLayer<D> {
    /// A layer for `regressors` regressors with all weights 0; without a projection τ is the identity.
    pub fn new(regressors: usize, projection: Option<Projection>) -> Self {
        Self { weights: vec![SVector::zeros(); regressors], projection }
    }

    /// `τ(Ŵ)ᵀ φ`.
    pub fn output(&self, regressor: &[f64]) -> SVector<f64, D> {
        let mut sum = SVector::zeros();
        for (weights, value) in self.weights.iter().zip(regressor) {
            let projected = match &self.projection {
                Some(projection) => projection.vector(weights),
                None => *weights,
            };
            sum += projected * *value;
        }
        sum
    }

    /// One explicit Euler step of the tuning law, driven by `error`, where `rate` is η1 times the length of the step.
    pub fn learn(&mut self, rate: f64, regressor: &[f64], error: &SVector<f64, D>) {
        for (weights, value) in self.weights.iter_mut().zip(regressor) {
            *weights += rate * *value * error;
        }
    }

    /// Frobenius norm of Ŵ, not projected.
    pub fn weight_norm(&self) -> f64 {
        self.weights.iter().map(|row| row.norm_squared()).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector1, Vector2};
    use proptest::prelude::*;

    #[test]
    fn learns_a_constant() {
        let mut layer = ProjectedLayer::<1>::new(2, Some(Projection::new(20.0, 0.1)));
        let regressor = [1.0, 0.5];
        for _ in 0..2000 {
            let error = Vector1::new(3.0) - layer.output(&regressor);
            layer.learn(0.02, &regressor, &error);
        }
        assert!((layer.output(&regressor)[0] - 3.0).abs() < 1e-9);
        assert!((layer.weight_norm() - (2.4f64 * 2.4 + 1.2 * 1.2).sqrt()).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn the_output_is_bounded_with_a_projection_only(scale in 1.0..1e6f64, regressor in proptest::collection::vec(-1.0..1.0f64, 4)) {
            let mut layer = ProjectedLayer::<2>::new(4, Some(Projection::new(2.0, 0.1)));
            let mut free = ProjectedLayer::<2>::new(4, None);
            let error = Vector2::new(scale, -scale);
            layer.learn(1.0, &regressor, &error);
            free.learn(1.0, &regressor, &error);
            prop_assert!(layer.output(&regressor).amax() <= 2.1 * 4.0);
            prop_assert_eq!(layer.weight_norm(), free.weight_norm());
            let square: f64 = regressor.iter().map(|value| value * value).sum();
            prop_assert!((free.output(&regressor)[0] - scale * square).abs() <= 1e-9 * scale);
        }
    }
}
