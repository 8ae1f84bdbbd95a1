//! The clock of a run.

use schemars::JsonSchema;
use serde::Deserialize;

/// Step and length of a run.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// Length of a step, s.
    pub dt: f64,
    /// Length of the run, s.
    pub duration: f64,
}

/// More steps than this are taken for a mistake.
const MAX_STEPS: f64 = 1e9;

impl Timing {
    /// What is wrong with these numbers: field and message.
    pub(super) fn findings(&self) -> Vec<(&'static str, String)> {
        let mut findings = Vec::new();
        let Self { dt, duration } = *self;
        if !(dt.is_finite() && dt > 0.0) {
            findings.push(("dt", format!("expected a step > 0 s, found {dt}")));
            return findings;
        }
        if ((dt * 1e9).round() - dt * 1e9).abs() > 1e-3 || dt < 1e-9 {
            findings.push(("dt", format!("expected a whole number of nanoseconds, found {dt} s")));
        }
        if !(duration.is_finite() && duration > 0.0) {
            findings.push(("duration", format!("expected a duration > 0 s, found {duration}")));
            return findings;
        }
        let steps = duration / dt;
        if steps > MAX_STEPS {
            findings
                .push(("duration", format!("{duration} s of {dt} s are {steps:.0} steps, more than {MAX_STEPS:.0}")));
        } else if (steps - steps.round()).abs() > 1e-6 * steps.max(1.0) {
            let nearest = |steps: f64| (steps * dt * 1e9).round() / 1e9;
            let (below, above) = (nearest(steps.floor()), nearest(steps.ceil()));
            findings.push((
                "dt",
                format!(
                    "{dt} s does not divide the duration of {duration} s; the nearest durations are {below} s and {above} s"
                ),
            ));
        }
        findings
    }

    /// Number of steps of length `dt` in the run. Samples are taken at its both ends: there are `periods() + 1` of them.
    pub fn periods(&self) -> u64 {
        (self.duration / self.dt).round() as u64
    }

    /// The step in nanoseconds.
    pub fn period_ns(&self) -> u64 {
        (self.dt * 1e9).round() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_has_to_divide_the_duration() {
        assert!(Timing { dt: 0.01, duration: 80.0 }.findings().is_empty());
        assert!(Timing { dt: 0.1, duration: 0.3 }.findings().is_empty());
        let findings = Timing { dt: 0.03, duration: 0.1 }.findings();
        assert_eq!(findings[0].0, "dt");
        assert!(findings[0].1.contains("does not divide"), "{findings:?}");
        assert_eq!(Timing { dt: -1.0, duration: 1.0 }.findings()[0].0, "dt");
        assert_eq!(Timing { dt: 1e-10, duration: 1.0 }.findings()[0].0, "dt");
        assert_eq!(Timing { dt: 0.0005, duration: 60.0 }.periods(), 120_000);
    }
}
