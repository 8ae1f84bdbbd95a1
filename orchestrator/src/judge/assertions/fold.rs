//! How vectors become numbers.

use formation::math::wrap;

/// How a vector becomes a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fold {
    Norm,
    Peak,
    Largest,
    Smallest,
}

impl Fold {
    pub(super) const ALL: [(&str, Fold); 4] =
        [("norm", Fold::Norm), ("peak", Fold::Peak), ("largest", Fold::Largest), ("smallest", Fold::Smallest)];

    pub(super) fn of(self, values: impl Iterator<Item = f64>) -> f64 {
        match self {
            Fold::Norm => values.map(|value| value * value).sum::<f64>().sqrt(),
            Fold::Peak => values.fold(0.0, |peak, value| peak.max(value.abs())),
            Fold::Largest => values.fold(f64::NEG_INFINITY, f64::max),
            Fold::Smallest => values.fold(f64::INFINITY, f64::min),
        }
    }
}

/// Differences of coordinates, those of angles (none beyond the end of `angles`) taken on the circle.
pub(super) fn on_circle(differences: impl Iterator<Item = f64>, angles: &[bool]) -> impl Iterator<Item = f64> {
    let is_angle = angles.iter().copied().chain(std::iter::repeat(false));
    differences.zip(is_angle).map(|(difference, is_angle)| if is_angle { wrap(difference) } else { difference })
}
