//! Hyperbolic tangents of the state as regressors.

use nalgebra::SVector;

/// T(Y): the hyperbolic tangent of every entry of Y = (position, velocity), so `P = 2 D`. (6.6)
pub fn tanh_of_state<const P: usize, const D: usize>(
    position: &SVector<f64, D>,
    velocity: &SVector<f64, D>,
) -> SVector<f64, P> {
    SVector::from_iterator(position.iter().chain(velocity).map(|value| libm::tanh(*value)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector1, Vector2};

    #[test]
    fn position_first() {
        let regressor: Vector2<f64> = tanh_of_state(&Vector1::new(0.5), &Vector1::new(-20.0));
        assert_eq!(regressor, Vector2::new(libm::tanh(0.5), -1.0));
    }
}
