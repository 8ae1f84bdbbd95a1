//! Yielding a core before sleeping: switched on and off by the conductor, and off by a worker that waits too long for its core.

use std::sync::atomic::Ordering::Relaxed;

use super::Page;
use super::memory::{Memory, Word};

impl<M: Memory> Page<M> {
    /// From now on, a worker that waits yields its core once before it sleeps, as long as all get it back within so many ticks;
    /// with 0, it sleeps at once.
    pub(crate) fn set_yield_limit(&self, ticks: u64) {
        self.memory.yield_limit().store(ticks, Relaxed);
    }

    /// The limit that is in force.
    pub(crate) fn yield_limit(&self) -> u64 {
        self.memory.yield_limit().load(Relaxed)
    }

    /// Yields the core once, if that is wanted; `false` if it is not.
    ///
    /// Once per wait and not more often: a worker that finds its gate still closed then stands in the wrong order among those
    /// of its core, and is put in the right one by being woken when the gate opens. That holds for futexes and for events
    /// alike.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn yield_core(&self) -> bool {
        let limit = self.yield_limit();
        if limit == 0 {
            return false;
        }
        let start = self.memory.now();
        self.memory.yield_core();
        if self.memory.now().saturating_sub(start) > limit {
            // Another program takes the time that is yielded. The conductor will try again some time.
            self.set_yield_limit(0);
        }
        true
    }
}
