//! What the conductor does in the place of a worker that died while it let the run go on, and where its successor comes in.

use std::sync::atomic::Ordering::SeqCst;

use super::Page;
use super::claim::{self, CONDUCTOR, Claim};
use super::spot::Spot;
use super::wake::EVERYBODY;

impl Page {
    /// Does what dead workers have left undone. To be called after every death, before anybody takes the place of the dead.
    ///
    /// A worker may die at any instruction. What it had claimed nobody else does, so the conductor may; what nobody has
    /// claimed the conductor claims itself, against whoever is alive and about to do the same.
    pub(crate) fn repair(&self, is_dead: impl Fn(usize) -> bool) {
        // Whoever has opened a gate may have relied on a dead watcher.
        self.relieve();
        let pace = &self.head().pace;
        let step = pace.completed.load(SeqCst);
        let was_claimed_by_the_dead = |claim: &Claim| {
            let claimed = claim.read();
            claimed.steps == step + 1
                && claim::worker(claimed.claimant).is_some_and(|worker| worker < self.workers && is_dead(worker))
        };
        for phase in 0..self.phases {
            if !self.is_open(phase, step) {
                if was_claimed_by_the_dead(&self.phase(phase).claim) {
                    self.open_gate(phase, step, CONDUCTOR);
                } else if phase == 0 && step < pace.limit.load(SeqCst) {
                    self.open_step(step, CONDUCTOR);
                }
                if !self.is_open(phase, step) {
                    return;
                }
            }
            // Who opened it may have died before waking anybody.
            self.wake(Spot::Gate(phase), EVERYBODY);
            if !self.is_complete(phase, step) {
                return;
            }
            self.proceed(phase, step, CONDUCTOR);
        }
        if was_claimed_by_the_dead(&pace.finish) && pace.completed.load(SeqCst) == step {
            self.complete(step, CONDUCTOR);
        }
    }

    /// The first step and phase of those in `places` (phase and position, in order of phases) at which a worker that is dead
    /// has not arrived.
    pub(crate) fn resumption(&self, places: &[(usize, usize)]) -> (u64, usize) {
        loop {
            let step = self.completed();
            let missing = places.iter().position(|&(phase, position)| !self.has_arrived(phase, position, step));
            // Arrivals of a step stay as they are until it is complete.
            if self.completed() == step {
                return missing.map_or((step + 1, 0), |place| (step, place));
            }
        }
    }

    /// Asks the process of a worker to end at its next gate.
    pub(crate) fn dismiss(&self, worker: usize) {
        self.slot(worker).dismissed.store(1, SeqCst);
        // Whoever looked at that before and is about to sleep wakes when the run goes on, or is killed by a patience's end.
        (0..self.phases).for_each(|phase| self.wake(Spot::Gate(phase), EVERYBODY));
    }

    /// Whether the process of a worker is to end.
    pub(crate) fn is_dismissed(&self, worker: usize) -> bool {
        self.slot(worker).dismissed.load(SeqCst) != 0
    }

    /// Number of the process that serves as a worker.
    pub(crate) fn incarnation(&self, worker: usize) -> u32 {
        self.slot(worker).incarnation.load(SeqCst)
    }

    /// From now on the process with this number serves as a worker.
    pub(crate) fn take_over(&self, worker: usize, incarnation: u32) {
        self.slot(worker).incarnation.store(incarnation, SeqCst);
        self.head().changes.count.fetch_add(1, SeqCst);
    }

    /// How often a worker was replaced.
    pub(crate) fn changes(&self) -> u32 {
        self.head().changes.count.load(SeqCst)
    }
}
