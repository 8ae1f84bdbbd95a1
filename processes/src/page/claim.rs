//! Who has taken on to let the run go on at a step: one of the workers, or the conductor.

use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

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

/// The step that was claimed last, plus 1, and behind it the number of the claimant.
#[repr(transparent)]
pub(super) struct Claim(AtomicU64);

/// What a [`Claim`] shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Claimed {
    /// Steps that were claimed.
    pub(super) steps: u64,
    /// Who has claimed the last of them.
    pub(super) claimant: u64,
}

impl Claim {
    /// Takes on `step`; `false` if somebody has taken it on, or a later one.
    pub(super) fn take(&self, step: u64, claimant: u64) -> bool {
        let before = self.0.load(SeqCst);
        let claim = (step + 1) << CLAIMANT_BITS | claimant;
        before >> CLAIMANT_BITS <= step && self.0.compare_exchange(before, claim, SeqCst, SeqCst).is_ok()
    }

    /// What was claimed last.
    pub(super) fn read(&self) -> Claimed {
        let value = self.0.load(SeqCst);
        Claimed { steps: value >> CLAIMANT_BITS, claimant: value & ((1 << CLAIMANT_BITS) - 1) }
    }
}
