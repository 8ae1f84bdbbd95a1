//! Times and counts of the workers: how long each computes and waits, and on which the others wait. Never part of a result.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::Page;
use crate::ticks;

/// A worker's counters; only the worker writes them. In ticks, but for `runs` and `last`.
#[repr(C, align(128))]
pub(super) struct Counters {
    pub(super) runs: AtomicU64,
    /// From its start to its arrival.
    pub(super) compute: AtomicU64,
    /// From the opening of its gate to its start.
    pub(super) wake: AtomicU64,
    /// From its arrival to the opening of its next gate.
    pub(super) wait: AtomicU64,
    /// How often it was the last of its phase.
    pub(super) last: AtomicU64,
    /// When it passed a gate last.
    pub(super) started: AtomicU64,
}

/// A run of a worker, for a trace.
#[repr(C)]
pub(super) struct Event {
    /// Step, and phase in the highest 16 bits.
    place: AtomicU64,
    start: AtomicU64,
    end: AtomicU64,
}

/// One run of a worker in a phase, in ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) step: u64,
    pub(crate) phase: usize,
    pub(crate) start: u64,
    pub(crate) end: u64,
}

/// Counters of a worker as another process reads them, in ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) runs: u64,
    pub(crate) compute: u64,
    pub(crate) wake: u64,
    pub(crate) wait: u64,
    pub(crate) last: u64,
}

/// A worker's stopwatch. It sums up by itself, so that nothing is read back from the page.
pub(crate) struct Stopwatch {
    worker: usize,
    counts: Counts,
    /// When its gate was opened last.
    opened: u64,
    /// When it arrived last.
    arrived: Option<u64>,
}

impl Stopwatch {
    /// Goes on from what earlier processes of the worker have counted.
    pub(crate) fn new(worker: usize, page: &Page) -> Self {
        Self { worker, counts: page.counts(worker), opened: 0, arrived: None }
    }

    /// The worker has passed the gate of `phase`; returns the time.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn start(&mut self, page: &Page, phase: usize) -> u64 {
        let now = ticks::now();
        page.memory.counters(self.worker).started.store(now, Relaxed);
        self.opened = page.memory.phase(phase).opened_at.load(Relaxed);
        self.counts.wake += now.saturating_sub(self.opened);
        // Another gate may have opened before the worker was done with the one before.
        self.counts.wait += self.arrived.map_or(0, |arrived| self.opened.saturating_sub(arrived));
        now
    }

    /// The worker is done with `phase` of `step` and is about to arrive; returns the time.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn end(&mut self, page: &Page, phase: usize, step: u64, start: u64) -> u64 {
        let end = ticks::now();
        if let Some(event) = page.memory.event(self.worker, self.counts.runs) {
            event.place.store(step | (phase as u64) << 48, Relaxed);
            event.start.store(start, Relaxed);
            event.end.store(end, Relaxed);
        }
        self.counts.runs += 1;
        self.counts.compute += end.saturating_sub(start);
        self.arrived = Some(end);
        let counters = page.memory.counters(self.worker);
        counters.compute.store(self.counts.compute, Relaxed);
        counters.wake.store(self.counts.wake, Relaxed);
        counters.wait.store(self.counts.wait, Relaxed);
        counters.runs.store(self.counts.runs, Relaxed);
        end
    }

    /// The worker has arrived; `last` if all others had before.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn arrived(&mut self, page: &Page, phase: usize, end: u64, last: bool) {
        if last {
            self.counts.last += 1;
            page.memory.counters(self.worker).last.store(self.counts.last, Relaxed);
            page.memory.phase(phase).lasted.fetch_add(end.saturating_sub(self.opened), Relaxed);
        }
    }
}

impl Page {
    /// The counters of a worker.
    pub(crate) fn counts(&self, worker: usize) -> Counts {
        let counters = self.memory.counters(worker);
        Counts {
            runs: counters.runs.load(Relaxed),
            compute: counters.compute.load(Relaxed),
            wake: counters.wake.load(Relaxed),
            wait: counters.wait.load(Relaxed),
            last: counters.last.load(Relaxed),
        }
    }

    /// When the gate of a phase was opened last, and when a worker passed any gate last.
    pub(crate) fn opened_and_started(&self, phase: usize, worker: usize) -> (u64, u64) {
        (self.memory.phase(phase).opened_at.load(Relaxed), self.memory.counters(worker).started.load(Relaxed))
    }

    /// How long a phase has lasted in all steps together, in ticks.
    pub(crate) fn lasted(&self, phase: usize) -> u64 {
        self.memory.phase(phase).lasted.load(Relaxed)
    }

    /// The last runs of a worker, oldest first, as far as the plan has them traced.
    pub(crate) fn runs(&self, worker: usize) -> Vec<Run> {
        let count = self.counts(worker).runs;
        let first = count.saturating_sub(self.memory.traced as u64);
        let run = |event: &Event| {
            let place = event.place.load(Relaxed);
            Run {
                step: place & ((1 << 48) - 1),
                phase: (place >> 48) as usize,
                start: event.start.load(Relaxed),
                end: event.end.load(Relaxed),
            }
        };
        (first..count).filter_map(|number| self.memory.event(worker, number)).map(run).collect()
    }
}
