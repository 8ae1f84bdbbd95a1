//! The clock of a run.

use lockstep::Period;
use schemars::JsonSchema;
use serde::Deserialize;

/// Step and length of a run.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// Length of a step, s: a whole number of nanoseconds, or a fraction such as `"1/60"`.
    pub dt: f64,
    /// Length of the run, s: a whole number of steps.
    pub duration: f64,
}

/// More steps than this are taken for a mistake.
const MAX_STEPS: f64 = 1e9;
/// The stamp of a sample counts seconds in 32 bits with a sign; a run has to end before they are used up.
const LAST_SECOND: f64 = i32::MAX as f64;
/// How far a duration may be from a whole number of steps, relative to its length: what rounding can do to numbers that are
/// written as decimals or formulas. Any real mistake is larger, as there are at most [`MAX_STEPS`] steps.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl Timing {
    /// What is wrong with these numbers: field and message.
    pub(super) fn findings(&self) -> Vec<(&'static str, String)> {
        let dt = self.dt;
        if !(dt.is_finite() && dt > 0.0) {
            return vec![("dt", format!("expected a step > 0 s, found {dt:?}"))];
        }
        if dt >= LAST_SECOND {
            return vec![("dt", format!("a step of {dt:?} s ends after {LAST_SECOND} s, the last second of a stamp"))];
        }
        let Some(period) = Period::from_seconds(dt) else {
            return vec![("dt", no_period(dt))];
        };
        self.length_finding(period).map(|message| ("duration", message)).into_iter().collect()
    }

    /// What is wrong with the length of the run, given a sound step.
    fn length_finding(&self, period: Period) -> Option<String> {
        let duration = self.duration;
        if !(duration.is_finite() && duration > 0.0) {
            return Some(format!("expected a duration > 0 s, found {duration:?}"));
        }
        if duration > LAST_SECOND {
            return Some(format!(
                "expected at most {LAST_SECOND} s (68 years), which is what the stamps of samples can hold, found {duration:?} s"
            ));
        }
        let steps = duration / period.seconds();
        if steps > MAX_STEPS + 0.5 {
            return Some(format!(
                "{duration:?} s are {steps:.0} steps of {period} s; expected at most {MAX_STEPS:.0} steps"
            ));
        }
        let whole = steps.round();
        if whole >= 1.0 && (period.time(whole as u64) - duration).abs() <= ROUNDING * duration {
            return None;
        }
        if steps < 1.0 {
            return Some(format!("{duration:?} s is less than one step of {period} s"));
        }
        let nearest = |steps: f64| format!("{:?} s ({steps} steps)", period.time(steps as u64));
        Some(format!(
            "{duration:?} s is not a whole number of steps of {period} s; the nearest are {} and {}",
            nearest(steps.floor()),
            nearest(steps.floor() + 1.0)
        ))
    }

    /// The length of a step.
    pub fn period(&self) -> Period {
        // Timings are checked when they are read; this is for those that are made by hand.
        Period::from_seconds(self.dt).unwrap_or_else(|| Period::nanoseconds((self.dt * 1e9).round().max(1.0) as u64))
    }

    /// Number of steps of length `dt` in the run. Samples are taken at its both ends: there are `periods() + 1` of them.
    pub fn periods(&self) -> u64 {
        (self.duration / self.dt).round() as u64
    }
}

/// Why `dt` cannot be a step, and what is near.
fn no_period(dt: f64) -> String {
    let expected = "expected a whole number of nanoseconds, or a fraction such as \"1/60\"";
    if dt < 1e-9 {
        return format!("{expected}, of at least 1e-9 s, found {dt:?} s");
    }
    let (rate, whole) = (1.0 / dt, (1.0 / dt).round());
    match (rate - whole).abs() <= 1e-3 * whole {
        true if whole >= 1.0 => {
            format!("{expected}, found {dt:?} s; near are \"1/{whole}\" and {:?}", to_nanoseconds(dt))
        }
        _ => format!("{expected}, found {dt:?} s; near is {:?}", to_nanoseconds(dt)),
    }
}

fn to_nanoseconds(seconds: f64) -> f64 {
    (seconds * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(dt: f64, duration: f64) -> String {
        let findings = Timing { dt, duration }.findings();
        findings.iter().map(|(field, message)| format!("{field}: {message}")).collect()
    }

    #[test]
    fn a_duration_is_a_whole_number_of_steps_at_any_length() {
        for (dt, duration) in [(0.01, 80.0), (0.1, 0.3), (0.0003, 999.9999), (1e-9, 1.0), (1.0 / 60.0, 1000.0)] {
            assert_eq!(finding(dt, duration), "");
        }
        for (dt, duration) in [(1.0 / 49.0, 3.0 / 49.0), (1001.0 / 30_000.0, 1001.0), (1.0 / 240.0, 0.1)] {
            assert_eq!(finding(dt, duration), "");
        }
        let message = finding(0.0003, 1000.0);
        assert!(message.contains("999.9999 s (3333333 steps) and 1000.0002 s (3333334 steps)"), "{message}");
        let message = finding(0.03, 0.1);
        assert!(message.starts_with("duration") && message.contains("0.09 s (3 steps) and 0.12 s"), "{message}");
        let message = finding(1.0 / 60.0, 0.333);
        assert!(message.contains("steps of 1/60 s") && message.contains("0.31666666666666665 s (19"), "{message}");
        assert_eq!(Timing { dt: 0.0005, duration: 60.0 }.periods(), 120_000);
        assert_eq!(Timing { dt: 1.0 / 60.0, duration: 60.0 }.periods(), 3600);
    }

    #[test]
    fn what_no_stamp_can_hold_is_refused() {
        for (dt, duration, part) in [
            (1e9, 5e9, "68 years"),
            (1e10, 3e10, "last second of a stamp"),
            (1e300, 1e300, "last second of a stamp"),
            (1.0, 1e300, "68 years"),
            (1e-9, 100.0, "at most 1000000000 steps"),
            (0.01, 1e-9, "less than one step"),
            (1e9, 10.0, "less than one step"),
        ] {
            assert!(finding(dt, duration).contains(part), "{}", finding(dt, duration));
        }
    }

    #[test]
    fn a_step_that_is_no_number_of_nanoseconds_has_advice() {
        assert!(
            finding(0.016_666_666_7, 1.0).contains("\"1/60\" and 0.016666667"),
            "{}",
            finding(0.016_666_666_7, 1.0)
        );
        assert!(finding(-1.0, 1.0).starts_with("dt: expected a step > 0"));
        assert!(finding(1e-10, 1.0).contains("at least 1e-9 s"));
        assert!(finding(f64::NAN, 1.0).starts_with("dt"));
    }
}
