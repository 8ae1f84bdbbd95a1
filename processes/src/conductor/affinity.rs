//! Moving the processes of a run to other cores while it goes on.

use std::io;
use std::time::Duration;

use super::Conductor;
use super::core_tuning::{CoreTuning, spread};
use super::error::system;
use super::status::RunStatus;
use super::yield_tuning::YieldTuning;
use crate::cores::{CoreSlot, move_to_core};
use crate::{RunError, ticks};

/// How long a worker polls for the others of its core before it sleeps: a little longer than it takes to wake a core.
const POLLING: Duration = Duration::from_micros(30);
/// Most that a trial of other cores may cost: so much longer than without it.
const DEAREST: Duration = Duration::from_millis(100);
/// Steps after which every worker sleeps as one of the core that it was moved to.
const SETTLING: u64 = 2;
/// What a process takes per step besides what it computes: the switch to it, with cold caches.
const SWITCH: Duration = Duration::from_micros(2);

/// Where the processes are.
#[derive(Default)]
pub(super) struct CoreAffinity {
    /// The core of every worker, once they were moved.
    pub(super) cores: Vec<usize>,
    /// Complete steps from which workers poll, once processes were moved.
    poll_from: Option<u64>,
    tuning: Option<CoreSearch>,
}

/// The search for the best number of cores.
struct CoreSearch {
    tuning: CoreTuning,
    /// The first core of the run first.
    cores: Vec<usize>,
    /// Further cores that the run has taken.
    slots: Vec<CoreSlot>,
}

/// What the search for the best number of cores has found.
#[derive(Clone, Debug, PartialEq)]
pub struct CoreFindings {
    /// The cores in use.
    pub cores: Vec<usize>,
    /// Least time of a step on one core, as far as it was measured.
    pub alone: Option<Duration>,
    /// The number of cores that was tried last, and the least time of a step on them.
    pub tried: Option<(usize, Duration)>,
}

impl Conductor {
    /// Moves the process of every worker to a core: `cores[i]` for worker number i, which must be spawned. Changes no result.
    ///
    /// With more than one core, the last process of a core that is done with a phase polls for the others of its core: it
    /// does not sleep at once, but checks for up to 30 µs whether the next phase begins, since waking a core that has gone
    /// to sleep takes about as long. Cores beyond the eighth share one polling process.
    ///
    /// # Errors
    /// [`RunError::System`] if there are not as many cores as workers, or the operating system refuses.
    pub fn spread(&mut self, cores: &[usize]) -> Result<(), RunError> {
        let count = self.plan.workers.len();
        if cores.len() != count {
            return Err(system("spread the processes")(io::Error::from(io::ErrorKind::InvalidInput)));
        }
        let mut distinct: Vec<usize> = Vec::new();
        for (worker, &core) in cores.iter().enumerate() {
            let failed = system(format!("move {} to core {core}", self.plan.workers[worker].name));
            let pid = self.pid(worker).ok_or(io::ErrorKind::NotFound);
            pid.map_err(Into::into).and_then(|pid| move_to_core(pid, core)).map_err(failed)?;
            if !distinct.contains(&core) {
                distinct.push(core);
            }
        }
        let group = |core: &usize| distinct.iter().position(|other| other == core).unwrap_or(0);
        let groups: Vec<usize> = cores.iter().map(group).collect();
        let places: Vec<_> = (0..count).map(|worker| self.plan.places(worker)).collect();
        let page = &self.workers.status.page;
        page.set_groups(&places, &groups);
        self.affinity.cores = cores.to_vec();
        // Whether to yield is found anew.
        page.set_yield_limit(0);
        self.yield_tuning = YieldTuning::new();
        self.affinity.poll_from = (distinct.len() > 1).then(|| page.completed() + SETTLING);
        Ok(())
    }

    /// From now on the conductor tries on how many of these cores steps are shortest, and moves the processes there: on the
    /// first one, where they must be now, or on 2, 4, ... of them. A core that another run has taken is not used.
    ///
    /// To be called once all are spawned. For runs that go as fast as they can: times of paced steps say nothing.
    pub fn tune_cores(&mut self, cores: Vec<usize>) {
        let dearest = self.workers.status.rate.ticks(DEAREST);
        let tuning = CoreTuning::new(cores.len().min(self.plan.workers.len()), dearest);
        self.affinity.tuning = Some(CoreSearch { tuning, cores, slots: Vec::new() });
    }

    /// What [`tune_cores`](Self::tune_cores) has come to; `None` if it was not asked for.
    pub fn core_findings(&self) -> Option<CoreFindings> {
        let CoreSearch { tuning, cores, slots } = self.affinity.tuning.as_ref()?;
        let time = |ticks: f64| self.workers.status.rate.duration(ticks as u64);
        let (alone, tried) = tuning.findings();
        Some(CoreFindings {
            cores: cores.iter().take(1).copied().chain(slots.iter().map(|slot| slot.core)).collect(),
            alone: alone.map(time),
            tried: tried.map(|(cores, ticks)| (cores, time(ticks))),
        })
    }

    /// A step is recorded.
    pub(super) fn adjust_cores(&mut self, step: u64) {
        let RunStatus { page, rate, .. } = &*self.workers.status;
        if self.affinity.poll_from.is_some_and(|from| page.completed() >= from) {
            self.affinity.poll_from = None;
            page.set_polling_limit(rate.ticks(POLLING));
        }
        let Some(CoreSearch { tuning, .. }) = &mut self.affinity.tuning else { return };
        if let Some(count) = tuning.observe(step, ticks::now()) {
            self.change_cores(step, count);
        }
    }

    /// Moves the processes to so many cores, or back to those that are kept if there are not so many.
    #[cold]
    fn change_cores(&mut self, step: u64, count: usize) {
        let RunStatus { page, rate, .. } = &*self.workers.status;
        let Some(CoreSearch { tuning, cores, slots }) = &mut self.affinity.tuning else { return };
        slots.truncate(count - 1);
        for &core in &cores[1..] {
            if slots.len() + 1 < count && slots.iter().all(|slot| slot.core != core) {
                slots.extend(CoreSlot::take_core(core));
            }
        }
        if slots.len() + 1 < count {
            slots.truncate(tuning.refuse(step) - 1);
        }
        let used: Vec<usize> = cores.iter().take(1).copied().chain(slots.iter().map(|slot| slot.core)).collect();
        let switch = rate.ticks(SWITCH) as f64;
        let load = |worker| {
            let counts = page.counts(worker);
            switch + counts.compute as f64 / (step + 1) as f64
        };
        let loads: Vec<f64> = (0..self.plan.workers.len()).map(load).collect();
        let members: Vec<_> = (0..self.plan.phase_count()).map(|phase| self.plan.members(phase)).collect();
        let chosen: Vec<usize> = spread(&members, &loads, used.len()).into_iter().map(|place| used[place]).collect();
        // A process that cannot be moved has just ended; the run reports it when it is missed.
        let _ = self.spread(&chosen);
    }
}
