//! Steps at given times: simulated time that keeps pace with the clock on the wall.

use std::time::Instant;

use super::Stop;

/// Classes of lateness per doubling.
const CLASSES: f64 = 16.0;
/// Number of classes: up to 2^40 us.
const COUNT: usize = 640;

/// How well a run kept its times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pacing {
    /// Steps that were paced.
    pub steps: u64,
    /// Steps that could not start in time, because the step before was not done.
    pub overruns: u64,
    /// Those of them that started more than a period too late.
    pub beyond: u64,
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
    /// How late, s.
    pub(crate) late: f64,
    /// Whether the step before was not done in time.
    pub(crate) missed: bool,
}

/// Paces a run.
pub(crate) struct Pace {
    /// Wall-clock seconds per step.
    period: f64,
    /// The step that started at the origin.
    first: u64,
    origin: Instant,
    pacing: Pacing,
    classes: Box<[u32; COUNT]>,
    /// How the newest step was started.
    last: Start,
}

impl Pace {
    /// Steps of `dt` simulated seconds, `factor` times as fast as the clock.
    pub(crate) fn new(dt: f64, factor: f64) -> Self {
        let (pacing, last) = (Pacing::default(), Start::default());
        let classes = Box::new([0; COUNT]);
        Self { period: dt / factor, first: 0, origin: Instant::now(), pacing, classes, last }
    }

    /// Counts the times from `step` and from now.
    pub(crate) fn restart(&mut self, step: u64) {
        (self.first, self.origin) = (step, Instant::now());
    }

    /// Waits for the time of `step`. Every time is counted from the origin, so that delays do not add up.
    pub(crate) fn wait(&mut self, step: u64, stop: &Stop) {
        let due = lockstep::duration((step - self.first) as f64 * self.period);
        let left = due.saturating_sub(self.origin.elapsed());
        let missed = left.is_zero() && step > self.first;
        self.pacing.overruns += u64::from(missed);
        if left.is_zero() || stop.sleep(left) {
            let late = self.origin.elapsed().saturating_sub(due).as_secs_f64();
            self.note(late);
            self.pacing.beyond += u64::from(missed && late > self.period);
            self.last = Start { late, missed };
        }
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

fn class(late: f64) -> usize {
    ((CLASSES * (1.0 + late * 1e6).log2()) as usize).min(COUNT - 1)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn delays_are_summed_up() {
        let mut pace = Pace::new(0.01, 1.0);
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
        let (mut pace, stop) = (Pace::new(1e-3, 1.0), Stop::new());
        pace.wait(0, &stop);
        assert!(!pace.last().missed);
        std::thread::sleep(Duration::from_millis(5));
        pace.wait(1, &stop);
        assert!(pace.last().missed && pace.last().late > 4e-3 - 1e-6, "{:?}", pace.last());
        let pacing = pace.finish();
        assert_eq!((pacing.overruns, pacing.beyond), (1, 1));
    }

    #[test]
    fn times_do_not_drift() {
        let (mut pace, stop) = (Pace::new(1e-3, 1.0), Stop::new());
        pace.restart(5);
        let start = Instant::now();
        for step in 5..=25 {
            pace.wait(step, &stop);
            // Late, but less than a step.
            std::thread::sleep(Duration::from_micros(300));
        }
        assert!(start.elapsed() >= Duration::from_millis(20), "{:?}", start.elapsed());
    }
}
