//! Holding, stepping and ending a run from outside its loop: from a signal, a key, or another terminal.

mod keys;
mod pace;
mod server;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

use processes::Interrupt;

use crate::run::swap::Swap;

pub(crate) use keys::Keys;
pub use pace::Pacing;
pub(crate) use pace::{Pace, Start};
pub(crate) use server::{About, FOLDER_MARK, SOCKET, SWAP_PATIENCE, Server};

/// Ends, holds and steps a run from other threads.
#[derive(Clone)]
pub struct Stop {
    shared: Arc<Shared>,
}

struct Shared {
    /// Whether the loop has to look at the rest before its next step.
    attention: AtomicBool,
    stopped: AtomicBool,
    /// Whether the end was requested as an emergency.
    emergency: AtomicBool,
    /// Ends a step that waits for a process; there is none before the processes are there.
    interrupt: OnceLock<Interrupt>,
    step: AtomicU64,
    turn: Mutex<Turn>,
    changed: Condvar,
    swaps: Mutex<VecDeque<SwapRequest>>,
}

/// Somebody wants a program of his own to play a participant from now on.
pub(crate) struct SwapRequest {
    pub(crate) swap: Swap,
    answer: SyncSender<Result<u64, String>>,
}

impl SwapRequest {
    /// Tells from which step on the program plays, or why it does not.
    pub(crate) fn answer(&self, answer: Result<u64, String>) {
        // Whoever asked may have gone.
        let _ = self.answer.try_send(answer);
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Turn {
    paused: bool,
    /// Steps that a paused run may still do.
    allowed: u64,
    /// Whether there are requests for swaps.
    swaps: bool,
}

impl Stop {
    pub(crate) fn new() -> Self {
        let shared = Shared {
            attention: AtomicBool::new(false),
            stopped: AtomicBool::new(false),
            emergency: AtomicBool::new(false),
            interrupt: OnceLock::new(),
            step: AtomicU64::new(0),
            turn: Mutex::new(Turn::default()),
            changed: Condvar::new(),
            swaps: Mutex::new(VecDeque::new()),
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

    /// Ends the run because of an emergency. It ends as by [`Stop::request`], which stops all robots, too; but as a failure.
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

    /// Holds the run before its next step.
    pub fn pause(&self) {
        self.change(|turn| (turn.paused, turn.allowed) = (true, 0));
    }

    /// Lets a paused run go on.
    pub fn resume(&self) {
        self.change(|turn| (turn.paused, turn.allowed) = (false, 0));
    }

    /// Lets the run do so many steps more and holds it then.
    pub fn advance(&self, steps: u64) {
        self.change(|turn| (turn.paused, turn.allowed) = (true, turn.allowed.saturating_add(steps)));
    }

    /// Whether the run is held.
    pub fn is_paused(&self) -> bool {
        self.turn().paused
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
        // The only cost of all this to a run that nobody holds.
        self.shared.attention.load(Ordering::Relaxed) && self.take_turn()
    }

    #[cold]
    fn take_turn(&self) -> bool {
        let mut turn = self.turn();
        let mut waited = false;
        while turn.paused && turn.allowed == 0 && !turn.swaps && !self.is_requested() {
            waited = true;
            turn = self.shared.changed.wait(turn).unwrap_or_else(PoisonError::into_inner);
        }
        if !turn.swaps {
            turn.allowed = turn.allowed.saturating_sub(1);
        }
        waited
    }

    /// Sleeps; `false` if the run is to be held or ended before `patience` is over.
    pub(crate) fn sleep(&self, patience: std::time::Duration) -> bool {
        let turn = self.turn();
        let calm = |turn: &mut Turn| !turn.paused && !self.is_requested();
        let waited = self.shared.changed.wait_timeout_while(turn, patience, calm);
        waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// Asks for a swap before the next step; the answer comes when it is done.
    pub(crate) fn swap(&self, swap: Swap) -> Receiver<Result<u64, String>> {
        let (answer, answered) = sync_channel(1);
        self.swaps().push_back(SwapRequest { swap, answer });
        self.change(|turn| turn.swaps = true);
        answered
    }

    /// The swap that is to be done next, if there is any.
    pub(crate) fn next_swap(&self) -> Option<SwapRequest> {
        if !self.shared.attention.load(Ordering::Relaxed) {
            return None;
        }
        let next = self.swaps().pop_front();
        self.change(|turn| turn.swaps = !self.swaps().is_empty());
        next
    }

    fn swaps(&self) -> MutexGuard<'_, VecDeque<SwapRequest>> {
        self.shared.swaps.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Turn)) {
        let mut turn = self.turn();
        change(&mut turn);
        self.shared.attention.store(turn.paused || turn.swaps, Ordering::SeqCst);
        self.shared.changed.notify_all();
    }

    fn turn(&self) -> MutexGuard<'_, Turn> {
        // Nothing is left half-done by a panic in between.
        self.shared.turn.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_paused_run_does_the_steps_that_it_is_allowed() {
        let stop = Stop::new();
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
        let stop = Stop::new();
        stop.pause();
        let other = stop.clone();
        let waiting = std::thread::spawn(move || other.await_turn(0));
        stop.request();
        waiting.join().unwrap();
        assert!(stop.is_requested());
    }

    #[test]
    fn a_sleep_ends_early_for_a_pause() {
        let stop = Stop::new();
        assert!(stop.sleep(Duration::from_millis(1)));
        stop.pause();
        assert!(!stop.sleep(Duration::from_secs(60)));
    }
}
