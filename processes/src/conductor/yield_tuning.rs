//! Whether workers that wait yield their core before they sleep: whichever is faster, measured while the run goes on.
//!
//! Processes of one core that take turns need not sleep: each that has arrived lets the others run once (`sched_yield`), and
//! if they stand in the right order its gate is open when its turn comes again. That saves a sleep and a wake-up per worker
//! and step, half of a step's time. But if another program uses the core, a worker that yields gives away a whole time slice, and
//! a step takes many times as long. So both are tried now and then, and the better one is kept.

use crate::page::Page;
use crate::ticks;

/// Steps that are timed at once.
const WINDOW: u64 = 16;
/// Windows that either way is tried for. The least time counts, since others that run now and then make times longer, never
/// shorter.
const TRIAL: u32 = 3;
/// Windows with yielding before steps without it are timed again.
const TERM: u32 = 512;
/// Windows until the next trial: so many at first, and twice as many after every trial that failed, up to a limit.
const PATIENCE: [u32; 2] = [16, 4096];
/// A worker that gets its core back only after so many times the duration of a step ends the yielding at once.
const LATE: u64 = 4;
/// Yielding ends if a window takes so many times as long as without.
const SLOWER: u64 = 2;

/// Times windows of steps and decides.
#[derive(Debug)]
pub(super) struct YieldTuning {
    /// Windows with yielding so far; `None`: workers sleep without it.
    yielding: Option<u32>,
    /// Least time of a window without yielding.
    without: u64,
    /// Least time of a window of the present kind.
    least: u64,
    /// Windows until the next trial.
    left: u32,
    patience: u32,
    /// Step and time of the start of the window; `None`: the next step starts one.
    start: Option<(u64, u64)>,
}

impl YieldTuning {
    pub(super) fn new() -> Self {
        let patience = PATIENCE[0];
        Self { yielding: None, without: u64::MAX, least: u64::MAX, left: TRIAL, patience, start: None }
    }

    /// A number of steps is complete.
    pub(super) fn at(&mut self, steps: u64, page: &Page) {
        if let Some(limit) = self.observe(steps, ticks::now(), page.yield_limit()) {
            page.set_yield_limit(limit);
        }
    }

    /// Takes the time in, and the limit that is in force: 0 if no worker yields. Returns a new limit if that changes.
    fn observe(&mut self, steps: u64, now: u64, limit: u64) -> Option<u64> {
        if self.yielding.is_some() && limit == 0 {
            // A worker has ended it.
            return Some(self.stop_yielding(false));
        }
        let Some((first, since)) = self.start else {
            self.start = Some((steps, now));
            return None;
        };
        if steps - first < WINDOW {
            return None;
        }
        let took = now.saturating_sub(since);
        self.start = Some((steps, now));
        self.least = self.least.min(took);
        match &mut self.yielding {
            None => {
                self.left -= 1;
                (self.left == 0).then(|| self.start_yielding())
            }
            Some(windows) => {
                *windows += 1;
                let windows = *windows;
                let failed = windows == TRIAL && self.least > self.without || took / SLOWER > self.without;
                (failed || windows == TERM).then(|| self.stop_yielding(!failed))
            }
        }
    }

    fn start_yielding(&mut self) -> u64 {
        (self.yielding, self.without) = (Some(0), self.least);
        self.begin();
        (LATE * self.without / WINDOW).max(1)
    }

    /// `content`: yielding was good, and only steps without it have to be timed again.
    fn stop_yielding(&mut self, content: bool) -> u64 {
        let lasted = self.yielding.take().is_some_and(|windows| windows > PATIENCE[0]);
        self.patience = if content || lasted { PATIENCE[0] } else { (2 * self.patience).min(PATIENCE[1]) };
        self.left = if content { TRIAL } else { self.patience };
        self.begin();
        0
    }

    fn begin(&mut self) {
        // Workers that wait now still wait as before: the next step is not timed.
        (self.start, self.least) = (None, u64::MAX);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run whose steps take so long in either manner.
    struct Run {
        yield_tuning: YieldTuning,
        now: u64,
        limit: u64,
        step: u64,
    }

    impl Run {
        fn new() -> Self {
            Self { yield_tuning: YieldTuning::new(), now: 0, limit: 0, step: 0 }
        }

        /// For how many of so many steps cores were passed on. Getting a core back takes as long as a step.
        fn steps(&mut self, count: u64, [asleep, passing]: [u64; 2]) -> u64 {
            let mut passed = 0;
            for _ in 0..count {
                self.now += if self.limit > 0 { passing } else { asleep };
                passed += u64::from(self.limit > 0);
                if self.limit > 0 && passing > self.limit {
                    self.limit = 0;
                }
                self.step += 1;
                self.limit = self.yield_tuning.observe(self.step, self.now, self.limit).unwrap_or(self.limit);
            }
            passed
        }
    }

    #[test]
    fn the_faster_manner_is_found_and_kept() {
        assert!(Run::new().steps(100_000, [50, 28]) > 98_000);
        assert!(Run::new().steps(100_000, [50, 55]) < 2_000);
    }

    #[test]
    fn strangers_on_the_core_are_noticed_at_once_and_their_end_soon() {
        let mut run = Run::new();
        run.steps(10_000, [50, 28]);
        assert!(run.limit > 0);
        // From now on another program uses the time that is yielded.
        assert!(run.steps(100_000, [60, 1500]) < 20);
        assert_eq!(run.limit, 0);
        run.steps(100_000, [50, 28]);
        assert!(run.limit > 0);
    }

    #[test]
    fn times_that_vary_while_asleep_start_no_trial() {
        let mut run = Run::new();
        let passed: u64 = (0..10_000).map(|index| run.steps(10, [50 + index % 7 * 200, 5000])).sum();
        assert!(passed < 30, "{passed}");
    }

    #[test]
    fn a_pause_changes_nothing_for_long() {
        let mut run = Run::new();
        run.steps(10_000, [50, 28]);
        run.now += 1_000_000_000;
        let passed = run.steps(10_000, [50, 28]);
        assert!(passed > 9_000, "{passed}");
    }
}
