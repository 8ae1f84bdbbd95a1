//! On how many cores the processes of a run are: as many as make its steps shortest, tried while the run goes on.
//!
//! A second core halves what the processes compute, and the memory that they bring back into each core's caches in every step;
//! but phases then end on two cores, and a worker has to poll on each of them (see `page::protocol`). Which weighs more depends on
//! the number of processes, on what they compute, on the machine, and on what else runs there. So it is measured: steps on
//! the cores of now, then steps on twice as many, and the better number of cores is kept. If steps get much longer later, since
//! another program uses one of the cores, the run goes back to its own core. Whatever failed is tried again, ever more
//! rarely.
//!
//! Where others compete for the cores, a step that depends on two of them can take a hundred times as long. So every trial has
//! a budget: it ends as soon as its steps have taken so much longer than before, and none begins before those that were made
//! have cost less than a small part of the run.

/// Steps before the first trial.
const FIRST: u64 = 200;
/// Steps that are timed at once.
const WINDOW: u64 = 32;
/// Windows that a number of cores is timed for. The least time counts: other programs make times longer, never shorter.
const TRIAL: u32 = 4;
/// Steps after a move that are not timed: core groups and the way of waiting settle.
const SETTLING: u64 = 192;
/// More cores must make steps shorter by this factor to be kept.
const MARGIN: f64 = 1.1;
/// So many windows in a row ...
const BAD: u32 = 8;
/// ... that take so many times as long end the use of several cores.
const SLOWER: u64 = 2;
/// Steps until the next trial: so many at first, four times as many after every trial that failed, up to a limit.
const PATIENCE: [u64; 2] = [8192, 1 << 20];
/// All trials together may cost this part of the time of the run ...
const SHARE: f64 = 1.0 / 25.0;
/// ... and each one so many steps more, in which the processes find their way ...
const GRACE: f64 = 50.0;
/// ... and this part of the most that a trial may cost.
const SPARE: f64 = 1.0 / 20.0;
/// A trial whose steps take so many times as long as before, on average, has failed, however short the shortest are.
const ERRATIC: f64 = 2.0;

/// Times windows of steps and decides.
#[derive(Debug)]
pub(super) struct CoreTuning {
    /// Cores that may be used.
    most: usize,
    /// The number of cores that is kept, and the least time of a window in it.
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
    /// Most that a trial may cost.
    dearest: f64,
    /// What the trials have cost so far.
    spent: f64,
    /// What the present trial, or bad windows in a row, have cost so far.
    cost: f64,
    /// The budget of the present trial.
    budget: f64,
    /// A step on the cores that are kept, on average.
    usual: f64,
    /// Sum of the windows that are timed at present.
    sum: u64,
    /// Time of the first step that was seen, and of the last one with its number.
    origin: Option<u64>,
    last: (u64, u64),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Nothing happens before this step.
    Rest(u64),
    /// The present cores are timed, so many more windows.
    Time(u32),
    /// Another number of cores settles until this step.
    Settle(u64),
    /// It is timed, so many more windows; least so far.
    Try(u32, u64),
    /// Several cores are used; so many windows in a row were bad.
    Guard(u32),
}

impl CoreTuning {
    /// Of a run on the first of `most` cores, in which a trial may take up to `dearest` longer than its steps would take without.
    pub(super) fn new(most: usize, dearest: u64) -> Self {
        Self {
            most,
            kept: 1,
            least: u64::MAX,
            tried: None,
            alone: u64::MAX,
            stage: Stage::Rest(FIRST),
            patience: PATIENCE[0],
            start: None,
            dearest: dearest as f64,
            spent: 0.0,
            cost: 0.0,
            budget: 0.0,
            usual: 0.0,
            sum: 0,
            origin: None,
            last: (0, 0),
        }
    }

    /// Ticks per step on one core and on the cores that were tried last, with their number, as far as known.
    pub(super) fn findings(&self) -> (Option<f64>, Option<(usize, f64)>) {
        let per_step = |window: u64| (window < u64::MAX).then_some(window as f64 / WINDOW as f64);
        (per_step(self.alone), self.tried.and_then(|(cores, window)| Some((cores, per_step(window)?))))
    }

    /// Takes the time in. Returns a number of cores if the processes are to move to so many.
    pub(super) fn observe(&mut self, steps: u64, now: u64) -> Option<usize> {
        let elapsed = now.saturating_sub(*self.origin.get_or_insert(now)) as f64;
        if let Some(cores) = self.account(steps, now) {
            return Some(cores);
        }
        match self.stage {
            Stage::Rest(until) => {
                if self.most > self.kept && steps >= until && self.spent <= SHARE * elapsed {
                    (self.stage, self.least, self.sum, self.start) = (Stage::Time(TRIAL), u64::MAX, 0, None);
                }
                None
            }
            Stage::Settle(until) => {
                if steps >= until {
                    (self.stage, self.sum, self.start) = (Stage::Try(TRIAL, u64::MAX), 0, None);
                }
                None
            }
            Stage::Time(_) | Stage::Try(..) | Stage::Guard(_) => {
                let took = self.window(steps, now)?;
                self.sum += took;
                self.judge(steps, took, elapsed)
            }
        }
    }

    /// Adds up what the steps have taken too long. Returns the cores to go back to if that is too much.
    fn account(&mut self, steps: u64, now: u64) -> Option<usize> {
        let (last, since) = std::mem::replace(&mut self.last, (steps, now));
        // No single step counts for more than a part: the run may have been paused.
        let (expected, most, limit) = match self.stage {
            Stage::Rest(_) | Stage::Time(_) => return None,
            Stage::Settle(_) | Stage::Try(..) => (self.usual, self.dearest, self.budget),
            Stage::Guard(_) => (SLOWER as f64 * self.least as f64 / WINDOW as f64, self.dearest / 2.0, self.dearest),
        };
        let step = (now.saturating_sub(since) as f64).min(most);
        self.cost += step - expected * steps.saturating_sub(last) as f64;
        match self.stage {
            _ if self.cost <= limit => None,
            Stage::Guard(_) => Some(self.give_up(steps, 1)),
            _ => {
                // As long as its last step, at least.
                self.tried = Some((self.next(), (WINDOW as f64 * step) as u64));
                Some(self.give_up(steps, self.kept))
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

    fn judge(&mut self, steps: u64, took: u64, elapsed: f64) -> Option<usize> {
        let average = self.sum as f64 / f64::from(TRIAL) / WINDOW as f64;
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
                self.usual = average;
                Some(self.go_on(steps, elapsed))
            }
            Stage::Try(left, least) => {
                let least = least.min(took);
                self.stage = Stage::Try(left - 1, least);
                if left > 1 {
                    return None;
                }
                let cores = self.next();
                self.tried = Some((cores, least));
                if least as f64 * MARGIN > self.least as f64 || average > ERRATIC * self.usual {
                    return Some(self.give_up(steps, self.kept));
                }
                self.settle_up();
                (self.kept, self.least, self.usual) = (cores, least, average);
                if cores < self.most {
                    return Some(self.go_on(steps, elapsed));
                }
                self.stage = Stage::Guard(0);
                None
            }
            Stage::Guard(bad) => {
                let bad = if took / SLOWER > self.least { bad + 1 } else { 0 };
                self.stage = Stage::Guard(bad);
                if bad == 0 {
                    self.cost = 0.0;
                }
                (bad == BAD).then(|| self.give_up(steps, 1))
            }
            Stage::Rest(_) | Stage::Settle(_) => None,
        }
    }

    /// The number of cores to try after this one.
    fn next(&self) -> usize {
        (2 * self.kept).min(self.most)
    }

    fn go_on(&mut self, steps: u64, elapsed: f64) -> usize {
        self.stage = Stage::Settle(steps + SETTLING);
        let free = (SHARE * elapsed - self.spent).max(0.0);
        self.budget = (free + GRACE * self.usual + SPARE * self.dearest).min(self.dearest);
        self.next()
    }

    /// A trial, or a time on several cores, has come to its end.
    fn settle_up(&mut self) {
        self.spent += self.cost.max(0.0);
        self.cost = 0.0;
    }

    /// Goes back to a number of cores.
    fn give_up(&mut self, steps: u64, cores: usize) -> usize {
        self.settle_up();
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

    /// 100 ms, if times are in µs.
    const DEAREST: u64 = 100_000;

    /// A run whose steps take so long on 1, 2 and 4 cores.
    struct Run {
        tuning: CoreTuning,
        cores: usize,
        now: u64,
        step: u64,
    }

    impl Run {
        fn new() -> Self {
            Self { tuning: CoreTuning::new(4, DEAREST), cores: 1, now: 0, step: 0 }
        }

        /// For how many of so many steps each number of cores was used.
        fn steps(&mut self, count: u64, time: [u64; 3]) -> [u64; 3] {
            let mut used = [0; 3];
            for _ in 0..count {
                let at = self.cores.ilog2() as usize;
                used[at] += 1;
                self.now += time[at];
                self.step += 1;
                self.cores = self.tuning.observe(self.step, self.now).unwrap_or(self.cores);
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
        run.cores = run.tuning.refuse(run.step);
        assert_eq!(run.cores, 2);
        assert_eq!(run.steps(50_000, [900, 500, 300])[1], 50_000);
    }

    #[test]
    fn a_trial_among_strangers_ends_before_it_is_dear() {
        // On the other core, every step waits for a time slice of another program.
        for slow in [500, 5_000, 20_000, 60_000] {
            let mut run = Run::new();
            let mut tried = 0;
            while run.cores == 1 {
                run.steps(1, [40, slow, slow]);
            }
            let start = run.now;
            while run.cores > 1 {
                tried += run.steps(1, [40, slow, slow])[1];
            }
            assert!(run.now - start <= DEAREST + slow + 40 * tried, "{slow}: {} µs", run.now - start);
            // It is over as soon as it has cost what steps of 40 µs may.
            assert!(tried <= 1 + 8_000 / (slow - 40), "{slow}: {tried} steps");
        }
    }

    #[test]
    fn all_trials_together_cost_a_small_part_of_the_run() {
        for slow in [60, 300, 5_000, 60_000] {
            for steps in [2_000, 20_000, 200_000, 2_000_000] {
                let mut run = Run::new();
                run.steps(steps, [40, slow, slow]);
                let cost = run.now as f64 - 40.0 * steps as f64;
                // The part that trials may take, one that is under way, and the step in which it is ended.
                let most = 0.04 * run.now as f64 + (5_000 + 50 * 40 + slow) as f64;
                assert!(cost <= most, "{slow} in {steps} steps: {cost} of {most} µs");
            }
        }
    }

    #[test]
    fn lucky_windows_do_not_make_up_for_slow_ones() {
        let mut run = Run::new();
        let mut cost = 0;
        for index in 0..20_000 {
            // On two cores, a time slice is missing in every fortieth step, so that a few windows look good. That makes two trials.
            let two = if index % 40 == 0 { 4_000 } else { 20 };
            let before = run.now;
            let used = run.steps(1, [40, two, two]);
            cost += used[1] as i64 * ((run.now - before) as i64 - 40);
        }
        assert!(run.cores == 1 && cost < 24_000, "{cost} µs");
    }

    #[test]
    fn strangers_that_come_later_cost_no_more_than_a_trial() {
        let mut run = Run::new();
        run.steps(10_000, [900, 500, 600]);
        assert_eq!(run.cores, 2);
        let start = run.now;
        while run.cores > 1 {
            run.steps(1, [900, 20_000, 20_000]);
        }
        assert!(run.now - start <= DEAREST + 2 * 20_000, "{} µs", run.now - start);
    }

    #[test]
    fn a_pause_moves_nothing() {
        let mut run = Run::new();
        run.steps(10_000, [900, 500, 600]);
        for _ in 0..10 {
            run.now += 10_000_000;
            assert_eq!(run.steps(1_000, [900, 500, 600])[1], 1_000);
        }
    }

    #[test]
    fn one_core_is_left_alone() {
        let mut tuning = CoreTuning::new(1, DEAREST);
        assert!((0..10_000).all(|step| tuning.observe(step, 100 * step).is_none()));
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
