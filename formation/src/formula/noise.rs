//! Random numbers by their place instead of their order.

use crate::math::SplitMix64;

/// The standard normal number with this index in the sequence of this key. It depends on nothing else, so the numbers may be
/// asked for in any order and by any process. NaN if one of both is not finite.
pub(super) fn noise(key: f64, index: f64) -> f64 {
    if !key.is_finite() || !index.is_finite() {
        return f64::NAN;
    }
    // The sum makes one of both zeros.
    let [key, index] = [key, index].map(|number| (number + 0.0).to_bits());
    let place = SplitMix64::new(SplitMix64::new(key).next_bits() ^ index).next_bits();
    let mut bits = SplitMix64::new(place);
    let mut uniform = || ((bits.next_bits() >> 11) + 1) as f64 / (1_u64 << 53) as f64;
    let (radius, turn) = (uniform(), uniform());
    // The method of Box and Muller (1958); neither number is 0.
    (-2.0 * libm::log(radius)).sqrt() * libm::cos(std::f64::consts::TAU * turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_standard_normal_and_independent() {
        const COUNT: usize = 20_000;
        // The standard error of a mean of this many is 0.007.
        for key in [0.0, 1.0, -3.5, 1e300] {
            let numbers: Vec<f64> = (0..COUNT).map(|index| noise(key, index as f64)).collect();
            let mean = |of: &dyn Fn(usize) -> f64| (0..COUNT - 1).map(of).sum::<f64>() / (COUNT - 1) as f64;
            assert!(mean(&|k| numbers[k]).abs() < 0.03, "{key}");
            assert!((mean(&|k| numbers[k] * numbers[k]) - 1.0).abs() < 0.05, "{key}");
            assert!((mean(&|k| numbers[k].powi(4)) - 3.0).abs() < 0.4, "{key}");
            assert!(mean(&|k| numbers[k] * numbers[k + 1]).abs() < 0.03, "{key}");
            assert!(mean(&|k| numbers[k] * noise(key + 1e300 + 1.0, k as f64)).abs() < 0.03, "{key}");
        }
        assert!((0..COUNT).all(|k| noise(2.0, k as f64) != noise(3.0, k as f64)));
    }

    #[test]
    fn the_numbers_stay_what_they_are() {
        assert_eq!(noise(0.0, 0.0).to_bits(), noise(-0.0, -0.0).to_bits());
        assert!(noise(f64::NAN, 0.0).is_nan() && noise(1.0, f64::INFINITY).is_nan());
        let found = [noise(1.0, 0.0), noise(1.0, 1.0), noise(2.0, -7.0)];
        assert_eq!(found, [-0.027073573060394627, -0.763065887126928, 0.08222267416317795]);
    }
}
