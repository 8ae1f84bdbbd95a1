//! The length of a step: a rational number of nanoseconds, so that steps of 1/60 s do not drift.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Nanoseconds of a second.
const SECOND: u64 = 1_000_000_000;
/// Largest numerator of a fraction of seconds that is recognised. Together with the next limit it is small enough that no
/// two such fractions share a double, and that a fraction is a convergent of its double.
const LARGEST_NUMERATOR: u128 = 1_000_000;
/// Largest denominator of a fraction of seconds that is recognised: a step takes at least a nanosecond.
const LARGEST_DENOMINATOR: u128 = SECOND as u128;

/// The length of a step: `ns / per` nanoseconds, in lowest terms.
///
/// Step k begins at k times this length, and its stamp is that time rounded to the nearest nanosecond. So steps of 1/60 s are
/// stamped 0, 16666667, 33333333, 50000000 ns, and step 60 begins at one second exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Period {
    ns: u64,
    per: u64,
}

impl Period {
    /// A whole number of nanoseconds.
    pub const fn nanoseconds(ns: u64) -> Self {
        Self { ns, per: 1 }
    }

    /// The length that a double of seconds stands for: the whole number of nanoseconds, or else the fraction `p/q` of seconds
    /// with p up to a million and q up to a billion, whose double it is. `None` if it is neither, or not above 0.
    pub fn from_seconds(seconds: f64) -> Option<Self> {
        let ns = (seconds * SECOND as f64).round();
        if !(ns >= 1.0 && ns < u64::MAX as f64) {
            return None;
        }
        // Formulas of numbers may miss the double that the decimal number has by its last digits.
        if (ns / SECOND as f64 - seconds).abs() <= 4.0 * f64::EPSILON * seconds {
            return Some(Self::nanoseconds(ns as u64));
        }
        let (numerator, denominator) = fraction(seconds)?;
        let (ns, per) = (u64::try_from(numerator).ok()? * SECOND, u64::try_from(denominator).ok()?);
        let shared = greatest_common_divisor(ns, per);
        Some(Self { ns: ns / shared, per: per / shared })
    }

    /// The length in seconds: the double that is nearest to it.
    pub fn seconds(self) -> f64 {
        // Both numbers are exact up to 2^53, and the division is rounded once.
        match self.seconds_fraction() {
            Some((numerator, denominator)) => numerator as f64 / denominator as f64,
            None => self.ns as f64 / SECOND as f64,
        }
    }

    /// The length rounded to whole nanoseconds, for protocols that count those.
    pub fn rounded_ns(self) -> u64 {
        self.time_ns(1)
    }

    /// When `step` begins, rounded to the nearest nanosecond; the largest number there is, if it is beyond that.
    pub fn time_ns(self, step: u64) -> u64 {
        if self.per == 1 {
            return step.saturating_mul(self.ns);
        }
        let (step, ns, per) = (u128::from(step), u128::from(self.ns), u128::from(self.per));
        u64::try_from((step * ns + per / 2) / per).unwrap_or(u64::MAX)
    }

    /// When `step` begins, in seconds: the double that is nearest to it as long as `step * p` is below 2^53.
    pub fn time(self, step: u64) -> f64 {
        match self.seconds_fraction() {
            Some((numerator, denominator)) => step as f64 * numerator as f64 / denominator as f64,
            None => step as f64 * self.ns as f64 / SECOND as f64,
        }
    }

    /// How many steps begin within `ns` nanoseconds.
    pub fn steps_within(self, ns: u64) -> u64 {
        u64::try_from(u128::from(ns) * u128::from(self.per) / u128::from(self.ns.max(1))).unwrap_or(u64::MAX)
    }

    /// `p/q` in seconds and lowest terms; `None` if it is a whole number of nanoseconds.
    fn seconds_fraction(self) -> Option<(u64, u64)> {
        if self.per == 1 {
            return None;
        }
        let shared = greatest_common_divisor(self.ns, SECOND);
        Some((self.ns / shared, self.per * (SECOND / shared)))
    }
}

impl From<u64> for Period {
    fn from(ns: u64) -> Self {
        Self::nanoseconds(ns)
    }
}

/// Seconds as one writes them: `0.01`, `1/60`.
impl fmt::Display for Period {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.seconds_fraction() {
            Some((numerator, denominator)) => write!(f, "{numerator}/{denominator}"),
            None => write!(f, "{}", self.seconds()),
        }
    }
}

/// The fraction within the limits whose double is `value`, which is above 0 and below 2^64: the first convergent of its
/// continued fraction that rounds to it.
fn fraction(value: f64) -> Option<(u128, u128)> {
    let (mut dividend, mut divisor) = exact(value)?;
    let (mut before, mut now) = ((0, 1), (1, 0));
    while divisor != 0 {
        let whole = dividend / divisor;
        let next = |now: u128, before: u128| whole.checked_mul(now)?.checked_add(before);
        let found = (next(now.0, before.0)?, next(now.1, before.1)?);
        if found.0 > LARGEST_NUMERATOR || found.1 > LARGEST_DENOMINATOR {
            return None;
        }
        if found.0 as f64 / found.1 as f64 == value {
            return Some(found);
        }
        (before, now) = (now, found);
        (dividend, divisor) = (divisor, dividend % divisor);
    }
    None
}

/// A double as the quotient of two integers; `None` if they do not fit.
fn exact(value: f64) -> Option<(u128, u128)> {
    let (bits, fraction_bits) = (value.to_bits(), f64::MANTISSA_DIGITS - 1);
    let exponent = i32::try_from(bits >> fraction_bits).ok()? - 1075;
    let mantissa = u128::from(bits & ((1 << fraction_bits) - 1) | 1 << fraction_bits);
    let power = 1u128.checked_shl(exponent.unsigned_abs()).filter(|power| *power != 0 && exponent.abs() < 127)?;
    if exponent < 0 { Some((mantissa, power)) } else { mantissa.checked_mul(power).map(|whole| (whole, 1)) }
}

fn greatest_common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_double_of_a_fraction_stands_for_it() {
        for n in (1..2_000).chain([1_048_576, 44_100, 999_999_937, 1_000_000_000]) {
            let period = Period::from_seconds(1.0 / n as f64).unwrap();
            assert_eq!(period.time_ns(n), 1_000_000_000, "1/{n}");
            assert_eq!(period.seconds(), 1.0 / n as f64);
            assert_eq!(period.time(n), 1.0);
        }
        for (p, q) in [(2u64, 3u64), (1001, 30_000), (5, 7), (999_983, 1_000_003), (1000, 7)] {
            let period = Period::from_seconds(p as f64 / q as f64).unwrap();
            assert_eq!(period.time_ns(q), p * SECOND);
            assert_eq!(period.to_string(), format!("{p}/{q}"));
        }
    }

    #[test]
    fn whole_nanoseconds_stay_what_they_are() {
        for ns in [1, 2, 3, 300_000, 33_333_300, 1_000_000, 10_000_000, 123_456_789, 3 * SECOND] {
            let seconds = ns as f64 / 1e9;
            assert_eq!(Period::from_seconds(seconds), Some(Period::nanoseconds(ns)));
            assert_eq!(Period::nanoseconds(ns).seconds(), seconds);
        }
        assert_eq!(Period::from_seconds(0.1 * 0.3 / 10.0), Some(Period::nanoseconds(3_000_000)));
        assert_eq!(Period::nanoseconds(10_000_000).to_string(), "0.01");
    }

    #[test]
    fn a_number_that_is_neither_is_refused() {
        let neither =
            [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 1e-10, 0.016_666_666_67 + 1e-13, std::f64::consts::PI];
        neither.into_iter().for_each(|seconds| assert_eq!(Period::from_seconds(seconds), None, "{seconds}"));
    }

    #[test]
    fn stamps_are_rounded_and_do_not_drift() {
        let period = Period::from_seconds(1.0 / 60.0).unwrap();
        let stamps = [0, 1, 2, 3, 60, 3_600_000].map(|step| period.time_ns(step));
        assert_eq!(stamps, [0, 16_666_667, 33_333_333, 50_000_000, SECOND, 60_000 * SECOND]);
        assert_eq!(period.steps_within(SECOND / 30), 1);
        assert_eq!(Period::nanoseconds(2).time_ns(u64::MAX), u64::MAX);
    }
}
