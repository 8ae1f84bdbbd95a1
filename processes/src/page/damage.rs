//! What stands on the page although no process of the run can have written it in order: the trace of a stray pointer.
//!
//! All processes write to the page, so nothing keeps one of them from writing to the wrong place of it. But the conductor knows
//! much of what must stand there, and a worker what must not change while it computes. These looks cost next to nothing.

use std::sync::atomic::Ordering::SeqCst;

use super::memory::MAGIC;
use super::{Page, STOP, claim::Claim, released};

impl Page {
    /// What is damaged on the page of a run of which `recorded` steps are complete at least, and steps below `limit` may run;
    /// before, those below `allowed` might. For the conductor, between two steps and whenever something has happened; not once
    /// the run is stopped.
    pub(crate) fn damage(&self, recorded: u64, limit: u64, allowed: u64) -> Option<&'static str> {
        // Read first: all else is of this step or a later one.
        let completed = self.completed();
        let pace = &self.head().pace;
        if !self.has_its_mark() {
            Some("its first words")
        } else if pace.limit.load(SeqCst) != limit {
            Some("how far the run may go")
        } else if !(recorded..=allowed).contains(&completed) {
            Some("how many steps are complete")
        } else if !self.is_plausible(&pace.finish, allowed) {
            Some("the record of which process completes the step")
        } else {
            (0..self.phases).find_map(|phase| self.damage_of(phase, completed, allowed))
        }
    }

    fn damage_of(&self, phase: usize, completed: u64, allowed: u64) -> Option<&'static str> {
        let place = self.phase(phase);
        let gate = place.gate.load(SeqCst);
        // Numbers of gates are cut at 31 bits. Every gate was opened for all steps that are complete.
        let ahead = gate.wrapping_sub(released(completed).wrapping_sub(1)) & !STOP;
        if gate & STOP != 0 || u64::from(ahead) > allowed - completed {
            return Some("the gate of a phase");
        }
        let members = self.members(phase);
        let unused = match members % 64 {
            0 => 0,
            used => u64::MAX << used,
        };
        let last = members.div_ceil(64).max(1) as usize - 1;
        if place.masks[last].load(SeqCst) & unused != 0 {
            return Some("the record of which processes have arrived in a phase");
        }
        (!self.is_plausible(&place.claim, allowed)).then_some("the record of which process opens the gate of a phase")
    }

    fn is_plausible(&self, claim: &Claim, allowed: u64) -> bool {
        let claimed = claim.read();
        claimed.steps <= allowed && claimed.claimant <= self.workers as u64
    }

    fn has_its_mark(&self) -> bool {
        let head = self.head();
        head.magic.load(SeqCst) == MAGIC && head.plan.load(SeqCst) == self.fingerprint
    }

    /// Whether the page is as a worker must find it that is about to arrive in a phase of `step`: until then, nobody else can
    /// have let the run go on.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn awaits(&self, phase: usize, position: usize, step: u64) -> bool {
        let (place, pace) = (self.phase(phase), &self.head().pace);
        place.gate.load(SeqCst) & !STOP == released(step)
            && place.masks[position / 64].load(SeqCst) & 1 << (position % 64) == 0
            && pace.completed.load(SeqCst) == step
            && pace.limit.load(SeqCst) > step
            && self.has_its_mark()
    }
}
