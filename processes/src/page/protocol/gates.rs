//! Gates, arrivals, steps: how the run continues from one phase to the next.

use std::num::NonZeroU32;
use std::ops::ControlFlow;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::time::Duration;

use super::claim::{self, CONDUCTOR};
use super::memory::{EVERY_GROUP, Memory, WaitPoint, Word};
use super::{Page, STOP, lowest_bits, released};

/// How a worker has arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    OneOfMany,
    /// All others of its core group had arrived, and those of another group had not: it is to poll for its group, see
    /// [`Page::poll_next_gate`].
    LastOfGroup,
    /// All others had arrived, and it has let the run continue.
    Last,
}

/// For the conductor.
impl<M: Memory> Page<M> {
    /// Lets all steps below `limit` run; between them, no process asks the conductor.
    pub(crate) fn allow(&self, limit: u64) {
        self.memory.limit().store(limit, SeqCst);
        let completed = self.completed();
        if completed < limit {
            self.open_step(completed, CONDUCTOR);
        }
    }

    /// How many steps are complete.
    pub(crate) fn completed(&self) -> u64 {
        self.memory.completed().load(SeqCst)
    }

    /// Sleeps until `steps` are complete, or the bell is rung, unless `look` finds something that ends the wait. `look` says
    /// for how long to sleep at most; the sleep may end earlier.
    pub(crate) fn sleep_unless<E>(
        &self,
        steps: u64,
        look: impl FnOnce() -> ControlFlow<E, Duration>,
    ) -> ControlFlow<E> {
        // Before the look: what happens after it rings again.
        let rings = self.rings();
        let patience = look()?;
        if self.ask_for(steps) {
            self.sleep(rings, patience);
        }
        ControlFlow::Continue(())
    }

    /// Asks to be woken once `steps` are complete; `false` if they are.
    fn ask_for(&self, steps: u64) -> bool {
        // The request first: a worker that completes them after the second look finds it.
        self.memory.wake_at().store(steps, SeqCst);
        self.completed() < steps
    }

    /// The first phase of `step` that is not complete; `None` if all are.
    pub(crate) fn phase_of(&self, step: u64) -> Option<usize> {
        (0..self.memory.phase_count()).find(|&phase| !self.is_complete(phase, step))
    }

    /// Whether all workers of a phase have arrived at `step`.
    pub(super) fn is_complete(&self, phase: usize, step: u64) -> bool {
        // Arrivals belong to the step that the gate shows.
        self.is_open(phase, step) && self.have_all_arrived(phase)
    }

    pub(super) fn is_open(&self, phase: usize, step: u64) -> bool {
        self.memory.gate(phase).load(SeqCst) & !STOP == released(step)
    }

    /// Whether the worker at `position` in a phase has arrived at `step`, which must be in progress.
    pub(crate) fn has_arrived(&self, phase: usize, position: usize, step: u64) -> bool {
        let (word, bit) = place(position, M::WORKERS_PER_WORD);
        self.is_open(phase, step) && self.memory.arrivals(phase, word).load(SeqCst) & bit != 0
    }

    /// How often the bell has been rung.
    pub(crate) fn rings(&self) -> u32 {
        self.memory.bell().load(SeqCst)
    }

    /// Sleeps until the bell is rung more often than `rings`, or for `patience`; may return earlier.
    pub(crate) fn sleep(&self, rings: u32, patience: Duration) {
        self.memory.sleep_while(WaitPoint::Bell, rings, NonZeroU32::MAX, Some(patience));
    }

    /// Lets every worker end, now or at its next gate.
    pub(crate) fn stop(&self) {
        for phase in 0..self.memory.phase_count() {
            self.memory.gate(phase).fetch_or(STOP);
            self.memory.wake(WaitPoint::Gate(phase), EVERY_GROUP);
        }
    }
}

/// For the workers.
impl<M: Memory> Page<M> {
    /// Waits until a phase of `step` is open; `false` if there will be no such step, or not for this process.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn await_gate(&self, worker: usize, phase: usize, step: u64) -> bool {
        let wanted = released(step);
        let mut may_yield = true;
        loop {
            let value = self.memory.gate(phase).load(SeqCst);
            if value & STOP != 0 {
                return false;
            }
            if value == wanted {
                return true;
            }
            if self.is_dismissed(worker) {
                return false;
            }
            if std::mem::take(&mut may_yield) && self.yield_core() {
                continue;
            }
            self.sleep_at_gate(worker, phase, value);
        }
    }

    /// A worker, at `position` in a phase, is done with it; the last one lets the run continue.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn arrive(&self, worker: usize, phase: usize, position: usize, step: u64) -> Arrival {
        let is_last_of_group = self.is_last_of_group(worker, phase);
        if self.arrive_at(worker, phase, position, step) {
            Arrival::Last
        } else if is_last_of_group {
            Arrival::LastOfGroup
        } else {
            Arrival::OneOfMany
        }
    }

    /// Sets the bit; whether the worker was the last one, and has let the run continue.
    #[unsafe(link_section = "lockstep_step")]
    fn arrive_at(&self, worker: usize, phase: usize, position: usize, step: u64) -> bool {
        let members = self.memory.member_count(phase);
        let (word, bit) = place(position, M::WORKERS_PER_WORD);
        if self.memory.arrivals(phase, word).fetch_or(bit) | bit != full::<M>(members, word) {
            return false;
        }
        // Of several that find all words full, one gets the claim.
        (members <= M::WORKERS_PER_WORD || self.have_all_arrived(phase))
            && self.proceed(phase, step, claim::of_worker(worker))
    }
}

/// For both.
impl<M: Memory> Page<M> {
    /// Wakes the conductor.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn ring(&self) {
        // The word first: a conductor that is about to sleep on the old value then does not.
        self.memory.bell().fetch_add(1, SeqCst);
        self.memory.wake(WaitPoint::Bell, EVERY_GROUP);
    }

    /// All workers of a phase have arrived at `step`: lets the next phase run, or completes the step, unless another process
    /// does.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn proceed(&self, phase: usize, step: u64, claimant: u64) -> bool {
        let next = phase + 1;
        if next == self.memory.phase_count() {
            let is_claimed = claim::take(self.memory.completion_claim(), step, claimant);
            if is_claimed {
                self.complete(step, claimant);
            }
            is_claimed
        } else {
            let is_claimed = claim::take(self.memory.gate_claim(next), step, claimant);
            if is_claimed {
                self.open_gate(next, step, claimant);
            }
            is_claimed
        }
    }

    /// The step is complete: the next one may run if it is allowed, and the conductor is woken if it waits for this.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn complete(&self, step: u64, claimant: u64) {
        let completed = step + 1;
        self.memory.completed().store(completed, SeqCst);
        if completed < self.memory.limit().load(SeqCst) {
            self.open_step(completed, claimant);
        }
        // Steps complete one by one, so the number that the conductor waits for cannot be missed.
        if completed == self.memory.wake_at().load(SeqCst) {
            self.ring();
        }
    }

    /// Opens the first gate of `step`, before which all steps are complete, unless another process does.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn open_step(&self, step: u64, claimant: u64) {
        if claim::take(self.memory.gate_claim(0), step, claimant) {
            self.open_gate(0, step, claimant);
        }
    }

    /// Whether all workers of a phase have arrived at the step of its gate.
    #[unsafe(link_section = "lockstep_step")]
    fn have_all_arrived(&self, phase: usize) -> bool {
        let members = self.memory.member_count(phase);
        let mut words = 0..members.div_ceil(M::WORKERS_PER_WORD);
        words.all(|word| self.memory.arrivals(phase, word).load(SeqCst) == full::<M>(members, word))
    }

    /// Opens a gate that the caller has claimed. All workers of the phase wait at it or will; none of them has arrived then.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn open_gate(&self, phase: usize, step: u64, claimant: u64) {
        // Before the gate opens: a worker that passes it may arrive at once.
        let words = self.memory.member_count(phase).div_ceil(M::WORKERS_PER_WORD);
        (0..words).for_each(|word| self.memory.arrivals(phase, word).store(0, SeqCst));
        self.clear_group_arrivals(phase);
        self.memory.opened_at(phase).store(self.memory.now(), Relaxed);
        let gate = self.memory.gate(phase);
        // Not a plain store: a stop that comes in between must stay.
        let before = gate.load(SeqCst);
        if before & STOP == 0 && gate.replace(before, released(step)) {
            self.wake_groups(phase, step, claim::worker(claimant));
        }
    }
}

/// The word of a position among the workers of a phase, and its bit there.
#[inline(always)]
pub(super) fn place(position: usize, workers_per_word: usize) -> (usize, u64) {
    (position / workers_per_word, 1 << (position % workers_per_word))
}

/// What word number `word` of a phase's arrivals shows once all have arrived.
#[inline(always)]
fn full<M: Memory>(members: usize, word: usize) -> u64 {
    lowest_bits((members - M::WORKERS_PER_WORD * word).min(M::WORKERS_PER_WORD))
}
