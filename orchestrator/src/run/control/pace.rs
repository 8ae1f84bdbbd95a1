//! Steps at given times: simulated time that keeps pace with the clock on the wall.

use std::time::{Duration, Instant};

use formation::scenario::Overrun;

use super::RunControl;

/// Classes of lateness per doubling.
const CLASSES: f64 = 16.0;
/// Number of classes: up to 2^40 us.
const COUNT: usize = 640;
/// A start that is late by more than this share of a period has missed it: commands that are this much closer than a period
/// still count as one per period.
const SLACK: f64 = 0.25;

/// How well a run kept its times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pacing {
    /// Steps that were paced.
    pub steps: u64,
    /// Steps that could not start in time, because the step before was not done.
    pub overruns: u64,
    /// Those of them that started more than a period too late.
    pub beyond: u64,
    /// Periods in which no step started: the run is behind the clock by so many.
    pub skipped: u64,
    /// Delays that 50, 90, 99 and 99.9 % of the starts kept, s; exact to 5 %. See [`Pacing::SHARES`].
    pub quantiles: [f64; 4],
    /// Largest delay of a start, s.
    pub worst: f64,
}

impl Pacing {
    /// Shares of the starts, per thousand.
    pub const SHARES: [u64; 4] = [500, 900, 990, 999];
}

/// How a step was started.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Start {
    /// How late, s; periods that were skipped for it included.
    pub(crate) late: f64,
    /// Whether the step before was not done in time.
    pub(crate) missed: bool,
    /// How many periods were skipped before it.
    pub(crate) skipped: u64,
}

/// A step that was late by a period or more, where that ends the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TooLate {
    /// How late, s.
    pub(crate) late: f64,
    /// What a period takes, s.
    pub(crate) period: f64,
}

/// Paces a run.
pub(crate) struct Pace {
    /// Wall-clock seconds per step.
    period: f64,
    overrun: Overrun,
    /// The step that started at the origin.
    first: u64,
    /// Periods that were skipped since.
    shifted: u64,
    origin: Instant,
    pacing: Pacing,
    classes: Box<[u32; COUNT]>,
    /// How the newest step was started.
    last: Start,
}

impl Pace {
    /// Steps of `dt` simulated seconds, `factor` times as fast as the clock.
    pub(crate) fn new(dt: f64, factor: f64, overrun: Overrun) -> Self {
        let (pacing, last) = (Pacing::default(), Start::default());
        let classes = Box::new([0; COUNT]);
        Self { period: dt / factor, overrun, first: 0, shifted: 0, origin: Instant::now(), pacing, classes, last }
    }

    /// Counts the times from `step` and from now.
    pub(crate) fn restart(&mut self, step: u64) {
        (self.first, self.shifted, self.origin) = (step, 0, Instant::now());
    }

    /// Waits for the time of `step`. Every time is counted from the origin, so that delays do not add up. A step whose time has
    /// passed is treated as the scenario says: it starts at once, or with the next period, or not at all.
    ///
    /// # Errors
    /// [`TooLate`] if the step is late by a period or more, and that is to end the run.
    pub(crate) fn wait(&mut self, step: u64, stop: &RunControl) -> Result<(), TooLate> {
        let elapsed = self.origin.elapsed();
        let late = seconds_after(elapsed, self.due(step));
        let missed = late >= 0.0 && step > self.first;
        self.pacing.overruns += u64::from(missed);
        let skipped = match self.overrun {
            Overrun::Skip if missed => self.missed_periods(late),
            Overrun::Abort if missed && late >= self.period => return Err(TooLate { late, period: self.period }),
            _ => 0,
        };
        self.shifted += skipped;
        let left = self.due(step).saturating_sub(elapsed);
        if left.is_zero() || stop.sleep(left) {
            let late = seconds_after(self.origin.elapsed(), self.due(step)).max(0.0) + skipped as f64 * self.period;
            self.note(late);
            self.pacing.beyond += u64::from(missed && late > self.period);
            self.pacing.skipped += skipped;
            self.last = Start { late, missed, skipped };
        }
        Ok(())
    }

    /// The time of a step, from the origin on.
    fn due(&self, step: u64) -> Duration {
        let periods = (step - self.first).saturating_add(self.shifted);
        lockstep::duration(periods as f64 * self.period)
    }

    /// How many periods have passed without a step that is `late` by so many seconds: it is to start with the next one.
    fn missed_periods(&self, late: f64) -> u64 {
        let periods = late / self.period;
        if periods > SLACK { periods.ceil() as u64 } else { 0 }
    }

    fn note(&mut self, late: f64) {
        self.pacing.steps += 1;
        self.pacing.worst = self.pacing.worst.max(late);
        self.classes[class(late)] += 1;
    }

    /// How the newest step was started.
    pub(crate) fn last(&self) -> Start {
        self.last
    }

    /// How well it went.
    pub(crate) fn finish(self) -> Pacing {
        Pacing { quantiles: Pacing::SHARES.map(|share| self.quantile(share)), ..self.pacing }
    }

    /// The delay that this share of the starts, per thousand, kept, s.
    fn quantile(&self, share: u64) -> f64 {
        let beyond = self.pacing.steps * (1000 - share) / 1000;
        let mut seen = 0;
        for (class, &count) in self.classes.iter().enumerate().rev() {
            seen += u64::from(count);
            if seen > beyond {
                let most = (((class + 1) as f64 / CLASSES).exp2() - 1.0) * 1e-6;
                return most.min(self.pacing.worst);
            }
        }
        self.pacing.worst
    }
}

/// How long after `due` it is, s; negative before.
fn seconds_after(elapsed: Duration, due: Duration) -> f64 {
    match elapsed.checked_sub(due) {
        Some(late) => late.as_secs_f64(),
        None => -(due - elapsed).as_secs_f64(),
    }
}

fn class(late: f64) -> usize {
    ((CLASSES * (1.0 + late * 1e6).log2()) as usize).min(COUNT - 1)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn delays_are_summed_up() {
        let mut pace = Pace::new(0.01, 1.0, Overrun::CatchUp);
        (0..9_989).for_each(|_| pace.note(50e-6));
        (0..10).for_each(|_| pace.note(1e-3));
        pace.note(0.5);
        let pacing = pace.finish();
        assert_eq!(pacing.worst, 0.5);
        // Ten of ten thousand may be beyond.
        assert!((pacing.quantiles[3] / 1e-3 - 1.0).abs() < 0.05, "{pacing:?}");
        assert!(pacing.quantiles[..3].iter().all(|delay| (delay / 50e-6 - 1.0).abs() < 0.05), "{pacing:?}");
    }

    #[test]
    fn a_step_that_takes_too_long_makes_the_next_one_late() {
        let (mut pace, stop) = (Pace::new(1e-3, 1.0, Overrun::CatchUp), RunControl::new());
        pace.wait(0, &stop).unwrap();
        assert!(!pace.last().missed);
        std::thread::sleep(Duration::from_millis(5));
        pace.wait(1, &stop).unwrap();
        assert!(pace.last().missed && pace.last().late > 4e-3 - 1e-6, "{:?}", pace.last());
        let pacing = pace.finish();
        assert_eq!((pacing.overruns, pacing.beyond), (1, 1));
    }

    /// A run that has been going on for so many seconds.
    fn begun(overrun: Overrun, since: f64) -> (Pace, RunControl) {
        let mut pace = Pace::new(0.1, 1.0, overrun);
        pace.origin = Instant::now() - Duration::from_secs_f64(since);
        (pace, RunControl::new())
    }

    #[test]
    fn missed_periods_are_skipped_and_the_steps_after_them_are_a_period_apart() {
        // Step 1 was due 0.4 s ago.
        let (mut pace, stop) = begun(Overrun::Skip, 0.5);
        pace.wait(1, &stop).unwrap();
        let first = Instant::now();
        assert!(pace.last().missed && pace.last().skipped >= 4 && pace.last().late >= 0.4, "{:?}", pace.last());
        pace.wait(2, &stop).unwrap();
        assert!(first.elapsed() > Duration::from_millis(75), "{:?}", first.elapsed());
        let pacing = pace.finish();
        assert!(pacing.skipped >= 4 && pacing.worst >= 0.4, "{pacing:?}");
    }

    #[test]
    fn a_delay_below_a_quarter_of_a_period_skips_nothing() {
        let pace = Pace::new(0.1, 1.0, Overrun::Skip);
        let skipped = [0.0, 0.024, 0.026, 0.1, 0.11, 1.5].map(|late| pace.missed_periods(late));
        assert_eq!(skipped, [0, 0, 1, 1, 2, 15]);
    }

    #[test]
    fn a_run_that_catches_up_starts_late_steps_at_once_and_one_that_aborts_does_not_start_them() {
        let (mut pace, stop) = begun(Overrun::CatchUp, 100.0);
        (1..=50).for_each(|step| pace.wait(step, &stop).unwrap());
        assert!(pace.last().missed && pace.finish().skipped == 0);
        let (mut pace, stop) = begun(Overrun::Abort, 0.5);
        let too_late = pace.wait(1, &stop).unwrap_err();
        assert!(too_late.late >= 0.4 && too_late.period == 0.1, "{too_late:?}");
    }

    #[test]
    fn a_factor_beyond_all_clocks_is_no_panic() {
        let mut pace = Pace::new(1.0, 1e-300, Overrun::Skip);
        let stop = RunControl::new();
        stop.request();
        assert_eq!(pace.wait(1, &stop), Ok(()));
    }

    #[test]
    fn times_do_not_drift() {
        let (mut pace, stop) = (Pace::new(1e-3, 1.0, Overrun::CatchUp), RunControl::new());
        pace.restart(5);
        let start = Instant::now();
        for step in 5..=25 {
            pace.wait(step, &stop).unwrap();
            // Late, but less than a step.
            std::thread::sleep(Duration::from_micros(300));
        }
        assert!(start.elapsed() >= Duration::from_millis(20), "{:?}", start.elapsed());
    }
}
