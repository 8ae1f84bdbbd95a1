//! What is searched: the shape of a run, and what happens to it.

use crate::flaws::Flaw;

/// What is checked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// Workers of every phase.
    pub(crate) sizes: &'static [u8],
    pub(crate) steps: u8,
    /// Steps that the workers may be ahead.
    pub(crate) ahead: u8,
    pub(crate) event: Event,
    pub(crate) flaw: Option<Flaw>,
    /// The core group of every worker; empty: there is one only, and no worker polls.
    pub(crate) groups: &'static [u8],
}

/// What happens to the run, at every possible moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    None,
    /// The run is interrupted from another thread.
    Interrupt,
    /// A worker dies, and the run ends.
    Death,
    /// A worker dies, and another process takes its place.
    Replacement,
}

impl Run {
    /// The process number of the conductor, behind the workers.
    pub(crate) fn conductor(&self) -> usize {
        self.sizes.iter().map(|&size| usize::from(size)).sum()
    }

    /// Phase of a worker, and its position there.
    pub(crate) fn place(&self, worker: usize) -> (usize, usize) {
        let mut first = 0;
        for (phase, &size) in self.sizes.iter().enumerate() {
            if worker < first + usize::from(size) {
                return (phase, worker - first);
            }
            first += usize::from(size);
        }
        unreachable!("process {worker} is no worker")
    }

    pub(crate) fn group(&self, worker: usize) -> usize {
        self.groups.get(worker).map_or(0, |&group| group.into())
    }

    pub(crate) fn group_members(&self, phase: usize, group: usize) -> u64 {
        let workers = 0..self.conductor();
        workers.filter(|&worker| self.place(worker).0 == phase && self.group(worker) == group).count() as u64
    }

    /// The steps that the conductor allows when it waits for `step`.
    pub(crate) fn limit(&self, step: u8) -> u8 {
        (step + self.ahead + 1).min(self.steps)
    }
}
