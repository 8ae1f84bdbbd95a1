//! Holding, stepping and ending a run from outside its loop: from a signal, a key, or another terminal.

mod client;
mod keys;
mod message;
mod pace;
mod server;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

use processes::Interrupt;

use crate::run::swap::Swap;

pub use crate::unanswered::Unanswered;
pub(crate) use client::ask;
pub(crate) use keys::Keys;
pub(crate) use message::{Request, State, Status, WorkerStatus};
pub use pace::Pacing;
pub(crate) use pace::{Pace, Start, TooLate};
pub(crate) use server::{About, Server};

/// What becomes of a swap for which the run has no step left.
const ENDED: &str = "the run ended before; nothing was changed";

/// Ends, holds and steps a run from other threads.
#[derive(Clone)]
pub struct RunControl {
    shared: Arc<Shared>,
}

struct Shared {
    /// Whether the loop has to look at the rest before its next step.
    attention: AtomicBool,
    stopped: AtomicBool,
    /// Whether the end was requested as an emergency.
    emergency: AtomicBool,
    /// Ends a step that waits for a process; `None` before the processes have started.
    interrupt: OnceLock<Interrupt>,
    step: AtomicU64,
    state: Mutex<LoopState>,
    changed: Condvar,
    swaps: Mutex<VecDeque<SwapRequest>>,
    /// Whether a swap is being carried out.
    swapping: AtomicBool,
    /// Whether the run has begun with its steps, and whether its log is closed.
    underway: AtomicBool,
    closed: AtomicBool,
}

/// What is done with the result of a swap: the step from which on the program plays, or why it does not.
type Reply = Box<dyn FnOnce(Result<u64, String>) + Send>;

/// Another program is to play a participant from now on. Dropped without an answer, it answers that the run has ended.
pub(crate) struct SwapRequest {
    pub(crate) swap: Swap,
    reply: Option<Reply>,
    /// Set once it is being carried out.
    shared: Option<Arc<Shared>>,
}

impl SwapRequest {
    /// Reports from which step on the program plays, or why it does not.
    pub(crate) fn answer(mut self, result: Result<u64, String>) {
        self.conclude(result);
    }

    fn conclude(&mut self, result: Result<u64, String>) {
        if let Some(shared) = self.shared.take() {
            shared.swapping.store(false, Ordering::SeqCst);
        }
        if let Some(reply) = self.reply.take() {
            reply(result);
        }
    }
}

impl Drop for SwapRequest {
    fn drop(&mut self) {
        self.conclude(Err(ENDED.into()));
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct LoopState {
    paused: bool,
    /// Steps that a paused run may still do.
    allowed: u64,
    /// Whether there are requests for swaps.
    swaps: bool,
}

impl RunControl {
    pub(crate) fn new() -> Self {
        let shared = Shared {
            attention: AtomicBool::new(false),
            stopped: AtomicBool::new(false),
            emergency: AtomicBool::new(false),
            interrupt: OnceLock::new(),
            step: AtomicU64::new(0),
            state: Mutex::new(LoopState::default()),
            changed: Condvar::new(),
            swaps: Mutex::new(VecDeque::new()),
            swapping: AtomicBool::new(false),
            underway: AtomicBool::new(false),
            closed: AtomicBool::new(false),
        };
        Self { shared: Arc::new(shared) }
    }

    /// From now on a request ends a step in progress, too.
    pub(crate) fn attach(&self, interrupt: Interrupt) {
        // A run has one conductor; a second one would be ended by its own.
        let interrupt = self.shared.interrupt.get_or_init(|| interrupt);
        if self.is_requested() {
            interrupt.raise();
        }
    }

    /// Makes the current or the next step return as interrupted.
    pub fn request(&self) {
        self.shared.stopped.store(true, Ordering::SeqCst);
        if let Some(interrupt) = self.shared.interrupt.get() {
            interrupt.raise();
        }
        self.change(|_| {});
    }

    /// Ends the run because of an emergency. It ends as by [`RunControl::request`], which stops all robots, too; but as a failure.
    pub fn emergency(&self) {
        self.shared.emergency.store(true, Ordering::SeqCst);
        self.request();
    }

    /// Whether the end was requested as an emergency.
    pub fn is_emergency(&self) -> bool {
        self.shared.emergency.load(Ordering::SeqCst)
    }

    /// Whether the end was requested.
    pub fn is_requested(&self) -> bool {
        self.shared.stopped.load(Ordering::SeqCst)
    }

    /// The run begins with its steps.
    pub(crate) fn note_start(&self) {
        self.shared.underway.store(true, Ordering::SeqCst);
    }

    /// The processes have ended, and the log is closed.
    pub(crate) fn note_end(&self) {
        self.shared.closed.store(true, Ordering::SeqCst);
    }

    /// Whether the process may end at any time: nothing is recorded yet, or all of it is in the closed log.
    pub(crate) fn may_be_abandoned(&self) -> bool {
        !self.shared.underway.load(Ordering::SeqCst) || self.shared.closed.load(Ordering::SeqCst)
    }

    /// Holds the run before its next step.
    pub fn pause(&self) {
        self.change(|state| (state.paused, state.allowed) = (true, 0));
    }

    /// Lets a paused run go on.
    pub fn resume(&self) {
        self.change(|state| (state.paused, state.allowed) = (false, 0));
    }

    /// Lets the run do so many steps more and holds it then.
    pub fn advance(&self, steps: u64) {
        self.change(|state| (state.paused, state.allowed) = (true, state.allowed.saturating_add(steps)));
    }

    /// Whether the run is held.
    pub fn is_paused(&self) -> bool {
        self.state().paused
    }

    /// Whether the run is to be held or changed before its next step.
    pub(crate) fn wants_attention(&self) -> bool {
        self.shared.attention.load(Ordering::Relaxed)
    }

    /// Number of steps that are done.
    pub fn steps_done(&self) -> u64 {
        self.shared.step.load(Ordering::Relaxed)
    }

    /// Waits until the next step may run; returns whether it had to wait. Also returns when the end is requested.
    pub(crate) fn await_turn(&self, step: u64) -> bool {
        self.shared.step.store(step, Ordering::Relaxed);
        // The only cost of pausing to a run that is not paused.
        self.shared.attention.load(Ordering::Relaxed) && self.take_turn()
    }

    #[cold]
    fn take_turn(&self) -> bool {
        let mut state = self.state();
        let mut waited = false;
        while state.paused && state.allowed == 0 && !state.swaps && !self.is_requested() {
            waited = true;
            state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if !state.swaps {
            state.allowed = state.allowed.saturating_sub(1);
        }
        waited
    }

    /// Sleeps; `false` if the run is to be held or ended before `patience` is over.
    pub(crate) fn sleep(&self, patience: std::time::Duration) -> bool {
        let state = self.state();
        let calm = |state: &mut LoopState| !state.paused && !self.is_requested();
        let waited = self.shared.changed.wait_timeout_while(state, patience, calm);
        waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// Asks for a swap before the next step; `reply` gets its result, from any thread. A run whose end was requested
    /// carries none out.
    pub(crate) fn swap(&self, swap: Swap, reply: impl FnOnce(Result<u64, String>) + Send + 'static) {
        let request = SwapRequest { swap, reply: Some(Box::new(reply)), shared: None };
        if self.is_requested() {
            return drop(request);
        }
        self.swaps().push_back(request);
        self.change(|state| state.swaps = true);
    }

    /// The swap that is to be done next, if there is any.
    pub(crate) fn next_swap(&self) -> Option<SwapRequest> {
        if !self.shared.attention.load(Ordering::Relaxed) {
            return None;
        }
        if self.is_requested() {
            self.refuse_swaps();
            return None;
        }
        let mut next = self.swaps().pop_front();
        self.change(|state| state.swaps = !self.swaps().is_empty());
        if let Some(request) = &mut next {
            self.shared.swapping.store(true, Ordering::SeqCst);
            request.shared = Some(self.shared.clone());
        }
        next
    }

    /// Whether a swap is being carried out.
    pub(crate) fn is_swapping(&self) -> bool {
        self.shared.swapping.load(Ordering::SeqCst)
    }

    /// Answers all swaps that were asked for and not begun: the run has no step left for them.
    pub(crate) fn refuse_swaps(&self) {
        let pending = std::mem::take(&mut *self.swaps());
        self.change(|state| state.swaps = false);
        drop(pending);
    }

    fn swaps(&self) -> MutexGuard<'_, VecDeque<SwapRequest>> {
        self.shared.swaps.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut LoopState)) {
        let mut state = self.state();
        change(&mut state);
        self.shared.attention.store(state.paused || state.swaps, Ordering::SeqCst);
        self.shared.changed.notify_all();
    }

    fn state(&self) -> MutexGuard<'_, LoopState> {
        // Nothing is left half-done by a panic in between.
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_paused_run_does_the_steps_that_it_is_allowed() {
        let stop = RunControl::new();
        assert!(!stop.await_turn(0));
        stop.advance(2);
        assert!(!stop.await_turn(1) && !stop.await_turn(2));
        let other = stop.clone();
        let waiting = std::thread::spawn(move || other.await_turn(3));
        std::thread::sleep(Duration::from_millis(20));
        assert!(!waiting.is_finished(), "it went on");
        assert_eq!(stop.steps_done(), 3);
        stop.resume();
        assert!(waiting.join().unwrap());
        assert!(!stop.is_paused());
    }

    #[test]
    fn a_stop_ends_a_pause() {
        let stop = RunControl::new();
        stop.pause();
        let other = stop.clone();
        let waiting = std::thread::spawn(move || other.await_turn(0));
        stop.request();
        waiting.join().unwrap();
        assert!(stop.is_requested());
    }

    #[test]
    fn a_swap_that_comes_too_late_is_refused() {
        let (sender, results) = std::sync::mpsc::channel();
        let stop = RunControl::new();
        let ask = |stop: &RunControl| {
            let sender = sender.clone();
            let swap = Swap::parse("plant=./mine", &["plant"]).unwrap();
            stop.swap(swap, move |result| sender.send(result).unwrap());
        };
        ask(&stop);
        assert!(results.try_recv().is_err() && !stop.is_swapping());
        let request = stop.next_swap().expect("a swap");
        assert!(stop.is_swapping());
        request.answer(Ok(7));
        assert_eq!(results.try_recv(), Ok(Ok(7)));
        assert!(!stop.is_swapping());
        ask(&stop);
        stop.request();
        assert!(stop.next_swap().is_none());
        assert_eq!(results.try_recv(), Ok(Err(ENDED.into())));
        ask(&stop);
        assert_eq!(results.try_recv(), Ok(Err(ENDED.into())));
    }

    #[test]
    fn a_sleep_ends_early_for_a_pause() {
        let stop = RunControl::new();
        assert!(stop.sleep(Duration::from_millis(1)));
        stop.pause();
        assert!(!stop.sleep(Duration::from_secs(60)));
    }
}
