//! Seconds of a configuration as a [`Duration`]: the only place where a floating-point number becomes one.

use std::time::Duration;

/// The longest time that anything may be told to wait, s: a day.
pub const LONGEST_WAIT: f64 = 86_400.0;

/// A configured time, if it can be waited for: above 0, and a day at most.
///
/// # Errors
/// A message that says what was expected.
pub fn wait_time(seconds: f64) -> Result<Duration, String> {
    let time = Duration::try_from_secs_f64(seconds).unwrap_or_default();
    if time.is_zero() || seconds > LONGEST_WAIT {
        return Err(format!("expected a time above 0 and up to {LONGEST_WAIT} s, found {seconds:?}"));
    }
    Ok(time)
}

/// A computed time. What is below 0 or NaN is 0, and what is too long is the longest time that there is.
pub fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(if seconds > 0.0 { Duration::MAX } else { Duration::ZERO })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configured_time_is_above_zero_and_within_a_day() {
        assert_eq!(wait_time(0.5), Ok(Duration::from_millis(500)));
        for wrong in [0.0, -1.0, 1e-300, 86_401.0, 1e19, 1e300, f64::NAN, f64::INFINITY] {
            let message = wait_time(wrong).unwrap_err();
            assert!(
                message.contains("above 0 and up to 86400 s") && message.contains(&format!("{wrong:?}")),
                "{message}"
            );
        }
    }

    #[test]
    fn no_computed_time_panics() {
        assert_eq!(duration(1.5), Duration::from_millis(1500));
        assert_eq!([-1.0, f64::NAN, f64::NEG_INFINITY].map(duration), [Duration::ZERO; 3]);
        assert_eq!([1e300, f64::INFINITY].map(duration), [Duration::MAX; 2]);
    }
}
