//! How processes sleep and wake each other: the one place that knows by what.
//!
//! All that matters stands in words of the page: a process that sleeps reads its word before and after, and a process that wakes
//! others changes the word first. So a sleep may end too early at any time, and a wake-up may be late; it only must not be lost
//! for ever.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};
use std::sync::{PoisonError, RwLock};
use std::time::Duration;

use lockstep::Wake;
use rustix::event::Timespec;
use rustix::thread::futex;

use super::events::{self, Events};
use super::protocol::WaitPoint;

/// As much of `base` as the name of a run may have, and a number behind it: paths of sockets are limited.
pub fn run_name(base: &str, wake: Wake) -> String {
    match wake {
        Wake::Futex => base.into(),
        Wake::Events => base.chars().take(events::longest_name()).collect(),
    }
}

/// The primitive behind sleeping and waking.
pub(super) enum Waker {
    Futex,
    /// Until this process has joined the events and after it has left them, it wakes no process, and sleeps as if every wake-up
    /// were lost. The conductor leaves them, since handles of a run that is over may keep its page.
    Events(RwLock<Option<Events>>),
}

impl From<Wake> for Waker {
    fn from(wake: Wake) -> Self {
        match wake {
            Wake::Futex => Self::Futex,
            Wake::Events => Self::Events(RwLock::new(None)),
        }
    }
}

impl Waker {
    /// From now on this process wakes others by `events` and is woken by them; with `None`, no longer.
    pub(super) fn use_events(&self, events: Option<Events>) {
        if let Self::Events(joined) = self {
            *joined.write().unwrap_or_else(PoisonError::into_inner) = events;
        }
    }

    /// Whether a part of the processes that sleep at a gate can be woken.
    pub(super) fn wakes_groups(&self) -> bool {
        matches!(self, Self::Futex)
    }

    /// See [`Memory::sleep_while`](super::protocol::Memory::sleep_while). `word` is the one of `point`.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn sleep_while(
        &self,
        word: &AtomicU32,
        point: WaitPoint,
        value: u32,
        groups: NonZeroU32,
        patience: Option<Duration>,
    ) {
        let flags = futex::Flags::empty();
        // What a wait returns does not matter: the caller reads the page again.
        match (self, patience) {
            (Self::Futex, None) => {
                let _ = futex::wait_bitset(word, flags, value, None, groups);
            }
            (Self::Futex, Some(patience)) => {
                let timeout = Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: patience.subsec_nanos().into() };
                let _ = futex::wait(word, flags, value, Some(&timeout));
            }
            (Self::Events(joined), _) if word.load(SeqCst) == value => wait(joined, point, patience),
            (Self::Events(_), _) => {}
        }
    }

    /// See [`Memory::wake`](super::protocol::Memory::wake). `word` is the one of `point`.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn wake(&self, word: &AtomicU32, point: WaitPoint, groups: u32) {
        let Some(groups) = NonZeroU32::new(groups) else { return };
        match self {
            Self::Futex => {
                let _ = futex::wake_bitset(word, futex::Flags::empty(), i32::MAX as u32, groups);
            }
            Self::Events(joined) => notify(joined, point),
        }
    }
}

/// Waits for an event, but not for long: it may be lost.
#[cold]
fn wait(joined: &RwLock<Option<Events>>, point: WaitPoint, patience: Option<Duration>) {
    let patience = patience.map_or(events::LOOK, |patience| patience.min(events::LOOK));
    match &*joined.read().unwrap_or_else(PoisonError::into_inner) {
        Some(events) => events.wait(point, patience),
        None => std::thread::sleep(patience),
    }
}

#[cold]
fn notify(joined: &RwLock<Option<Events>>, point: WaitPoint) {
    if let Some(events) = &*joined.read().unwrap_or_else(PoisonError::into_inner) {
        events.notify(point);
    }
}
