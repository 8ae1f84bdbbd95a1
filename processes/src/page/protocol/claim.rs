//! Claims: which process has undertaken to let the run continue at a step, a worker or the conductor.
//!
//! A claim is a word with the number of steps that were claimed and, behind it, the number of the process that claimed the last
//! of them.

use std::sync::atomic::Ordering::SeqCst;

use super::memory::Word;

/// Bits of the claimant's number.
const CLAIMANT_BITS: u32 = 16;
/// The conductor as a claimant.
pub(super) const CONDUCTOR: u64 = 0;

/// A worker as a claimant.
pub(super) fn of_worker(worker: usize) -> u64 {
    worker as u64 + 1
}

/// The worker that a claimant is; `None` for the conductor.
pub(super) fn worker(claimant: u64) -> Option<usize> {
    claimant.checked_sub(1).map(|worker| worker as usize)
}

/// What a claim shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Claimed {
    /// Steps that were claimed.
    pub(super) steps: u64,
    /// The process that claimed the last of them.
    pub(super) claimant: u64,
}

/// Claims `step`; `false` if another process has claimed it or a later one.
#[inline]
pub(super) fn take(claim: impl Word<u64>, step: u64, claimant: u64) -> bool {
    let before = claim.load(SeqCst);
    before >> CLAIMANT_BITS <= step && claim.replace(before, (step + 1) << CLAIMANT_BITS | claimant)
}

/// What was claimed last.
pub(super) fn read(claim: impl Word<u64>) -> Claimed {
    let value = claim.load(SeqCst);
    Claimed { steps: value >> CLAIMANT_BITS, claimant: value & ((1 << CLAIMANT_BITS) - 1) }
}
