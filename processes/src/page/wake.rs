//! How processes sleep and wake each other: the one place that knows by what.
//!
//! All that matters stands in words of the page: whoever sleeps looks at its word first and after, and whoever wakes changes
//! the word first. So a sleep may end too early at any time, and a wake-up may be late; it only must not be lost for ever.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};
use std::sync::{PoisonError, RwLock};
use std::time::Duration;

use lockstep::Wake;
use rustix::event::Timespec;
use rustix::thread::futex;

use super::Page;
use super::events::{self, Events};
use super::spot::Spot;

/// Everybody who sleeps at a word, whatever the side.
pub(super) const EVERYBODY: u32 = u32::MAX;

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
    /// Until this process has joined the events and after it has left them, it wakes nobody, and sleeps as if every wake-up
    /// were lost. Left by the conductor, since handles of a run that is over may keep its page.
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

impl Page {
    /// From now on this process wakes others by `events` and is woken by them; with `None`, no longer.
    pub(crate) fn use_events(&self, events: Option<Events>) {
        if let Waker::Events(joined) = &self.waker {
            *joined.write().unwrap_or_else(PoisonError::into_inner) = events;
        }
    }

    /// Whether a part of those who sleep at a gate can be woken.
    pub(super) fn wakes_by_sides(&self) -> bool {
        matches!(self.waker, Waker::Futex)
    }

    /// Sleeps while a word shows `value`, until somebody wakes one of `sides`; whoever has `patience` belongs to all sides and
    /// sleeps no longer than that. May return at any time.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn sleep_while(&self, spot: Spot, value: u32, sides: NonZeroU32, patience: Option<Duration>) {
        let word = self.word(spot);
        let flags = futex::Flags::empty();
        // What a wait returns does not matter: the caller looks at the page again.
        match (&self.waker, patience) {
            (Waker::Futex, None) => {
                let _ = futex::wait_bitset(word, flags, value, None, sides);
            }
            (Waker::Futex, Some(patience)) => {
                let timeout = Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: patience.subsec_nanos().into() };
                let _ = futex::wait(word, flags, value, Some(&timeout));
            }
            (Waker::Events(joined), _) if word.load(SeqCst) == value => wait(joined, spot, patience),
            (Waker::Events(_), _) => {}
        }
    }

    /// Wakes those of some sides who sleep at a word, which was changed before.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn wake(&self, spot: Spot, sides: u32) {
        let Some(sides) = NonZeroU32::new(sides) else { return };
        match &self.waker {
            Waker::Futex => {
                let _ = futex::wake_bitset(self.word(spot), futex::Flags::empty(), i32::MAX as u32, sides);
            }
            Waker::Events(joined) => notify(joined, spot),
        }
    }

    fn word(&self, spot: Spot) -> &AtomicU32 {
        match spot {
            Spot::Bell => &self.head().bell,
            Spot::Gate(phase) => &self.phase(phase).gate,
        }
    }
}

/// Waits for an event, but not for long: it may be lost.
#[cold]
fn wait(joined: &RwLock<Option<Events>>, spot: Spot, patience: Option<Duration>) {
    let patience = patience.map_or(events::LOOK, |patience| patience.min(events::LOOK));
    match &*joined.read().unwrap_or_else(PoisonError::into_inner) {
        Some(events) => events.wait(spot, patience),
        None => std::thread::sleep(patience),
    }
}

#[cold]
fn notify(joined: &RwLock<Option<Events>>, spot: Spot) {
    if let Some(events) = &*joined.read().unwrap_or_else(PoisonError::into_inner) {
        events.notify(spot);
    }
}
