//! What fills the slots of a formula at every step.

use lockstep::ChannelId;

use super::geometry::Nearest;
use super::span::Span;

/// How a vector becomes a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fold {
    Norm,
    Peak,
    Largest,
    Smallest,
}

/// What a slot of a formula holds.
#[derive(Clone, Debug)]
pub(super) enum Slot {
    Time,
    Word(Span),
    Folded(Fold, Span, Option<Span>),
    Nearest(Nearest),
}

impl Fold {
    pub(super) const ALL: [(&str, Fold); 4] =
        [("norm", Fold::Norm), ("peak", Fold::Peak), ("largest", Fold::Largest), ("smallest", Fold::Smallest)];

    fn of(self, values: impl Iterator<Item = f64>) -> f64 {
        match self {
            Fold::Norm => values.map(|value| value * value).sum::<f64>().sqrt(),
            Fold::Peak => values.fold(0.0, |peak, value| peak.max(value.abs())),
            Fold::Largest => values.fold(f64::NEG_INFINITY, f64::max),
            Fold::Smallest => values.fold(f64::INFINITY, f64::min),
        }
    }
}

impl Slot {
    /// What it holds at `time`, in s.
    pub(super) fn value<'s>(&self, time: f64, sample: &impl Fn(ChannelId) -> &'s [f64]) -> f64 {
        match self {
            Slot::Time => time,
            Slot::Word(span) => span.of(sample)[0],
            Slot::Folded(fold, span, None) => fold.of(span.of(sample).iter().copied()),
            Slot::Folded(fold, span, Some(less)) => {
                fold.of(span.of(sample).iter().zip(less.of(sample)).map(|(a, b)| a - b))
            }
            Slot::Nearest(nearest) => nearest.value(sample),
        }
    }
}
