//! Core groups: the workers that share a core, and which of them polls for the others.
//!
//! Waking a process on another core takes many times as long as on the same one, most of it until a core that has gone to
//! sleep is awake. So a core with workers does not go to sleep: the last worker of a group that arrives in a phase polls for
//! its group. It reads the next gate at which the group has workers again and again until that opens, and then wakes them; the
//! process that opens the gate wakes its own group only. Polling is short: after some ticks the worker sleeps like all others,
//! and its group is woken by the process that opens the gate.
//!
//! No group is forgotten in between. A process that opens a gate first opens it and then looks whether a group is polled for
//! at this very gate; a worker that polls first says that it polls no more and then looks at the gate. So at least one of them
//! wakes the group. All else here is a hint: a group for which no worker polls is woken from another core, which takes longer,
//! no more.

use std::num::NonZeroU32;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};

use super::memory::{EVERY_GROUP, Memory, WaitPoint, Word};
use super::{Page, STOP, released};

/// Most core groups of a run; cores beyond that share one.
pub(crate) const CORE_GROUPS: usize = 8;
/// Looks at a gate between two looks at the clock.
const LOOKS: u32 = 16;

/// A gate that is polled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Target {
    phase: usize,
    step: u64,
}

impl Target {
    /// The target in a word that is not 0.
    fn word(self) -> u64 {
        (u64::from(released(self.step)) << 32) | (self.phase as u64 + 1)
    }
}

/// For the conductor.
impl<M: Memory> Page<M> {
    /// Puts every worker into a group, by number. No worker polls before [`Page::set_polling_limit`] is called, which must not
    /// be before two more steps are complete: a worker that sleeps now was put to sleep as one of its old group.
    pub(crate) fn set_groups(&self, places: &[Vec<(usize, usize)>], groups: &[usize]) {
        self.set_polling_limit(0);
        for phase in 0..self.memory.phase_count() {
            let members = |group: usize| {
                let is_member = |worker: usize| places[worker].iter().any(|&(at, _)| at == phase);
                let belongs = |&worker: &usize| is_member(worker) && groups[worker] % CORE_GROUPS == group;
                (0..self.memory.worker_count()).filter(belongs).count() as u32
            };
            (0..CORE_GROUPS).for_each(|group| self.memory.group_members(phase, group).store(members(group), SeqCst));
        }
        for (worker, group) in groups.iter().enumerate() {
            self.memory.group(worker).store((group % CORE_GROUPS) as u32, SeqCst);
        }
    }

    /// From now on, gates are polled for so many ticks at a time; with 0, not at all.
    ///
    /// Events wake all that listen, whatever their group: a worker that polls would only be one more process that does not
    /// sleep.
    pub(crate) fn set_polling_limit(&self, ticks: u64) {
        let ticks = if self.memory.wakes_groups() { ticks } else { 0 };
        self.memory.polling_limit().store(ticks, SeqCst);
    }

    /// Forgets which groups are polled for and wakes all workers: the one that polls may be dead or stopped.
    pub(crate) fn end_polling(&self) {
        (0..CORE_GROUPS).for_each(|group| self.memory.polled(group).store(0, SeqCst));
        for phase in 0..self.memory.phase_count() {
            self.memory.wake(WaitPoint::Gate(phase), EVERY_GROUP);
        }
    }
}

/// For the workers.
impl<M: Memory> Page<M> {
    /// Sleeps until the gate of a phase shows something else than `value`, or the worker's group is woken.
    pub(super) fn sleep_at_gate(&self, worker: usize, phase: usize, value: u32) {
        let group = NonZeroU32::new(1 << self.group_of(worker)).unwrap_or(NonZeroU32::MAX);
        self.memory.sleep_while(WaitPoint::Gate(phase), value, group, None);
    }

    /// The group of a worker; a valid one, even if the page was overwritten.
    fn group_of(&self, worker: usize) -> usize {
        self.memory.group(worker).load(SeqCst) as usize % CORE_GROUPS
    }

    /// Forgets which workers have arrived in a phase before it is opened.
    pub(super) fn clear_group_arrivals(&self, phase: usize) {
        if self.memory.polling_limit().load(Relaxed) != 0 {
            (0..CORE_GROUPS).for_each(|group| self.memory.group_arrivals(phase, group).store(0, Relaxed));
        }
    }

    /// Counts a worker that is about to arrive; `true` if it is the last of its group in this phase.
    pub(super) fn is_last_of_group(&self, worker: usize, phase: usize) -> bool {
        if self.memory.polling_limit().load(Relaxed) == 0 {
            return false;
        }
        let group = self.group_of(worker);
        let arrived = self.memory.group_arrivals(phase, group).fetch_add(1, Relaxed) + 1;
        arrived == self.memory.group_members(phase, group).load(Relaxed)
    }

    /// Wakes the processes that sleep at the gate of a phase, which was opened for `step` by a worker, or by the conductor
    /// (`None`): the opener's group, and those for which no worker polls.
    pub(super) fn wake_groups(&self, phase: usize, step: u64, opener: Option<usize>) {
        if self.memory.polling_limit().load(SeqCst) == 0 {
            return self.memory.wake(WaitPoint::Gate(phase), EVERY_GROUP);
        }
        let own = opener.map(|worker| self.group_of(worker));
        let opened = Target { phase, step }.word();
        let mut bits = 0;
        for group in 0..CORE_GROUPS {
            let is_here = self.memory.group_members(phase, group).load(Relaxed) > 0;
            if is_here && (own == Some(group) || self.memory.polled(group).load(SeqCst) != opened) {
                bits |= 1 << group;
            }
        }
        self.memory.wake(WaitPoint::Gate(phase), bits);
    }

    /// Polls for the group of a worker that was the last of it to arrive in `phase` of `step`.
    #[cold]
    pub(crate) fn poll_next_gate(&self, worker: usize, phase: usize, step: u64) {
        let limit = self.memory.polling_limit().load(Relaxed);
        let group = self.group_of(worker);
        let Some(target) = self.next_gate(group, phase, step) else { return };
        if limit == 0 || !self.memory.polled(group).replace(0, target.word()) {
            return;
        }
        let has_opened = || {
            let value = self.memory.gate(target.phase).load(SeqCst);
            value & STOP != 0 || value == released(target.step)
        };
        let start = self.memory.now();
        while !has_opened() && self.memory.now().saturating_sub(start) < limit {
            (0..LOOKS).for_each(|_| std::hint::spin_loop());
        }
        // A process that opens the gate from now on wakes this group; one that has opened it before may have relied on this
        // worker. Hence the look after the word is cleared.
        self.memory.polled(group).store(0, SeqCst);
        if has_opened() {
            self.memory.wake(WaitPoint::Gate(target.phase), 1 << group);
        }
    }

    /// The next gate behind `phase` of `step` at which a group has workers.
    fn next_gate(&self, group: usize, phase: usize, step: u64) -> Option<Target> {
        let behind = (phase + 1..self.memory.phase_count()).map(|phase| Target { phase, step });
        let next = (0..=phase).map(|phase| Target { phase, step: step + 1 });
        behind.chain(next).find(|target| self.memory.group_members(target.phase, group).load(Relaxed) > 0)
    }
}
