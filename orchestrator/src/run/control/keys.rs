//! Keys of the terminal that a run is started from.

use std::io::{self, IsTerminal};
use std::thread::{self, JoinHandle};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};

use super::Stop;

/// How long after the end of a run the thread may look for keys, s.
const PATIENCE: Timespec = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };

/// Space pauses and resumes, `s` does one step, `q` stops, as long as this lives. The terminal gets its mode back then.
pub(crate) struct Keys {
    before: Termios,
    done: Stop,
    thread: Option<JoinHandle<()>>,
}

impl Keys {
    /// Listens, if stdin is a terminal.
    pub(crate) fn listen(stop: &Stop) -> Option<Self> {
        let stdin = io::stdin();
        if !stdin.is_terminal() || !io::stderr().is_terminal() {
            return None;
        }
        let before = tcgetattr(&stdin).ok()?;
        let mut mode = before.clone();
        // Keys come at once and are not shown; Ctrl-C stays a signal.
        mode.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
        tcsetattr(&stdin, OptionalActions::Now, &mode).ok()?;
        let done = Stop::new();
        let (end, stop) = (done.clone(), stop.clone());
        let thread = thread::Builder::new().name("keys".into()).spawn(move || read(&stop, &end)).ok();
        Some(Self { before, done, thread })
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        self.done.request();
        if let Some(thread) = self.thread.take() {
            // A panic in it has been printed.
            let _ = thread.join();
        }
        // If the terminal is gone, nobody misses its mode.
        let _ = tcsetattr(io::stdin(), OptionalActions::Now, &self.before);
    }
}

fn read(stop: &Stop, end: &Stop) {
    let stdin = io::stdin();
    while !end.is_requested() {
        let mut files = [PollFd::new(&stdin, PollFlags::IN)];
        match poll(&mut files, Some(&PATIENCE)) {
            Ok(0) | Err(rustix::io::Errno::INTR) => continue,
            Ok(_) => {}
            Err(_) => return,
        }
        let mut key = [0];
        match rustix::io::read(&stdin, &mut key) {
            Ok(1) => press(key[0], stop),
            _ => return,
        }
    }
}

fn press(key: u8, stop: &Stop) {
    match key {
        b' ' if stop.is_paused() => stop.resume(),
        b' ' => {
            stop.pause();
            eprintln!("paused; space goes on, s does one step, q stops");
        }
        b's' => {
            stop.advance(1);
            eprintln!("step {}", stop.steps_done() + 1);
        }
        b'q' => stop.request(),
        _ => {}
    }
}
