//! Angles on the circle.

use std::f64::consts::{PI, TAU};

/// The angle in (-π, π] that differs from `angle` by whole turns. Angles in this interval keep their bits; what is not finite is NaN.
///
/// ```
/// use formation::math::wrap;
/// use std::f64::consts::PI;
/// assert_eq!([wrap(0.5), wrap(PI), wrap(-PI)], [0.5, PI, PI]);
/// assert!((wrap(0.5 + 4.0 * PI) - 0.5).abs() < 1e-14);
/// ```
pub fn wrap(angle: f64) -> f64 {
    let turns = ((angle - PI) / TAU).ceil();
    if turns == 0.0 { angle } else { angle - TAU * turns }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_difference_is_a_whole_number_of_turns(angle in -1e3..1e3) {
            let wrapped = wrap(angle);
            prop_assert!(wrapped > -PI - 1e-12 && wrapped <= PI + 1e-12);
            let turns = (angle - wrapped) / TAU;
            prop_assert!((turns - turns.round()).abs() < 1e-9);
        }
    }
}
