//! What no process of the run can have written in order: the trace of a stray pointer.
//!
//! All processes write to the page, so nothing keeps one of them from writing to the wrong place of it. But the conductor knows
//! much of what must stand there, and a worker what must not change while it computes. These looks cost next to nothing.

use std::sync::atomic::Ordering::SeqCst;

use super::claim::{self, Claimed};
use super::gates::place;
use super::memory::{Memory, Word};
use super::{Page, STOP, lowest_bits, released};

impl<M: Memory> Page<M> {
    /// Which words are invalid in a run of which `recorded` steps are complete at least, and steps below `limit` may run; before,
    /// those below `allowed` might. For the conductor, between two steps and whenever something has happened; not once the run
    /// is stopped.
    pub(crate) fn invalid_words(&self, recorded: u64, limit: u64, allowed: u64) -> Option<&'static str> {
        // Read first: all else is of this step or a later one.
        let completed = self.completed();
        if self.memory.limit().load(SeqCst) != limit {
            Some("how far the run may go")
        } else if !(recorded..=allowed).contains(&completed) {
            Some("how many steps are complete")
        } else if !self.is_plausible(claim::read(self.memory.completion_claim()), allowed) {
            Some("the record of which process completes the step")
        } else {
            (0..self.memory.phase_count()).find_map(|phase| self.invalid_words_of(phase, completed, allowed))
        }
    }

    fn invalid_words_of(&self, phase: usize, completed: u64, allowed: u64) -> Option<&'static str> {
        let gate = self.memory.gate(phase).load(SeqCst);
        // Numbers of gates are cut at 31 bits. Every gate was opened for all steps that are complete.
        let ahead = gate.wrapping_sub(released(completed).wrapping_sub(1)) & !STOP;
        if gate & STOP != 0 || u64::from(ahead) > allowed - completed {
            return Some("the gate of a phase");
        }
        let members = self.memory.member_count(phase);
        let last = members.div_ceil(M::WORKERS_PER_WORD).max(1) - 1;
        let used = lowest_bits(members - M::WORKERS_PER_WORD * last);
        if self.memory.arrivals(phase, last).load(SeqCst) & !used != 0 {
            return Some("the record of which processes have arrived in a phase");
        }
        let claimed = claim::read(self.memory.gate_claim(phase));
        (!self.is_plausible(claimed, allowed)).then_some("the record of which process opens the gate of a phase")
    }

    fn is_plausible(&self, claimed: Claimed, allowed: u64) -> bool {
        claimed.steps <= allowed && claimed.claimant <= self.memory.worker_count() as u64
    }

    /// Whether the page is as a worker must find it that is about to arrive in a phase of `step`: until then, no other process
    /// can have let the run continue.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn expects_arrival(&self, phase: usize, position: usize, step: u64) -> bool {
        let (word, bit) = place(position, M::WORKERS_PER_WORD);
        self.memory.gate(phase).load(SeqCst) & !STOP == released(step)
            && self.memory.arrivals(phase, word).load(SeqCst) & bit == 0
            && self.memory.completed().load(SeqCst) == step
            && self.memory.limit().load(SeqCst) > step
    }
}
