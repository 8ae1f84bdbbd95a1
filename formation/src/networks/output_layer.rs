//! The output layer that all networks of the thesis share: `ŵ = Ŵᵀ φ`, tuned by `dŴ/dt = η1 φ eᵀ - leak Ŵ`.

use nalgebra::{SMatrix, SVector};

/// What pulls the weights back to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Leak {
    /// `η2 Ŵ` (sigma modification). (6.13)
    Constant(f64),
    /// `η2 ‖e‖ Ŵ` (e-modification). (4.13), (7.23), (7.61)
    ByError(f64),
}

impl Leak {
    /// The factor of Ŵ at this error.
    pub(super) fn strength<const D: usize>(&self, error: &SVector<f64, D>) -> f64 {
        match self {
            Leak::Constant(eta2) => *eta2,
            Leak::ByError(eta2) => eta2 * error.norm(),
        }
    }
}

/// Weights from `P` regressors to `D` outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputLayer<const P: usize, const D: usize> {
    /// Ŵ.
    pub weights: SMatrix<f64, P, D>,
}

impl<const P: usize, const D: usize> Default for OutputLayer<P, D> {
    fn default() -> Self {
        Self { weights: SMatrix::zeros() }
    }
}

impl<const P: usize, const D: usize> OutputLayer<P, D> {
    /// A layer that starts with these weights; [`OutputLayer::default`] starts with zeros.
    pub fn new(weights: SMatrix<f64, P, D>) -> Self {
        Self { weights }
    }

    /// `Ŵᵀ φ`.
    pub fn output(&self, regressor: &SVector<f64, P>) -> SVector<f64, D> {
        self.weights.tr_mul(regressor)
    }

    /// One explicit Euler step of `dt` seconds of the tuning law, driven by `error`.
    pub fn learn(&mut self, dt: f64, rate: f64, regressor: &SVector<f64, P>, error: &SVector<f64, D>, leak: Leak) {
        self.weights += dt * (rate * regressor * error.transpose() - leak.strength(error) * self.weights);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector1, Vector2};

    #[test]
    fn learns_a_constant_and_leaks() {
        let mut layer = OutputLayer::<2, 1>::default();
        let regressor = Vector2::new(1.0, 0.5);
        for _ in 0..2000 {
            let error = Vector1::new(3.0) - layer.output(&regressor);
            layer.learn(0.01, 2.0, &regressor, &error, Leak::Constant(0.0));
        }
        assert!((layer.output(&regressor)[0] - 3.0).abs() < 1e-9);
        let before = layer.weights.norm();
        layer.learn(0.1, 0.0, &regressor, &Vector1::new(2.0), Leak::ByError(0.5));
        assert!((layer.weights.norm() / before - 0.9).abs() < 1e-12);
    }
}
