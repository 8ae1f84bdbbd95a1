//! The protocol of gates and arrivals: which process may run when.
//!
//! A step goes through the phases like this. Every worker of an open phase runs and sets its bit; the worker that sets the last
//! bit opens the gate of the next phase, and after the last phase that of the next step, if the conductor has allowed it
//! already. So a phase takes one wake-up per worker, and the conductor is woken once in several steps: when as many are complete
//! as it waits for. The bits are the truth about which worker is where; gates and bell only wake.
//!
//! Two processes may want to open a step at once: the worker that completes the step before, and the conductor that allows it.
//! Each first writes what the other reads and then reads what the other writes (`completed` and `limit`), so that at least one
//! of them finds both. The same order keeps the conductor from sleeping through what it waits for. It needs sequentially
//! consistent accesses: with weaker ones, both might read before either has written.
//!
//! The process that lets the run continue first claims that, with its number, so that only one does it; and when a worker dies
//! while it does so, the conductor sees what the dead worker had claimed and completes it ([`Page::repair`]).
//!
//! These functions know the page only as [`Memory`]: words, sleep and wake-up. So the test `tests/protocol` compiles this folder
//! over a memory of its own, and runs the functions in every possible order of their accesses. Nothing else of the crate may be
//! used here.

mod check;
mod claim;
mod gates;
mod groups;
mod memory;
mod repair;
mod yielding;

pub(crate) use gates::Arrival;
#[allow(unused_imports, reason = "not in the search")]
pub(crate) use groups::CORE_GROUPS;
pub(crate) use memory::{Memory, WaitPoint, Word};

/// Bit of a gate that says: no further step.
const STOP: u32 = 1 << 31;

/// The page of a run, whose words are in `memory`.
pub(crate) struct Page<M> {
    pub(crate) memory: M,
}

/// What a gate shows once `step` may run.
fn released(step: u64) -> u32 {
    (step + 1) as u32 & !STOP
}

/// The lowest `count` bits, up to 64.
fn lowest_bits(count: usize) -> u64 {
    u64::MAX.checked_shr(64 - count as u32).unwrap_or(0)
}
