//! Whether workers that wait hand their core on before they sleep: whichever is faster, measured while the run goes on.
//!
//! Processes of one core that take turns need not sleep: each that has arrived lets the others run once (`sched_yield`), and
//! if they stand in the right order its gate is open when its turn comes again. That saves a sleep and a wake-up per worker
//! and step, half of a step's time. But where a stranger competes for the core, who hands it on gives away a whole time slice,
//! and a step takes many times as long. So both are tried now and then, and the better one is kept.

use crate::page::Page;
use crate::ticks;

/// Steps that are timed at once.
const WINDOW: u64 = 16;
/// Windows of a trial. Their least time counts, since others that run now and then make times longer, never shorter.
const TRIAL: u32 = 3;
/// Windows between two trials: so many after a change, and twice as many after every trial that changed nothing, up to a limit.
const PATIENCE: [u32; 2] = [16, 4096];
/// A trial is given up if a window takes so many times as long as before ...
const HOPELESS: u64 = 8;
/// ... and the other manner is tried at once if the present one has become so much slower.
const SLOWER: u64 = 2;

/// Times windows of steps and decides.
#[derive(Debug)]
pub(super) struct Tempo {
    /// Whether who waits hands its core on.
    passing: bool,
    /// Least time of a window since the last decision, for the present manner; `u64::MAX` if there is none yet.
    least: u64,
    /// Least time of a window of the other manner, when a trial of this one is on.
    other: Option<u64>,
    /// Windows until the trial ends, or until the next one.
    left: u32,
    patience: u32,
    /// Step and time of the start of the window; `None`: the next step starts one.
    start: Option<(u64, u64)>,
}

impl Tempo {
    pub(super) fn new() -> Self {
        Self { passing: false, least: u64::MAX, other: None, left: TRIAL, patience: PATIENCE[0], start: None }
    }

    /// A number of steps is complete.
    pub(super) fn at(&mut self, steps: u64, page: &Page) {
        if self.observe(steps, ticks::now()) {
            page.pass_cores_on(self.passing);
        }
    }

    /// Takes the time in; true if the manner changes.
    fn observe(&mut self, steps: u64, now: u64) -> bool {
        let Some((first, since)) = self.start else {
            self.start = Some((steps, now));
            return false;
        };
        let took = now.saturating_sub(since);
        let hopeless = self.other.is_some_and(|other| took / HOPELESS > other);
        if steps - first < WINDOW && !hopeless {
            return false;
        }
        self.start = Some((steps, now));
        let slower = self.other.is_none() && self.least != u64::MAX && took / SLOWER > self.least;
        self.least = self.least.min(took);
        self.left -= 1;
        if self.left > 0 && !slower && !hopeless {
            return false;
        }
        match self.other {
            Some(other) if hopeless || self.least > other => {
                // The trial failed: back.
                self.patience = (2 * self.patience).min(PATIENCE[1]);
                self.change(other, None, self.patience)
            }
            Some(_) => {
                self.patience = PATIENCE[0];
                (self.other, self.left) = (None, self.patience);
                false
            }
            None => self.change(u64::MAX, Some(if slower { took } else { self.least }), TRIAL),
        }
    }

    fn change(&mut self, least: u64, other: Option<u64>, left: u32) -> bool {
        self.passing = !self.passing;
        // Those who wait now still wait in the old manner: the next step is not timed.
        self.start = None;
        (self.least, self.other, self.left) = (least, other, left);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs steps that take so long in either manner; returns for how many of them cores were passed on.
    fn run(tempo: &mut Tempo, steps: std::ops::Range<u64>, now: &mut u64, [asleep, passing]: [u64; 2]) -> u64 {
        let mut count = 0;
        for step in steps {
            *now += if tempo.passing { passing } else { asleep };
            count += u64::from(tempo.passing);
            tempo.observe(step, *now);
        }
        count
    }

    #[test]
    fn the_faster_manner_is_found_and_kept() {
        let (mut tempo, mut now) = (Tempo::new(), 0);
        assert!(run(&mut tempo, 0..100_000, &mut now, [50, 28]) > 98_000);
        let (mut tempo, mut now) = (Tempo::new(), 0);
        assert!(run(&mut tempo, 0..100_000, &mut now, [50, 55]) < 2_000);
    }

    #[test]
    fn strangers_on_the_core_are_noticed_at_once_and_their_end_soon() {
        let (mut tempo, mut now) = (Tempo::new(), 0);
        run(&mut tempo, 0..10_000, &mut now, [50, 28]);
        assert!(tempo.passing);
        // From now on a stranger takes what is passed on.
        assert!(run(&mut tempo, 10_000..110_000, &mut now, [60, 1500]) < 300);
        assert!(!tempo.passing);
        run(&mut tempo, 110_000..210_000, &mut now, [50, 28]);
        assert!(tempo.passing);
    }

    #[test]
    fn a_pause_changes_nothing_for_long() {
        let (mut tempo, mut now) = (Tempo::new(), 0);
        run(&mut tempo, 0..10_000, &mut now, [50, 28]);
        now += 1_000_000_000;
        let passed = run(&mut tempo, 10_000..20_000, &mut now, [50, 28]);
        assert!(passed > 9_300, "{passed}");
    }
}
