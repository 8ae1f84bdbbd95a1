//! Death: what the conductor completes for a worker that died while it let the run continue, and where its successor resumes.

use std::sync::atomic::Ordering::SeqCst;

use super::Page;
use super::claim::{self, CONDUCTOR};
use super::memory::{EVERY_GROUP, Memory, WaitPoint, Word};

impl<M: Memory> Page<M> {
    /// Does what dead workers have left undone. To be called after every death, before a successor takes the place of the dead.
    ///
    /// A worker may die at any instruction. What it had claimed no other process does, so the conductor may; what is not
    /// claimed the conductor claims itself, in competition with living workers that are about to do the same.
    pub(crate) fn repair(&self, is_dead: impl Fn(usize) -> bool) {
        // A process that has opened a gate may have relied on a dead worker to poll it.
        self.end_polling();
        let step = self.completed();
        let was_claimed_by_a_dead_worker = |claim: claim::Claimed| {
            claim.steps == step + 1
                && claim::worker(claim.claimant)
                    .is_some_and(|worker| worker < self.memory.worker_count() && is_dead(worker))
        };
        for phase in 0..self.memory.phase_count() {
            if !self.is_open(phase, step) {
                if was_claimed_by_a_dead_worker(claim::read(self.memory.gate_claim(phase))) {
                    self.open_gate(phase, step, CONDUCTOR);
                } else if phase == 0 && step < self.memory.limit().load(SeqCst) {
                    self.open_step(step, CONDUCTOR);
                }
                if !self.is_open(phase, step) {
                    return;
                }
            }
            // The worker that opened it may have died before it woke the others.
            self.memory.wake(WaitPoint::Gate(phase), EVERY_GROUP);
            if !self.is_complete(phase, step) {
                return;
            }
            self.proceed(phase, step, CONDUCTOR);
        }
        if was_claimed_by_a_dead_worker(claim::read(self.memory.completion_claim())) && self.completed() == step {
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
        self.memory.dismissed(worker).store(1, SeqCst);
        // A process that read the word before and is about to sleep wakes when the run continues, or is killed after a time-out.
        (0..self.memory.phase_count()).for_each(|phase| self.memory.wake(WaitPoint::Gate(phase), EVERY_GROUP));
    }

    /// Whether the process of a worker is to end.
    pub(crate) fn is_dismissed(&self, worker: usize) -> bool {
        self.memory.dismissed(worker).load(SeqCst) != 0
    }
}
