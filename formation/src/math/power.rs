//! Signed powers, the nonlinearity of every finite-time law of the thesis.

use nalgebra::SVector;

/// The sign of `value`, with `sign(0) = 0` (and NaN passed on).
pub fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        value
    }
}

/// The signed power `sign(value) |value|^exponent`, with `sig(0, p) = 0` for every `p`, negative ones included.
///
/// ```
/// assert_eq!(formation::math::sig(-4.0, 0.5), -2.0);
/// ```
pub fn sig(value: f64, exponent: f64) -> f64 {
    if value == 0.0 { 0.0 } else { sign(value) * libm::pow(value.abs(), exponent) }
}

/// [`sig`] of every element.
pub fn sig_vector<const D: usize>(vector: &SVector<f64, D>, exponent: f64) -> SVector<f64, D> {
    vector.map(|value| sig(value, exponent))
}

/// [`sign`] of every element.
pub fn sign_vector<const D: usize>(vector: &SVector<f64, D>) -> SVector<f64, D> {
    vector.map(sign)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn odd_and_increasing(a in -1e3..1e3f64, b in -1e3..1e3f64, p in 0.05..3.0f64) {
            prop_assert_eq!(sig(-a, p), -sig(a, p));
            if a < b {
                prop_assert!(sig(a, p) <= sig(b, p));
            }
        }
    }

    #[test]
    fn zero_stays_zero() {
        assert_eq!(sig(0.0, -0.4), 0.0);
        assert_eq!(sign(-0.0), 0.0);
        assert!(sign(f64::NAN).is_nan());
    }
}
