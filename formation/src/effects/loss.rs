//! Which messages do not arrive.

use crate::formula::Formula;
use crate::math::RandomStream;

/// Loss of messages.
#[derive(Clone, Debug)]
pub enum Loss {
    /// Each by itself, with this probability.
    Probability(f64),
    /// Bursts: a chain of two states (Gilbert 1960, Elliott 1963; `gemodel` of netem) that moves on with every message.
    Bursts {
        /// Probability of a change from the good to the bad state.
        p: f64,
        /// Probability of a change back.
        r: f64,
        /// Probability of loss in the good state.
        good: f64,
        /// Probability of loss in the bad state.
        bad: f64,
    },
    /// 1 for a message that is lost and 0 for one that arrives, from the start again behind the last.
    Trace(Vec<f64>),
    /// The probability as a formula over the slots t and distance.
    Formula(Formula),
}

/// The places in a [`RandomStream`].
const LOSS: u32 = 0;
const CHANGE: u32 = 1;

impl Loss {
    /// Whether the message that is sent at `step` as number `count` (from 0) is lost, with the values of the slots t and distance.
    /// `is_bad` is the state of the chain, false at first.
    pub fn draw(&self, stream: &RandomStream, step: u64, count: u64, slots: &[f64; 2], is_bad: &mut bool) -> bool {
        let probability = match self {
            Loss::Probability(probability) => *probability,
            Loss::Bursts { p, r, good, bad } => {
                let change = if *is_bad { *r } else { *p };
                *is_bad ^= stream.uniform(step, CHANGE) < change;
                if *is_bad { *bad } else { *good }
            }
            Loss::Trace(lost) => lost[(count % lost.len() as u64) as usize],
            Loss::Formula(formula) => formula.evaluate(slots),
        };
        probability > 0.0 && stream.uniform(step, LOSS) < probability
    }

    /// The share of messages that is lost in the long run, if that is known.
    pub fn expected(&self) -> Option<f64> {
        match self {
            Loss::Probability(probability) => Some(*probability),
            Loss::Bursts { p, r, good, bad } if p + r > 0.0 => Some((p * bad + r * good) / (p + r)),
            Loss::Bursts { good, .. } => Some(*good),
            Loss::Trace(lost) => Some(lost.iter().filter(|lost| **lost > 0.0).count() as f64 / lost.len() as f64),
            Loss::Formula(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn losses(loss: &Loss, count: u64) -> Vec<bool> {
        let (stream, mut is_bad) = (RandomStream::new(5, "a link"), false);
        (0..count).map(|step| loss.draw(&stream, step, step, &[0.0; 2], &mut is_bad)).collect()
    }

    #[test]
    fn shares_and_bursts_are_those_of_theory() {
        const COUNT: u64 = 200_000;
        let share = |lost: &[bool]| lost.iter().filter(|lost| **lost).count() as f64 / COUNT as f64;
        let lost = losses(&Loss::Probability(0.2), COUNT);
        assert!((share(&lost) - 0.2).abs() < 4.0 * (0.16 / COUNT as f64).sqrt());

        // p/(p + r) = 0.074074, bursts of 1/r = 4 messages.
        let bursts = Loss::Bursts { p: 0.02, r: 0.25, good: 0.0, bad: 1.0 };
        let lost = losses(&bursts, COUNT);
        assert!((share(&lost) - 0.074074).abs() < 0.005, "{}", share(&lost));
        assert!((bursts.expected().unwrap() - 0.074074).abs() < 1e-6);
        let starts = lost.windows(2).filter(|pair| !pair[0] && pair[1]).count();
        let length = share(&lost) * COUNT as f64 / starts as f64;
        assert!((length - 4.0).abs() < 0.25, "{length}");
    }

    #[test]
    fn a_trace_is_followed() {
        let trace = Loss::Trace(vec![0.0, 1.0, 1.0]);
        assert_eq!(losses(&trace, 6), [false, true, true, false, true, true]);
    }
}
