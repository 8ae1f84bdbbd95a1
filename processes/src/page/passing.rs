//! Handing a core on before sleeping: switched on and off by the conductor, and off by whoever waits too long for its core.

use std::sync::atomic::Ordering::Relaxed;

use rustix::thread::sched_yield;

use super::Page;
use crate::ticks;

impl Page {
    /// From now on, who waits hands its core on to the others once before it sleeps, as long as all get it back within so
    /// many ticks; with 0, who waits sleeps.
    pub(crate) fn pass_cores_on(&self, limit: u64) {
        self.head().changes.passing.store(limit, Relaxed);
    }

    /// The limit that is in force.
    pub(crate) fn passing_limit(&self) -> u64 {
        self.head().changes.passing.load(Relaxed)
    }

    /// Hands the core on once, if that is wanted; `false` if it is not.
    ///
    /// Once per wait and not more often: who finds its gate closed then stands in the wrong order among those of its core,
    /// and is put in the right one by being woken when the gate opens. That holds for futexes and for events alike.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn pass_core_on(&self) -> bool {
        let limit = self.passing_limit();
        if limit == 0 {
            return false;
        }
        let start = ticks::now();
        sched_yield();
        if ticks::now().saturating_sub(start) > limit {
            // Somebody else uses up what is handed on. The conductor will try again some time.
            self.pass_cores_on(0);
        }
        true
    }
}
