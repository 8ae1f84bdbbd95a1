//! A thread that waits for many file descriptors until it is to end.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use rustix::buffer::spare_capacity;
use rustix::event::{EventfdFlags, Timespec, epoll, eventfd};

/// What ends the thread instead of naming a file descriptor.
const END: u64 = u64::MAX;
/// How many file descriptors are handled at a time.
const BATCH: usize = 64;
/// After the end, how often to look whether anything is left to be read.
const LAST_ROUNDS: usize = 100;

/// The thread; dropping it ends it.
pub(super) struct Poll {
    epoll: Arc<OwnedFd>,
    end: OwnedFd,
    thread: Option<JoinHandle<()>>,
}

impl Poll {
    /// Starts a thread that calls `handle` with the token of every file descriptor that becomes readable.
    pub(super) fn start(name: &str, handle: impl FnMut(usize) + Send + 'static) -> io::Result<Self> {
        let poll = Arc::new(epoll::create(epoll::CreateFlags::CLOEXEC)?);
        let end = eventfd(0, EventfdFlags::CLOEXEC)?;
        epoll::add(&poll, &end, epoll::EventData::new_u64(END), epoll::EventFlags::IN)?;
        let epoll = Arc::clone(&poll);
        let thread = thread::Builder::new().name(name.into()).spawn(move || run(&poll, handle))?;
        Ok(Self { epoll, end, thread: Some(thread) })
    }

    /// Adds a file descriptor. It leaves by itself when it is closed; if it is to report `once`, after that.
    pub(super) fn add(&self, file: impl AsFd, token: usize, once: bool) -> io::Result<()> {
        let flags = if once { epoll::EventFlags::IN | epoll::EventFlags::ONESHOT } else { epoll::EventFlags::IN };
        Ok(epoll::add(&self.epoll, file, epoll::EventData::new_u64(token as u64), flags)?)
    }
}

impl Drop for Poll {
    fn drop(&mut self) {
        // If this write could fail, the thread would not end and must not be waited for.
        if rustix::io::write(&self.end, &1u64.to_ne_bytes()).is_ok()
            && let Some(thread) = self.thread.take()
        {
            // A panic in it has been printed; there is nothing to add.
            let _ = thread.join();
        }
    }
}

fn run(poll: &OwnedFd, mut handle: impl FnMut(usize)) {
    let mut events: Vec<epoll::Event> = Vec::with_capacity(BATCH);
    let mut rounds_left = None;
    let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
    while rounds_left != Some(0) {
        events.clear();
        let patience = rounds_left.map(|_| &at_once);
        match epoll::wait(poll, spare_capacity(&mut events), patience) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(_) => return,
        }
        let tokens = || events.iter().map(|event| event.data.u64());
        if tokens().any(|token| token == END) {
            rounds_left.get_or_insert(LAST_ROUNDS);
        }
        let mut something_left = false;
        for token in tokens().filter(|&token| token != END) {
            something_left = true;
            handle(token as usize);
        }
        rounds_left = rounds_left.map(|rounds| if something_left { rounds - 1 } else { 0 });
    }
}
