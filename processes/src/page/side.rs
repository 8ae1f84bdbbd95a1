//! Sides: the cores that a run is spread over, and who watches for whom.
//!
//! Waking a process on another core takes many times as long as on the same one, most of it until a core that has gone to
//! sleep is awake. So a core with workers does not go to sleep: the last worker of a side that arrives in a phase watches for
//! the others. It looks at the next gate at which its side has workers until that opens, and then wakes them; whoever opens the
//! gate wakes its own side only. A watch is short: after some ticks the watcher sleeps like everybody else, and its side is
//! woken by whoever opens the gate.
//!
//! Nobody is forgotten in between. Who opens a gate first opens it and then looks whether a side has a watcher for this very
//! gate; a watcher first says that it watches no more and then looks at the gate. So at least one of them wakes the side. All
//! else here is a hint: a side that nobody watches is woken from afar, which takes longer, no more.

use std::num::NonZeroU32;
use std::sync::atomic::{
    AtomicU32, AtomicU64,
    Ordering::{Relaxed, SeqCst},
};

use super::spot::Spot;
use super::wake::EVERYBODY;
use super::{Page, STOP, released};
use crate::ticks;

/// Most sides of a run; cores beyond that share one.
pub(crate) const SIDES: usize = 8;
/// Looks at a gate between two looks at the clock.
const LOOKS: u32 = 16;

/// A core with workers.
#[repr(C, align(128))]
pub(super) struct Side {
    /// Which gate is watched for it, and until which step it opens ([`Target::word`]); 0 if none is.
    watched: AtomicU64,
}

/// The workers of a side in a phase.
#[repr(C)]
pub(super) struct Share {
    /// How many there are.
    pub(super) members: AtomicU32,
    /// How many have arrived since the gate was opened. A hint: who dies at it is not counted.
    arrived: AtomicU32,
}

/// A gate that a watcher looks at.
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

/// The conductor's side of it.
impl Page {
    /// Puts every worker on a side, by number. Nobody watches before [`Page::watch`] is called, which must not be before
    /// two more steps are complete: who sleeps now was put to sleep as a worker of its old side.
    pub(crate) fn take_sides(&self, places: &[Vec<(usize, usize)>], sides: &[usize]) {
        self.watch(0);
        for phase in 0..self.phases {
            let members = |side: usize| {
                let is_member = |worker: &usize| places[*worker].iter().any(|&(at, _)| at == phase);
                (0..self.workers).filter(|worker| is_member(worker) && sides[*worker] % SIDES == side).count() as u32
            };
            let shares = self.phase(phase).shares.iter().enumerate();
            shares.for_each(|(side, share)| share.members.store(members(side), SeqCst));
        }
        (0..self.workers).for_each(|worker| self.slot(worker).side.store((sides[worker] % SIDES) as u32, SeqCst));
    }

    /// From now on, sides are watched for so many ticks at a time; with 0, not at all.
    ///
    /// Events wake all who listen, whatever their side: a watcher would only be one more process that does not sleep.
    pub(crate) fn watch(&self, ticks: u64) {
        let ticks = if self.wakes_by_sides() { ticks } else { 0 };
        self.head().changes.watching.store(ticks, SeqCst);
    }

    /// Ends every watch and wakes all who wait for it: those of a watcher that is dead, or stands still.
    pub(crate) fn relieve(&self) {
        self.head().sides.iter().for_each(|side| side.watched.store(0, SeqCst));
        for phase in 0..self.phases {
            self.wake(Spot::Gate(phase), EVERYBODY);
        }
    }
}

/// The workers' side of it.
impl Page {
    /// Sleeps until the gate of a phase shows something else than `value`, or somebody wakes the worker's side.
    pub(super) fn sleep_at(&self, worker: usize, phase: usize, value: u32) {
        let side = NonZeroU32::new(1 << self.side_of(worker)).unwrap_or(NonZeroU32::MAX);
        self.sleep_while(Spot::Gate(phase), value, side, None);
    }

    /// The side of a worker; one that there may be, whatever stands on the page.
    fn side_of(&self, worker: usize) -> usize {
        self.slot(worker).side.load(SeqCst) as usize % SIDES
    }

    /// Forgets who has arrived in a phase before it is opened.
    pub(super) fn clear_shares(&self, phase: usize) {
        if self.head().changes.watching.load(Relaxed) != 0 {
            self.phase(phase).shares.iter().for_each(|share| share.arrived.store(0, Relaxed));
        }
    }

    /// Counts a worker that is about to arrive; `true` if it is the last of its side in this phase.
    pub(super) fn is_last_of_side(&self, worker: usize, phase: usize) -> bool {
        if self.head().changes.watching.load(Relaxed) == 0 {
            return false;
        }
        let side = self.side_of(worker);
        let share = &self.phase(phase).shares[side];
        share.arrived.fetch_add(1, Relaxed) + 1 == share.members.load(Relaxed)
    }

    /// Wakes those who sleep at the gate of a phase, which was opened for `step` by a worker, or by the conductor (`None`): the opener's side, and those
    /// that nobody watches.
    pub(super) fn wake_sides(&self, phase: usize, step: u64, opener: Option<usize>) {
        let place = self.phase(phase);
        if self.head().changes.watching.load(SeqCst) == 0 {
            return self.wake(Spot::Gate(phase), EVERYBODY);
        }
        let own = opener.map(|worker| self.side_of(worker));
        let opened = Target { phase, step }.word();
        let mut bits = 0;
        for (number, (side, share)) in self.head().sides.iter().zip(&place.shares).enumerate() {
            let is_here = share.members.load(Relaxed) > 0;
            if is_here && (own == Some(number) || side.watched.load(SeqCst) != opened) {
                bits |= 1 << number;
            }
        }
        self.wake(Spot::Gate(phase), bits);
    }

    /// Watches for the side of a worker that was the last of it to arrive in `phase` of `step`.
    #[cold]
    pub(super) fn keep_watch(&self, worker: usize, phase: usize, step: u64) {
        let limit = self.head().changes.watching.load(Relaxed);
        let number = self.side_of(worker);
        let Some(target) = self.next_gate(number, phase, step) else { return };
        let (side, gate) = (&self.head().sides[number], &self.phase(target.phase).gate);
        if limit == 0 || side.watched.compare_exchange(0, target.word(), SeqCst, SeqCst).is_err() {
            return;
        }
        let has_opened = || {
            let value = gate.load(SeqCst);
            value & STOP != 0 || value == released(target.step)
        };
        let start = ticks::now();
        while !has_opened() && ticks::now().saturating_sub(start) < limit {
            (0..LOOKS).for_each(|_| std::hint::spin_loop());
        }
        // Whoever opens it from now on wakes this side; who has opened it before may have relied on the watcher.
        side.watched.store(0, SeqCst);
        if has_opened() {
            self.wake(Spot::Gate(target.phase), 1 << number);
        }
    }

    /// The next gate behind `phase` of `step` at which a side has workers.
    fn next_gate(&self, side: usize, phase: usize, step: u64) -> Option<Target> {
        let behind = (phase + 1..self.phases).map(|phase| Target { phase, step });
        let next = (0..=phase).map(|phase| Target { phase, step: step + 1 });
        behind.chain(next).find(|target| self.phase(target.phase).shares[side].members.load(Relaxed) > 0)
    }
}
