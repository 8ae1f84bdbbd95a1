//! The page of shared memory at which the processes of a run meet: gates, arrivals, faults.
//!
//! It is an anonymous file inherited by the children: it has no name, so nothing is left of it when the last process ends.
//!
//! A step goes through the phases like this. Every worker of an open phase runs and sets its bit; whoever sets the last bit
//! opens the gate of the next phase, and after the last phase that of the next step, if the conductor has allowed it already.
//! So a phase takes one wake-up per worker, and the conductor is woken once in several steps: when as many are complete as it
//! waits for. The bits are the truth about who is where; gates and bell only wake.
//!
//! Two may want to open a step at once: the worker that completes the step before, and the conductor that allows it. Each
//! first writes what the other looks at and then looks (`completed` and `limit`), so that at least one of them finds both. The
//! same order keeps the conductor from sleeping through what it waits for.
//!
//! Whoever lets the run go on first claims that, with its number, so that only one does it; and when a worker dies at it,
//! the conductor sees what the dead one had taken on and does it in its place ([`Page::repair`]).

mod claim;
mod damage;
mod events;
mod memory;
mod passing;
mod repair;
mod side;
mod spot;
mod tally;
mod wake;

use std::num::NonZeroU32;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::time::Duration;

use claim::CONDUCTOR;
pub(crate) use events::Events;
use memory::MESSAGE_BYTES;
pub(crate) use memory::Page;
use spot::Spot;
pub(crate) use tally::{Run, Watch};
use wake::EVERYBODY;
pub use wake::run_name;

use crate::ticks;

/// Bit of a gate that says: no further step.
const STOP: u32 = 1 << 31;

/// What a worker reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum FaultKind {
    /// It could not start.
    Refusal = 1,
    /// A participant could not compute its step.
    Fault = 2,
    /// It finds the page overwritten that it is about to report its step on.
    Overwritten = 3,
}

/// How a worker has arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    OneOfMany,
    /// All others of its side had arrived, and those of another side had not: it is to watch, see [`Page::await_gate`].
    LastOfSide,
    /// All others had arrived, and it has let the run go on.
    Last,
}

/// A worker's report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Report {
    pub(crate) kind: FaultKind,
    pub(crate) node: usize,
    pub(crate) step: u64,
    pub(crate) message: String,
}

/// The conductor's side.
impl Page {
    /// Lets all steps below `limit` run, without anybody asking the conductor in between.
    pub(crate) fn allow(&self, limit: u64) {
        let pace = &self.head().pace;
        pace.limit.store(limit, SeqCst);
        let completed = pace.completed.load(SeqCst);
        if completed < limit {
            self.open_step(completed, CONDUCTOR);
        }
    }

    /// How many steps are complete.
    pub(crate) fn completed(&self) -> u64 {
        self.head().pace.completed.load(SeqCst)
    }

    /// Asks to be woken once `steps` are complete; `false` if they are.
    pub(crate) fn ask_for(&self, steps: u64) -> bool {
        self.head().pace.wake_at.store(steps, SeqCst);
        self.completed() < steps
    }

    /// The first phase of `step` that is not complete; `None` if all are.
    pub(crate) fn phase_of(&self, step: u64) -> Option<usize> {
        (0..self.phases).find(|&phase| !self.is_complete(phase, step))
    }

    /// Whether all workers of a phase have arrived at `step`.
    fn is_complete(&self, phase: usize, step: u64) -> bool {
        // Arrivals belong to the step that the gate shows.
        self.is_open(phase, step) && self.have_all_arrived(phase)
    }

    fn is_open(&self, phase: usize, step: u64) -> bool {
        self.phase(phase).gate.load(SeqCst) & !STOP == released(step)
    }

    /// Whether the worker at `position` in a phase has arrived at `step`, which must be in progress.
    pub(crate) fn has_arrived(&self, phase: usize, position: usize, step: u64) -> bool {
        self.is_open(phase, step) && self.phase(phase).masks[position / 64].load(SeqCst) & 1 << (position % 64) != 0
    }

    /// How often the bell has been rung.
    pub(crate) fn rings(&self) -> u32 {
        self.head().bell.load(SeqCst)
    }

    /// Sleeps until the bell is rung more often than `rings`, or for `patience`; may return earlier.
    pub(crate) fn sleep(&self, rings: u32, patience: Duration) {
        self.sleep_while(Spot::Bell, rings, NonZeroU32::MAX, Some(patience));
    }

    /// Lets every worker end, now or at its next gate.
    pub(crate) fn stop(&self) {
        for phase in 0..self.phases {
            self.phase(phase).gate.fetch_or(STOP, SeqCst);
            self.wake(Spot::Gate(phase), EVERYBODY);
        }
    }

    /// How many workers are connected.
    pub(crate) fn ready_count(&self) -> usize {
        self.head().ready.load(SeqCst) as usize
    }

    /// A worker that is not there any more is not connected either, and what it reported is done with.
    pub(crate) fn vacate(&self, worker: usize) {
        let slot = self.slot(worker);
        if slot.ready.swap(0, SeqCst) != 0 {
            self.head().ready.fetch_sub(1, SeqCst);
        }
        if slot.kind.swap(0, SeqCst) != 0 {
            self.head().faults.fetch_sub(1, SeqCst);
        }
        slot.dismissed.store(0, SeqCst);
        slot.process.store(0, SeqCst);
    }

    /// Whether a process has taken the place of a worker.
    pub(crate) fn is_taken(&self, worker: usize) -> bool {
        self.slot(worker).process.load(SeqCst) != 0
    }

    /// Whether a worker is connected.
    pub(crate) fn is_ready(&self, worker: usize) -> bool {
        self.slot(worker).ready.load(SeqCst) != 0
    }

    /// How many reports there are.
    pub(crate) fn report_count(&self) -> u32 {
        self.head().faults.load(SeqCst)
    }

    /// What a worker reported, if it did.
    pub(crate) fn report(&self, worker: usize) -> Option<Report> {
        let slot = self.slot(worker);
        let kind = match slot.kind.load(SeqCst) {
            0 => return None,
            1 => FaultKind::Refusal,
            2 => FaultKind::Fault,
            3 => FaultKind::Overwritten,
            // No worker has left that.
            _ => return None,
        };
        let length = (slot.length.load(SeqCst) as usize).min(MESSAGE_BYTES);
        let bytes: Vec<u8> = slot.message[..length].iter().map(|byte| byte.load(SeqCst)).collect();
        let message = String::from_utf8_lossy(&bytes).into_owned();
        Some(Report { kind, node: slot.node.load(SeqCst) as usize, step: slot.step.load(SeqCst), message })
    }
}

/// The workers' side.
impl Page {
    /// Waits until a phase of `step` is open; `false` if there is no such step any more, or not for this worker.
    ///
    /// Before that, the worker watches for its side if it has to: since it left that phase of that step.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn await_gate(&self, worker: usize, phase: usize, step: u64, watch: Option<(usize, u64)>) -> bool {
        if let Some((left, at)) = watch {
            self.keep_watch(worker, left, at);
        }
        let gate = &self.phase(phase).gate;
        let wanted = released(step);
        let mut may_pass = true;
        loop {
            let value = gate.load(SeqCst);
            if value & STOP != 0 {
                return false;
            }
            if value == wanted {
                return true;
            }
            if self.is_dismissed(worker) {
                return false;
            }
            if std::mem::take(&mut may_pass) && self.pass_core_on() {
                continue;
            }
            self.sleep_at(worker, phase, value);
        }
    }

    /// A worker, at `position` in a phase, is done with it; the last one lets the run go on.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn arrive(&self, worker: usize, phase: usize, position: usize, step: u64) -> Arrival {
        let is_last_of_side = self.is_last_of_side(worker, phase);
        if self.arrive_at(worker, phase, position, step) {
            Arrival::Last
        } else if is_last_of_side {
            Arrival::LastOfSide
        } else {
            Arrival::OneOfMany
        }
    }

    /// Sets the bit; whether the worker was the last one, and has let the run go on.
    #[unsafe(link_section = "lockstep_step")]
    fn arrive_at(&self, worker: usize, phase: usize, position: usize, step: u64) -> bool {
        let place = self.phase(phase);
        let members = self.members(phase);
        let (word, bit) = (position / 64, 1 << (position % 64));
        let in_word = (members - 64 * word as u32).min(64);
        if place.masks[word].fetch_or(bit, SeqCst) | bit != full(in_word) {
            return false;
        }
        // Of several who find all words full, one gets the claim.
        (members <= 64 || self.have_all_arrived(phase)) && self.proceed(phase, step, claim::of_worker(worker))
    }

    /// The step is complete: the next one may go if it is allowed, and the conductor is woken if it waits for this.
    #[unsafe(link_section = "lockstep_step")]
    fn complete(&self, step: u64, claimant: u64) {
        let pace = &self.head().pace;
        let completed = step + 1;
        pace.completed.store(completed, SeqCst);
        if completed < pace.limit.load(SeqCst) {
            self.open_step(completed, claimant);
        }
        // Every number of steps is passed by, so the one that is waited for cannot be missed.
        if completed == pace.wake_at.load(SeqCst) {
            self.ring();
        }
    }

    /// Takes the place of a worker for the process `pid`.
    ///
    /// # Errors
    /// The process that has it already.
    pub(crate) fn take_place(&self, worker: usize, pid: u32) -> Result<(), u32> {
        self.slot(worker).process.compare_exchange(0, pid, SeqCst, SeqCst).map(drop)
    }

    /// This worker is connected.
    pub(crate) fn mark_ready(&self, worker: usize) {
        self.slot(worker).ready.store(1, SeqCst);
        if self.head().ready.fetch_add(1, SeqCst) + 1 == self.workers as u32 {
            self.ring();
        }
    }

    /// Leaves a report; the message is cut at 1000 bytes.
    pub(crate) fn leave(&self, worker: usize, report: &Report) {
        let slot = self.slot(worker);
        let mut length = report.message.len().min(MESSAGE_BYTES);
        while !report.message.is_char_boundary(length) {
            length -= 1;
        }
        slot.message.iter().zip(&report.message.as_bytes()[..length]).for_each(|(to, &from)| to.store(from, SeqCst));
        slot.length.store(length as u32, SeqCst);
        slot.node.store(report.node as u32, SeqCst);
        slot.step.store(report.step, SeqCst);
        slot.kind.store(report.kind as u32, SeqCst);
        self.head().faults.fetch_add(1, SeqCst);
        self.ring();
    }
}

/// Both sides.
impl Page {
    /// Wakes the conductor.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn ring(&self) {
        // The word changes first: who is about to sleep on the old value then does not.
        self.head().bell.fetch_add(1, SeqCst);
        self.wake(Spot::Bell, EVERYBODY);
    }

    /// All workers of a phase have arrived at `step`: lets the next phase run, or completes the step, unless somebody else
    /// does.
    #[unsafe(link_section = "lockstep_step")]
    fn proceed(&self, phase: usize, step: u64, claimant: u64) -> bool {
        let is_last = phase + 1 == self.phases;
        let claim = if is_last { &self.head().pace.finish } else { &self.phase(phase + 1).claim };
        if !claim.take(step, claimant) {
            return false;
        }
        if is_last {
            self.complete(step, claimant);
        } else {
            self.open_gate(phase + 1, step, claimant);
        }
        true
    }

    /// Opens the first gate of `step`, all before it being complete, unless somebody else does.
    #[unsafe(link_section = "lockstep_step")]
    fn open_step(&self, step: u64, claimant: u64) {
        if self.phase(0).claim.take(step, claimant) {
            self.open_gate(0, step, claimant);
        }
    }

    /// Whether all workers of a phase have arrived at the step of its gate.
    #[unsafe(link_section = "lockstep_step")]
    fn have_all_arrived(&self, phase: usize) -> bool {
        let place = self.phase(phase);
        let members = self.members(phase);
        let words = place.masks[..members.div_ceil(64) as usize].iter().enumerate();
        let mut of_word = words.map(|(word, mask)| (mask, (members - 64 * word as u32).min(64)));
        of_word.all(|(mask, members)| mask.load(SeqCst) == full(members))
    }

    /// Opens a gate, at which all workers of the phase wait or will wait; nobody has arrived then. For who has claimed it.
    #[unsafe(link_section = "lockstep_step")]
    fn open_gate(&self, phase: usize, step: u64, claimant: u64) {
        let place = self.phase(phase);
        let words = self.members(phase).div_ceil(64) as usize;
        place.masks[..words].iter().for_each(|mask| mask.store(0, SeqCst));
        self.clear_shares(phase);
        place.opened_at.store(ticks::now(), Relaxed);
        let gate = &place.gate;
        // Not a plain store: a stop that comes in between must stay.
        let before = gate.load(SeqCst);
        if before & STOP == 0 && gate.compare_exchange(before, released(step), SeqCst, SeqCst).is_ok() {
            self.wake_sides(phase, step, claim::worker(claimant));
        }
    }
}

/// What a gate shows once `step` may run.
fn released(step: u64) -> u32 {
    (step + 1) as u32 & !STOP
}

/// The lowest `count` bits, up to 64.
fn full(count: u32) -> u64 {
    u64::MAX.checked_shr(64 - count).unwrap_or(0)
}
