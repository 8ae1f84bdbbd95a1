//! The state of a run that its threads share: the page, which workers are dead, whether it is interrupted.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use crate::page::Page;
use crate::ticks::Rate;

/// The page of a run, and what is known about the run besides.
pub(super) struct RunStatus {
    pub(super) page: Page,
    /// What the times on the page mean.
    pub(super) rate: Rate,
    interrupted: AtomicBool,
    /// Whether any worker is dead, so that a look at all of them is rare.
    any_dead: AtomicBool,
    dead: Box<[AtomicBool]>,
}

/// Ends a run from another thread, such as that of a signal handler.
#[derive(Clone)]
pub struct Interrupt(pub(super) Arc<RunStatus>);

impl Interrupt {
    /// Makes the step in progress, or the next one, end with [`RunError::Interrupted`](crate::RunError::Interrupted) at once,
    /// and every worker end at its next gate. Needs nothing of the thread that runs the conductor: a bridge halts its robot
    /// even if that thread is busy.
    pub fn raise(&self) {
        // First: a thread that finds that a worker has ended finds the reason, too.
        self.0.interrupted.store(true, SeqCst);
        self.0.page.stop();
        self.0.page.ring();
    }
}

impl RunStatus {
    pub(super) fn new(page: Page, workers: usize) -> Self {
        let dead = (0..workers).map(|_| AtomicBool::new(false)).collect();
        Self { page, rate: Rate::start(), interrupted: AtomicBool::new(false), any_dead: AtomicBool::new(false), dead }
    }

    /// A worker is dead.
    pub(super) fn report_death(&self, worker: usize) {
        self.dead[worker].store(true, SeqCst);
        self.any_dead.store(true, SeqCst);
        self.page.ring();
    }

    /// The dead workers.
    pub(super) fn dead(&self) -> impl Iterator<Item = usize> {
        let count = if self.any_dead.load(SeqCst) { self.dead.len() } else { 0 };
        (0..count).filter(|&worker| self.is_dead(worker))
    }

    pub(super) fn is_dead(&self, worker: usize) -> bool {
        self.dead[worker].load(SeqCst)
    }

    /// Another process takes the place of a dead worker.
    pub(super) fn forget_death(&self, worker: usize) {
        self.dead[worker].store(false, SeqCst);
    }

    pub(super) fn is_interrupted(&self) -> bool {
        self.interrupted.load(SeqCst)
    }
}
