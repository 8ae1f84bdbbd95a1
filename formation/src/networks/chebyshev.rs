//! Chebyshev polynomials of the inputs as regressors. (2.18)

/// `φ = [1, T1(y1) .. T1(yq), T2(y1) .. T2(yq), ..., Tn(y1) .. Tn(yq)]` for `q` inputs and the order n.
///
/// The recursion is `T(n+1)(y) = 2 y Tn(y) - T(n-1)(y)` with `T0(y) = 1` and `T1(y) = y`; the inputs are taken as they are.
#[derive(Clone, Debug, PartialEq)]
pub struct ChebyshevRegressor {
    inputs: usize,
    values: Vec<f64>,
}

impl ChebyshevRegressor {
    /// A regressor of `order` for `inputs` numbers.
    pub fn new(order: usize, inputs: usize) -> Self {
        let mut values = vec![0.0; 1 + order * inputs];
        values[0] = 1.0;
        Self { inputs, values }
    }

    /// Number of regressors.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Never: there is always the constant one.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// φ at `inputs`, which must be as many as announced.
    pub fn at(&mut self, inputs: &[f64]) -> &[f64] {
        for (j, y) in inputs.iter().enumerate().take(self.inputs) {
            let (mut before, mut value) = (1.0, *y);
            for place in (1 + j..self.values.len()).step_by(self.inputs) {
                self.values[place] = value;
                (before, value) = (value, 2.0 * y * value - before);
            }
        }
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn order_three_of_six_inputs() {
        let mut regressor = ChebyshevRegressor::new(3, 6);
        let expected =
            [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 7.0, 17.0, -1.0, -1.0, -1.0, -1.0, 26.0, 99.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(regressor.at(&[2.0, 3.0, 0.0, 0.0, 0.0, 0.0]), expected);
        assert_eq!((regressor.len(), ChebyshevRegressor::new(5, 6).len()), (19, 31));
    }

    proptest! {
        /// `Tn(cos a) = cos(n a)` is what defines the polynomials.
        #[test]
        fn polynomials_of_a_cosine(angle in 0.0..3.1f64, order in 1..9usize) {
            let mut regressor = ChebyshevRegressor::new(order, 1);
            let values = regressor.at(&[libm::cos(angle)]);
            for (n, value) in values.iter().enumerate() {
                prop_assert!((value - libm::cos(n as f64 * angle)).abs() < 1e-10);
            }
        }
    }
}
