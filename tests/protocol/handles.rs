//! The memory as the protocol sees it.

use std::num::NonZeroU32;
use std::sync::atomic::Ordering;
use std::time::Duration;

use crate::memory::Moves;
use crate::protocol::{Memory, WaitPoint, Word};
use crate::words::{GROUPS, Name};

/// A word as the protocol gets it.
#[derive(Clone, Copy)]
pub(crate) enum Handle<'m, 'a> {
    Word(&'m Moves<'a>, Name),
    /// It stays as it is in the whole run, or does not matter.
    Constant(u64),
    /// Counts the members of a group that have arrived, of so many; the count may be wrong.
    Hint(&'m Moves<'a>, u64),
}

impl<T: Into<u64> + TryFrom<u64>> Word<T> for Handle<'_, '_> {
    fn load(&self, _: Ordering) -> T {
        value(match *self {
            Self::Word(memory, name) => memory.load(name),
            Self::Constant(value) => value,
            Self::Hint(..) => unreachable!("hints are only counted"),
        })
    }

    fn store(&self, value: T, _: Ordering) {
        if let Self::Word(memory, name) = *self {
            memory.store(name, value.into());
        }
    }

    fn replace(&self, current: T, new: T) -> bool {
        let Self::Word(memory, name) = *self else { unreachable!("a constant is not replaced") };
        memory.replace(name, current.into(), new.into())
    }

    fn fetch_add(&self, added: T, _: Ordering) -> T {
        value(match *self {
            Self::Word(memory, name) => memory.fetch_add(name, added.into()),
            Self::Constant(_) => unreachable!("a constant is not counted up"),
            Self::Hint(memory, members) => memory.count(members),
        })
    }

    fn fetch_or(&self, bits: T) -> T {
        let Self::Word(memory, name) = *self else { unreachable!("a constant has no bits to set") };
        value(memory.fetch_or(name, bits.into()))
    }
}

fn value<T: TryFrom<u64>>(value: u64) -> T {
    T::try_from(value).unwrap_or_else(|_| unreachable!("{value} comes from a word of this width"))
}

impl Memory for Moves<'_> {
    // Phases of one to three workers take one or two words.
    const WORKERS_PER_WORD: usize = 2;

    fn phase_count(&self) -> usize {
        self.run.sizes.len()
    }

    fn worker_count(&self) -> usize {
        self.run.conductor()
    }

    fn member_count(&self, phase: usize) -> usize {
        self.run.sizes[phase].into()
    }

    fn limit(&self) -> impl Word<u64> {
        self.word(Name::Limit)
    }

    fn completed(&self) -> impl Word<u64> {
        self.word(Name::Completed)
    }

    fn wake_at(&self) -> impl Word<u64> {
        self.word(Name::WakeAt)
    }

    fn completion_claim(&self) -> impl Word<u64> {
        self.word(Name::CompletionClaim)
    }

    fn bell(&self) -> impl Word<u32> {
        self.word(Name::Bell)
    }

    fn gate(&self, phase: usize) -> impl Word<u32> {
        self.word(Name::Gate(phase))
    }

    fn gate_claim(&self, phase: usize) -> impl Word<u64> {
        self.word(Name::GateClaim(phase))
    }

    fn arrivals(&self, phase: usize, word: usize) -> impl Word<u64> {
        self.word(Name::Arrivals(phase, word))
    }

    fn opened_at(&self, _: usize) -> impl Word<u64> {
        Handle::Constant(0)
    }

    fn group_members(&self, phase: usize, group: usize) -> impl Word<u32> {
        Handle::Constant(self.run.group_members(phase, group))
    }

    fn group_arrivals(&self, phase: usize, group: usize) -> impl Word<u32> {
        Handle::Hint(self, self.run.group_members(phase, group))
    }

    fn polled(&self, group: usize) -> impl Word<u64> {
        if group < GROUPS { self.word(Name::Polled(group)) } else { Handle::Constant(0) }
    }

    fn polling_limit(&self) -> impl Word<u64> {
        Handle::Constant(u64::from(!self.run.groups.is_empty()))
    }

    fn group(&self, worker: usize) -> impl Word<u32> {
        Handle::Constant(self.run.group(worker) as u64)
    }

    fn dismissed(&self, _: usize) -> impl Word<u32> {
        Handle::Constant(0)
    }

    fn yield_limit(&self) -> impl Word<u64> {
        Handle::Constant(0)
    }

    /// However often a gate was polled: it ends at some time.
    fn now(&self) -> u64 {
        self.looks_at_clock.replace(u64::MAX)
    }

    fn yield_core(&self) {}

    fn sleep_while(&self, point: WaitPoint, value: u32, groups: NonZeroU32, _: Option<Duration>) {
        Moves::sleep_while(self, point, value, groups.get() as u8);
    }

    fn wake(&self, point: WaitPoint, groups: u32) {
        Moves::wake(self, point, groups as u8);
    }

    fn wakes_groups(&self) -> bool {
        true
    }
}
