//! What the protocol needs of the memory that the processes share.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

/// All core groups, as bits.
pub(crate) const EVERY_GROUP: u32 = u32::MAX;

/// Where a process sleeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WaitPoint {
    /// The conductor sleeps at the bell.
    Bell,
    /// The workers of a phase sleep at its gate.
    Gate(usize),
}

/// A word that several processes read and write; every method is one indivisible access.
pub(crate) trait Word<T> {
    fn load(&self, order: Ordering) -> T;
    fn store(&self, value: T, order: Ordering);
    /// Writes `new` if the word shows `current`; returns whether it did.
    fn replace(&self, current: T, new: T) -> bool;
    /// Adds and returns the value before.
    fn fetch_add(&self, value: T, order: Ordering) -> T;
    /// Sets bits and returns the value before.
    fn fetch_or(&self, bits: T) -> T;
}

macro_rules! impl_word {
    ($atomic:ty, $value:ty) => {
        impl Word<$value> for &$atomic {
            #[inline(always)]
            fn load(&self, order: Ordering) -> $value {
                <$atomic>::load(self, order)
            }

            #[inline(always)]
            fn store(&self, value: $value, order: Ordering) {
                <$atomic>::store(self, value, order);
            }

            #[inline(always)]
            fn replace(&self, current: $value, new: $value) -> bool {
                <$atomic>::compare_exchange(self, current, new, Ordering::SeqCst, Ordering::SeqCst).is_ok()
            }

            #[inline(always)]
            fn fetch_add(&self, value: $value, order: Ordering) -> $value {
                <$atomic>::fetch_add(self, value, order)
            }

            #[inline(always)]
            fn fetch_or(&self, bits: $value) -> $value {
                <$atomic>::fetch_or(self, bits, Ordering::SeqCst)
            }
        }
    };
}

impl_word!(AtomicU32, u32);
impl_word!(AtomicU64, u64);

/// The shared words of a run, and how its processes sleep at them.
pub(crate) trait Memory {
    /// How many workers a word of arrivals holds; fewer in a search, so that a few workers take several words.
    const WORKERS_PER_WORD: usize = 64;

    // What every process knows from the plan.
    fn phase_count(&self) -> usize;
    fn worker_count(&self) -> usize;
    /// How many workers take part in a phase.
    fn member_count(&self, phase: usize) -> usize;

    // How far the run is and how far it may go, in numbers of steps.
    /// Steps below this may run.
    fn limit(&self) -> impl Word<u64>;
    /// Steps that are complete.
    fn completed(&self) -> impl Word<u64>;
    /// The conductor is to be woken as soon as so many steps are complete.
    fn wake_at(&self) -> impl Word<u64>;
    /// The claim to complete a step, see [`claim`](super::claim).
    fn completion_claim(&self) -> impl Word<u64>;
    /// Counts up whenever the conductor is woken, so that a change is not lost while it looks elsewhere.
    fn bell(&self) -> impl Word<u32>;

    // Of a phase.
    /// Number of steps released, modulo 2^31, and [`STOP`](super::STOP).
    fn gate(&self, phase: usize) -> impl Word<u32>;
    /// The claim to open the gate for a step.
    fn gate_claim(&self, phase: usize) -> impl Word<u64>;
    /// Which of the workers of word number `word` have arrived, a bit each.
    fn arrivals(&self, phase: usize, word: usize) -> impl Word<u64>;
    /// When the gate was opened last, in ticks; written before it opens.
    fn opened_at(&self, phase: usize) -> impl Word<u64>;
    /// How many workers of a core group take part in the phase.
    fn group_members(&self, phase: usize, group: usize) -> impl Word<u32>;
    /// How many of them have arrived since the gate was opened. A hint: a worker that dies here is not counted.
    fn group_arrivals(&self, phase: usize, group: usize) -> impl Word<u32>;

    // Of a core group.
    /// Which gate is polled for the group, and until which step it opens; 0 if none is.
    fn polled(&self, group: usize) -> impl Word<u64>;
    /// Ticks for which a gate may be polled; 0: no worker polls.
    fn polling_limit(&self) -> impl Word<u64>;

    // Of a worker.
    /// The core group it belongs to.
    fn group(&self, worker: usize) -> impl Word<u32>;
    /// 1 if the process of the worker is to end and leave its place to another one.
    fn dismissed(&self, worker: usize) -> impl Word<u32>;

    /// Ticks within which a worker that yields its core must get it back; 0: no worker yields.
    fn yield_limit(&self) -> impl Word<u64>;

    /// The clock, in ticks.
    fn now(&self) -> u64;
    /// Lets another process of this core run.
    fn yield_core(&self);

    /// Sleeps while the word of `point` shows `value`, until one of `groups` is woken there. A process with `patience` is woken
    /// with every group and sleeps no longer than that. May return at any time.
    fn sleep_while(&self, point: WaitPoint, value: u32, groups: NonZeroU32, patience: Option<Duration>);
    /// Wakes the processes of some core groups, as bits, that sleep at `point`, whose word was changed before.
    fn wake(&self, point: WaitPoint, groups: u32);
    /// Whether core groups can be woken one by one.
    fn wakes_groups(&self) -> bool;
}
