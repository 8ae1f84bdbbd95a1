//! How long a message is on its way.

use crate::formula::Formula;
use crate::math::RandomStream;

/// The delay of messages, s.
#[derive(Clone, Debug)]
pub enum Delay {
    /// The same for all.
    Fixed(f64),
    /// Equally likely between both.
    Uniform {
        /// The shortest, s.
        low: f64,
        /// The longest, s.
        high: f64,
    },
    /// Normal, and drawn again outside of `low` to `high`.
    Normal {
        /// Mean of the normal distribution, s.
        mean: f64,
        /// Its standard deviation, s.
        deviation: f64,
        /// The shortest, s.
        low: f64,
        /// The longest, s.
        high: f64,
    },
    /// `shift` and a number of the gamma distribution, whose mean is `shape*scale`.
    Gamma {
        /// Shape, 1.
        shape: f64,
        /// Scale, s.
        scale: f64,
        /// The shortest, s.
        shift: f64,
    },
    /// Measured delays, one for each message, from the start again behind the last.
    Trace(Vec<f64>),
    /// A formula over the slots t and distance.
    Formula(Formula),
}

/// The first of the places in a [`RandomStream`] that delays use.
const FIRST: u32 = 16;
/// How often a number is drawn again.
const MOST_DRAWS: u32 = 64;

impl Delay {
    /// The delay of the message that is sent at `step` as number `count` (from 0), with the values of the slots t and distance; never
    /// negative.
    pub fn draw(&self, stream: &RandomStream, step: u64, count: u64, slots: &[f64; 2]) -> f64 {
        let delay = match self {
            Delay::Fixed(delay) => *delay,
            Delay::Uniform { low, high } => low + (high - low) * stream.uniform(step, FIRST),
            Delay::Normal { mean, deviation, low, high } => {
                let mut draws = (0..MOST_DRAWS).map(|place| mean + deviation * stream.normal(step, FIRST + place));
                draws.find(|delay| (*low..=*high).contains(delay)).unwrap_or_else(|| mean.clamp(*low, *high))
            }
            Delay::Gamma { shape, scale, shift } => shift + scale * gamma(*shape, stream, step),
            Delay::Trace(delays) => delays[(count % delays.len() as u64) as usize],
            Delay::Formula(formula) => formula.evaluate(slots),
        };
        delay.max(0.0)
    }

    /// The mean delay, s, if it is known; of a normal distribution, that without its bounds.
    pub fn mean(&self) -> Option<f64> {
        match self {
            Delay::Fixed(delay) => Some(*delay),
            Delay::Uniform { low, high } => Some(0.5 * (low + high)),
            Delay::Normal { mean, .. } => Some(*mean),
            Delay::Gamma { shape, scale, shift } => Some(shift + shape * scale),
            Delay::Trace(delays) => Some(delays.iter().sum::<f64>() / delays.len() as f64),
            Delay::Formula(_) => None,
        }
    }

    /// The longest delay, s, if there is one; for a normal and a gamma distribution that which one message in 10^9 exceeds.
    pub fn longest(&self) -> Option<f64> {
        match self {
            Delay::Fixed(delay) => Some(*delay),
            Delay::Uniform { high, .. } => Some(*high),
            Delay::Normal { mean, deviation, high, .. } => Some((mean + 6.0 * deviation).min(*high)),
            // The upper tail of Γ(k) is below exp(-x/2) 2^k from x on.
            Delay::Gamma { shape, scale, shift } => Some(shift + scale * (2.0 * (shape * 0.7 + 20.8))),
            Delay::Trace(delays) => Some(delays.iter().copied().fold(0.0, f64::max)),
            Delay::Formula(_) => None,
        }
    }
}

/// A number of the gamma distribution of this shape, by the method of Marsaglia and Tsang (2000).
fn gamma(shape: f64, stream: &RandomStream, step: u64) -> f64 {
    if shape < 1.0 {
        let uniform = 1.0 - stream.uniform(step, FIRST + 2 * MOST_DRAWS);
        return gamma(shape + 1.0, stream, step) * libm::pow(uniform, 1.0 / shape);
    }
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    for draw in 0..MOST_DRAWS {
        let x = stream.normal(step, FIRST + 2 * draw);
        let base = 1.0 + c * x;
        let v = base * base * base;
        let uniform = 1.0 - stream.uniform(step, FIRST + 2 * draw + 1);
        if v > 0.0 && libm::log(uniform) < 0.5 * x * x + d - d * v + d * libm::log(v) {
            return d * v;
        }
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distributions_have_their_moments() {
        const COUNT: u64 = 40_000;
        let stream = RandomStream::new(3, "a link");
        let normal = Delay::Normal { mean: 0.1, deviation: 0.02, low: 0.0, high: 1.0 };
        let cases = [
            (Delay::Fixed(0.3), 0.3, 0.0),
            (Delay::Uniform { low: 0.1, high: 0.3 }, 0.2, 0.2 / 12.0_f64.sqrt()),
            (normal, 0.1, 0.02),
            (Delay::Gamma { shape: 2.5, scale: 0.02, shift: 0.01 }, 0.06, 0.02 * 2.5_f64.sqrt()),
            (Delay::Gamma { shape: 0.5, scale: 0.1, shift: 0.0 }, 0.05, 0.1 * 0.5_f64.sqrt()),
            (Delay::Trace(vec![0.1, 0.2, 0.6]), 0.3, (0.14_f64 / 3.0).sqrt()),
        ];
        for (delay, mean, deviation) in cases {
            let draws: Vec<f64> = (0..COUNT).map(|step| delay.draw(&stream, step, step, &[0.0; 2])).collect();
            let found = draws.iter().sum::<f64>() / COUNT as f64;
            let spread = (draws.iter().map(|draw| (draw - found).powi(2)).sum::<f64>() / COUNT as f64).sqrt();
            let tolerance = 4.0 * deviation / (COUNT as f64).sqrt() + 1e-5;
            assert!((found - mean).abs() < tolerance, "{delay:?}: {found}");
            assert!((spread - deviation).abs() < 0.03 * deviation + 1e-12, "{delay:?}: {spread}");
            assert!(draws.iter().all(|draw| *draw <= delay.longest().unwrap()), "{delay:?}");
        }
    }
}
