//! What stands where on the page: a head, the phases, a slot for each worker, the events of a trace.

use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64};

use super::counters::{Counters, Event};
use super::protocol::CORE_GROUPS;
use lockstep::{MAX_MEMBERS, Plan};

/// First word of a page: its kind and version.
pub(super) const MAGIC: u64 = u64::from_le_bytes(*b"phalanx5");
/// Bytes of a message in a slot.
pub(super) const MESSAGE_BYTES: usize = 1000;

#[repr(C, align(128))]
pub(super) struct Head {
    pub(super) magic: AtomicU64,
    /// The [`Plan::fingerprint`] of the run.
    pub(super) plan: AtomicU64,
    /// Rung for the conductor; counts up, so that a change while it looks elsewhere is not lost.
    pub(super) bell: AtomicU32,
    /// How many workers are connected.
    pub(super) ready: AtomicU32,
    /// How many workers have filled their fault slot.
    pub(super) faults: AtomicU32,
    pub(super) settings: Settings,
    pub(super) progress: Progress,
    pub(super) groups: [CoreGroup; CORE_GROUPS],
}

/// What may change while the run goes on, but seldom does; on its own cache line, because all workers read it in every step.
#[repr(C, align(128))]
pub(super) struct Settings {
    /// How often a worker was replaced.
    pub(super) replacements: AtomicU32,
    /// Ticks within which a worker that yields its core must get it back; 0: no worker yields.
    pub(super) yield_limit: AtomicU64,
    /// Ticks for which a gate may be polled; 0: the run has one core group only.
    pub(super) polling_limit: AtomicU64,
}

/// How far the run is and how far it may go, in numbers of steps; on its own cache line, because every step writes here.
#[repr(C, align(128))]
pub(super) struct Progress {
    /// Steps below this may run.
    pub(super) limit: AtomicU64,
    /// Which process completes a step.
    pub(super) completion_claim: AtomicU64,
    /// Steps that are complete.
    pub(super) completed: AtomicU64,
    /// The conductor is to be woken as soon as so many are complete.
    pub(super) wake_at: AtomicU64,
}

/// A core with workers.
#[repr(C, align(128))]
pub(super) struct CoreGroup {
    /// Which gate is polled for the group, and until which step it opens; 0 if none is.
    pub(super) polled: AtomicU64,
}

#[repr(C, align(128))]
pub(super) struct Phase {
    /// Number of steps released, modulo 2^31, and the bit that stops the workers.
    pub(super) gate: AtomicU32,
    /// Which process opens the gate for a step.
    pub(super) claim: AtomicU64,
    /// When the gate was opened last, in ticks; written before it opens.
    pub(super) opened_at: AtomicU64,
    /// How long the phase has lasted in all steps together, in ticks.
    pub(super) lasted: AtomicU64,
    pub(super) groups: [GroupMembers; CORE_GROUPS],
    /// Which workers have arrived, 64 of them to a word.
    pub(super) arrivals: [AtomicU64; MAX_MEMBERS / 64],
}

/// The workers of a core group in a phase.
#[repr(C)]
pub(super) struct GroupMembers {
    /// How many there are.
    pub(super) count: AtomicU32,
    /// How many have arrived since the gate was opened. A hint: a worker that dies here is not counted.
    pub(super) arrived: AtomicU32,
}

#[repr(C, align(128))]
pub(super) struct Slot {
    /// 1 as soon as the worker is connected.
    pub(super) ready: AtomicU32,
    /// Number of the process that serves as this worker: 0 is the one that was started first.
    pub(super) incarnation: AtomicU32,
    /// The process that has taken the place; 0 if none has.
    pub(super) process: AtomicU32,
    /// 1 if the process is to leave its place to another one.
    pub(super) dismissed: AtomicU32,
    /// The core group that it belongs to.
    pub(super) group: AtomicU32,
    /// A [`FaultKind`](super::FaultKind) as number, or 0.
    pub(super) kind: AtomicU32,
    pub(super) step: AtomicU64,
    pub(super) node: AtomicU32,
    pub(super) length: AtomicU32,
    pub(super) counters: Counters,
    pub(super) message: [AtomicU8; MESSAGE_BYTES],
}

// Phases stand behind the head, slots behind the phases, events behind the slots, without a gap: each part must end where the
// next one may begin. The kernel places a mapping at the start of a memory page, which is aligned for a head.
const _: () = {
    assert!(size_of::<Head>().is_multiple_of(align_of::<Phase>()));
    assert!(size_of::<Phase>().is_multiple_of(align_of::<Slot>()));
    assert!(size_of::<Head>().is_multiple_of(align_of::<Slot>()));
    assert!(size_of::<Slot>().is_multiple_of(align_of::<Event>()));
    assert!(size_of::<Head>().is_multiple_of(align_of::<Event>()));
    assert!(size_of::<Phase>().is_multiple_of(align_of::<Event>()));
    assert!(align_of::<Head>() <= 4096);
};

/// Bytes of the page of a run.
pub(super) fn size(plan: &Plan) -> usize {
    let (phases, workers) = (plan.phase_count(), plan.workers.len());
    size_of::<Head>()
        + phases * size_of::<Phase>()
        + workers * (size_of::<Slot>() + plan.traced as usize * size_of::<Event>())
}
