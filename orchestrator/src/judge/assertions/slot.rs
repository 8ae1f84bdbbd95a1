//! What fills the slots of a formula at every step.

use lockstep::ChannelId;

use super::fold::{Fold, on_circle};
use super::geometry::Nearest;
use super::span::Span;

/// What a slot of a formula holds.
#[derive(Clone, Debug)]
pub(super) enum Slot {
    Time,
    Word(Span),
    Folded(Fold, Span, Option<Span>),
    Nearest(Nearest),
    /// A number about the links to the agent, with their signals: age, messages sent, messages lost.
    Links(About, Vec<[Span; 3]>),
    /// The distance from the position of the agent to its place in the formation, and which coordinates are angles.
    Tracking(Span, Span, Vec<bool>),
}

/// What is asked about the links to an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum About {
    /// The largest age, s.
    Age,
    /// The share of messages that were lost.
    Loss,
    /// The messages that were sent.
    Messages,
}

impl About {
    /// The number for links with these signals: age, messages sent, messages lost.
    fn of<'s>(self, links: &[[Span; 3]], sample: &impl Fn(ChannelId) -> &'s [f64]) -> f64 {
        let all = |place: usize| links.iter().map(move |spans| spans[place].of(sample)[0]);
        match self {
            About::Age => all(0).fold(0.0, f64::max),
            About::Messages => all(1).sum(),
            About::Loss => {
                let sent: f64 = all(1).sum();
                if sent > 0.0 { all(2).sum::<f64>() / sent } else { 0.0 }
            }
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
            Slot::Links(about, links) => about.of(links, sample),
            Slot::Tracking(own, place, angles) => {
                let difference = own.of(sample).iter().zip(place.of(sample)).map(|(own, place)| own - place);
                Fold::Norm.of(on_circle(difference, angles))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_whole_turn_is_no_difference_of_angles() {
        let tracking = Slot::Tracking(Span::of_test(0, 2), Span::of_test(2, 2), vec![false, true]);
        fn of<'a>(samples: &'a [f64; 4]) -> impl Fn(ChannelId) -> &'a [f64] {
            move |_| samples
        }
        assert!((tracking.value(0.0, &of(&[3.0, TAU + 0.5, 0.0, 0.5])) - 3.0).abs() < 1e-12);
        assert!((tracking.value(0.0, &of(&[TAU, 0.5, 0.0, 0.5])) - TAU).abs() < 1e-12);
    }
}
