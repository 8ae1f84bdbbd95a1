//! Networks of Gaussian radial basis functions, of a size that the scenario chooses. (4.6), (4.7)

use nalgebra::{Const, DVector, Dyn, OMatrix, SVector};

use super::Leak;

/// Gaussians on the diagonal of the input space: `φ_j(Y) = exp(-|Y - d_j|² / μ²)`, `d_j = (j - shift) [1, ..., 1]`, j from 1. (4.7)
#[derive(Clone, Debug, PartialEq)]
pub struct RadialBasis {
    /// Coordinate of each centre, the same in all directions.
    centres: Vec<f64>,
    width: f64,
}

impl RadialBasis {
    /// `count` functions of width μ = `width`.
    pub fn on_diagonal(count: usize, shift: f64, width: f64) -> Self {
        Self { centres: (1..=count).map(|j| j as f64 - shift).collect(), width }
    }

    /// Number of functions.
    pub fn len(&self) -> usize {
        self.centres.len()
    }

    /// Whether there are no functions.
    pub fn is_empty(&self) -> bool {
        self.centres.is_empty()
    }

    /// Writes `φ(input)`.
    pub fn evaluate<const M: usize>(&self, input: &SVector<f64, M>, regressor: &mut DVector<f64>) {
        for (value, centre) in regressor.iter_mut().zip(&self.centres) {
            let distance_squared: f64 = input.iter().map(|y| (y - centre) * (y - centre)).sum();
            *value = libm::exp(-distance_squared / (self.width * self.width));
        }
    }
}

/// The network `ŵ = Ŵᵀ φ(Y)` with its tuning law, for `D` outputs. Allocates when it is built, and then no more.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialNetwork<const D: usize> {
    basis: RadialBasis,
    /// φ at the input of the last [`RadialNetwork::output`].
    regressor: DVector<f64>,
    /// Ŵ.
    pub weights: OMatrix<f64, Dyn, Const<D>>,
}

impl<const D: usize> RadialNetwork<D> {
    /// A network all of whose weights are `weight`.
    pub fn new(basis: RadialBasis, weight: f64) -> Self {
        let count = basis.len();
        Self {
            regressor: DVector::zeros(count),
            weights: OMatrix::from_element_generic(Dyn(count), Const::<D>, weight),
            basis,
        }
    }

    /// `Ŵᵀ φ(input)`; keeps φ for [`RadialNetwork::learn`].
    pub fn output<const M: usize>(&mut self, input: &SVector<f64, M>) -> SVector<f64, D> {
        self.basis.evaluate(input, &mut self.regressor);
        self.weights.tr_mul(&self.regressor)
    }

    /// One explicit Euler step of `dt` seconds of `dŴ/dt = rate φ errorᵀ - leak Ŵ`, with φ of the last output.
    pub fn learn(&mut self, dt: f64, rate: f64, error: &SVector<f64, D>, leak: Leak) {
        let kept = 1.0 - dt * leak.strength(error);
        self.weights.ger(dt * rate, &self.regressor, error, kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector1, Vector2};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn between_zero_and_one_and_largest_at_the_nearest_centre(x in -6.0..9.0f64, y in -6.0..9.0f64) {
            let basis = RadialBasis::on_diagonal(8, 3.0, 8.0);
            let mut regressor = DVector::zeros(8);
            basis.evaluate(&Vector2::new(x, y), &mut regressor);
            prop_assert!(regressor.iter().all(|value| (0.0..=1.0).contains(value)));
            // On the diagonal the mean of the coordinates decides.
            let nearest = (0.5 * (x + y) + 3.0).round().clamp(1.0, 8.0) as usize - 1;
            prop_assert!(regressor[nearest] >= regressor.max() - 1e-12);
        }

        #[test]
        fn one_step_of_the_law(rate in 0.0..300.0f64, leak in 0.0..20.0f64, e1 in -1.0..1.0f64, e2 in -1.0..1.0f64, weight in -1.0..1.0f64) {
            let mut network = RadialNetwork::<2>::new(RadialBasis::on_diagonal(3, 2.0, 1.5), weight);
            network.output(&Vector1::new(0.4));
            let error = Vector2::new(e1, e2);
            network.learn(0.001, rate, &error, Leak::ByError(leak));
            for j in 0..3 {
                let phi = libm::exp(-(0.4 - (j as f64 - 1.0)).powi(2) / 2.25);
                for d in 0..2 {
                    let expected = weight + 0.001 * (rate * phi * error[d] - leak * error.norm() * weight);
                    prop_assert!((network.weights[(j, d)] - expected).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn learns_a_constant_of_any_size() {
        for count in [1, 5, 12] {
            let mut network = RadialNetwork::<1>::new(RadialBasis::on_diagonal(count, 3.0, 8.0), 0.0);
            for _ in 0..3000 {
                let error = Vector1::new(3.0) - network.output(&Vector2::new(0.2, -0.1));
                network.learn(0.01, 2.0, &error, Leak::Constant(0.0));
            }
            assert!((network.output(&Vector2::new(0.2, -0.1))[0] - 3.0).abs() < 1e-9);
        }
    }
}
