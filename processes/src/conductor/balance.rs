//! On how many cores the processes of a run are: as many as make its steps shortest, tried while the run goes on.
//!
//! A second core halves what the processes compute, and the memory that they bring back into each core's caches in every step;
//! but phases then end on two cores, and somebody has to watch on each of them (see `page::side`). Which weighs more depends on
//! the number of processes, on what they compute, on the machine, and on what else runs there. So it is measured: steps on
//! the cores of now, then steps on twice as many, and the better arrangement is kept. If steps get much longer later, since
//! somebody else has come to one of the cores, the run goes back to its own core. Whatever failed is tried again, ever more
//! rarely.

/// Steps before the first trial.
const FIRST: u64 = 200;
/// Steps that are timed at once.
const WINDOW: u64 = 32;
/// Windows that an arrangement is timed for. The least time counts: strangers make times longer, never shorter.
const TRIAL: u32 = 4;
/// Steps after a move that are not timed: sides and the manner of waiting settle.
const SETTLING: u64 = 192;
/// More cores must make steps shorter by this factor to be kept.
const MARGIN: f64 = 1.1;
/// So many windows in a row ...
const BAD: u32 = 8;
/// ... that take so many times as long end the use of several cores.
const SLOWER: u64 = 2;
/// Steps until the next trial: so many at first, four times as many after every trial that failed, up to a limit.
const PATIENCE: [u64; 2] = [8192, 1 << 20];

/// Times windows of steps and decides.
#[derive(Debug)]
pub(super) struct Balance {
    /// Cores that may be used.
    most: usize,
    /// Cores of the arrangement that is kept, and the least time of a window in it.
    kept: usize,
    least: u64,
    /// The same of what was tried last.
    tried: Option<(usize, u64)>,
    /// The least time of a window on one core.
    alone: u64,
    stage: Stage,
    patience: u64,
    /// Step and time of the start of the window; `None`: the next step starts one.
    start: Option<(u64, u64)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Nothing happens before this step.
    Rest(u64),
    /// The arrangement of now is timed, so many more windows.
    Time(u32),
    /// Another arrangement settles until this step.
    Settle(u64),
    /// It is timed, so many more windows; least so far.
    Try(u32, u64),
    /// Several cores are used; so many windows in a row were bad.
    Guard(u32),
}

impl Balance {
    /// Of a run on the first of `most` cores.
    pub(super) fn new(most: usize) -> Self {
        Self {
            most,
            kept: 1,
            least: u64::MAX,
            tried: None,
            alone: u64::MAX,
            stage: Stage::Rest(FIRST),
            patience: PATIENCE[0],
            start: None,
        }
    }

    /// Ticks per step on one core and in the arrangement that was tried last, with its number of cores, as far as known.
    pub(super) fn findings(&self) -> (Option<f64>, Option<(usize, f64)>) {
        let per_step = |window: u64| (window < u64::MAX).then_some(window as f64 / WINDOW as f64);
        (per_step(self.alone), self.tried.and_then(|(cores, window)| Some((cores, per_step(window)?))))
    }

    /// Takes the time in. Returns a number of cores if the processes are to move to so many.
    pub(super) fn observe(&mut self, steps: u64, now: u64) -> Option<usize> {
        match self.stage {
            Stage::Rest(until) => {
                if self.most > self.kept && steps >= until {
                    (self.stage, self.least) = (Stage::Time(TRIAL), u64::MAX);
                }
                None
            }
            Stage::Settle(until) => {
                if steps >= until {
                    (self.stage, self.start) = (Stage::Try(TRIAL, u64::MAX), None);
                }
                None
            }
            Stage::Time(_) | Stage::Try(..) | Stage::Guard(_) => {
                let took = self.window(steps, now)?;
                self.judge(steps, took)
            }
        }
    }

    /// The duration of a window that is complete.
    fn window(&mut self, steps: u64, now: u64) -> Option<u64> {
        let Some((first, since)) = self.start else {
            self.start = Some((steps, now));
            return None;
        };
        (steps - first >= WINDOW).then(|| {
            self.start = Some((steps, now));
            now.saturating_sub(since)
        })
    }

    fn judge(&mut self, steps: u64, took: u64) -> Option<usize> {
        match self.stage {
            Stage::Time(left) => {
                self.least = self.least.min(took);
                self.stage = Stage::Time(left - 1);
                if left > 1 {
                    return None;
                }
                if self.kept == 1 {
                    self.alone = self.least;
                }
                Some(self.go_on(steps))
            }
            Stage::Try(left, least) => {
                let least = least.min(took);
                self.stage = Stage::Try(left - 1, least);
                if left > 1 {
                    return None;
                }
                let cores = self.next();
                self.tried = Some((cores, least));
                if least as f64 * MARGIN > self.least as f64 {
                    return Some(self.give_up(steps, self.kept));
                }
                (self.kept, self.least) = (cores, least);
                if cores < self.most {
                    return Some(self.go_on(steps));
                }
                self.stage = Stage::Guard(0);
                None
            }
            Stage::Guard(bad) => {
                let bad = if took / SLOWER > self.least { bad + 1 } else { 0 };
                self.stage = Stage::Guard(bad);
                (bad == BAD).then(|| self.give_up(steps, 1))
            }
            Stage::Rest(_) | Stage::Settle(_) => None,
        }
    }

    /// The arrangement after this one.
    fn next(&self) -> usize {
        (2 * self.kept).min(self.most)
    }

    fn go_on(&mut self, steps: u64) -> usize {
        self.stage = Stage::Settle(steps + SETTLING);
        self.next()
    }

    /// Goes back to an arrangement.
    fn give_up(&mut self, steps: u64, cores: usize) -> usize {
        self.kept = cores;
        self.stage = if cores > 1 { Stage::Guard(0) } else { Stage::Rest(steps + self.patience) };
        self.patience = (4 * self.patience).min(PATIENCE[1]);
        self.start = None;
        cores
    }

    /// The cores that were wanted are not to be had. Returns how many are kept.
    pub(super) fn refuse(&mut self, steps: u64) -> usize {
        self.give_up(steps, self.kept)
    }
}

/// Spreads workers over so many cores: by worker, the number of its core. `members` are the workers of every phase, `load` is
/// what a worker takes per step, in any unit.
pub(super) fn spread(members: &[Vec<usize>], load: &[f64], cores: usize) -> Vec<usize> {
    let mut chosen = vec![0; load.len()];
    for workers in members {
        // The longest first, each to the core that has least to do.
        let mut order = workers.clone();
        order.sort_by(|&a, &b| load[b].total_cmp(&load[a]));
        let mut loads = vec![0.0; cores];
        for worker in order {
            let least = (0..cores).min_by(|&a, &b| f64::total_cmp(&loads[a], &loads[b])).unwrap_or(0);
            loads[least] += load[worker];
            chosen[worker] = least;
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run whose steps take so long on 1, 2 and 4 cores.
    struct Run {
        balance: Balance,
        cores: usize,
        now: u64,
        step: u64,
    }

    impl Run {
        fn new() -> Self {
            Self { balance: Balance::new(4), cores: 1, now: 0, step: 0 }
        }

        /// For how many of so many steps each number of cores was used.
        fn steps(&mut self, count: u64, time: [u64; 3]) -> [u64; 3] {
            let mut used = [0; 3];
            for _ in 0..count {
                let at = self.cores.ilog2() as usize;
                used[at] += 1;
                self.now += time[at];
                self.step += 1;
                self.cores = self.balance.observe(self.step, self.now).unwrap_or(self.cores);
            }
            used
        }
    }

    #[test]
    fn the_best_number_of_cores_is_found_and_kept() {
        assert!(Run::new().steps(100_000, [900, 500, 300])[2] > 98_000);
        assert!(Run::new().steps(100_000, [900, 500, 600])[1] > 98_000);
        assert!(Run::new().steps(100_000, [30, 29, 29])[0] > 98_000);
        assert!(Run::new().steps(1_000_000, [30, 300, 300])[0] > 995_000);
    }

    #[test]
    fn a_stranger_on_another_core_drives_the_run_home_until_it_is_gone() {
        let mut run = Run::new();
        run.steps(10_000, [900, 500, 600]);
        assert_eq!(run.cores, 2);
        let used = run.steps(5_000, [900, 5000, 9000]);
        assert!(used[0] > 4_600, "{used:?}");
        run.steps(300_000, [900, 500, 600]);
        assert_eq!(run.cores, 2);
    }

    #[test]
    fn what_was_found_is_kept_when_more_cores_are_not_to_be_had() {
        let mut run = Run::new();
        while run.cores < 4 {
            run.steps(1, [900, 500, 300]);
        }
        run.cores = run.balance.refuse(run.step);
        assert_eq!(run.cores, 2);
        assert_eq!(run.steps(50_000, [900, 500, 300])[1], 50_000);
    }

    #[test]
    fn one_core_is_left_alone() {
        let mut balance = Balance::new(1);
        assert!((0..10_000).all(|step| balance.observe(step, 100 * step).is_none()));
    }

    #[test]
    fn every_phase_is_divided() {
        // One worker that six others wait for.
        let members = vec![vec![0], (1..7).collect()];
        let cores = spread(&members, &[5.0, 3.0, 1.0, 1.0, 1.0, 1.0, 1.0], 2);
        assert_eq!(cores[0], 0);
        assert_eq!(cores[1..].iter().filter(|core| **core == cores[1]).count(), 2, "{cores:?}");
        assert_eq!(spread(&members, &[1.0; 7], 1), [0; 7]);
    }
}
