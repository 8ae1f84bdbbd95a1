//! Keys of the terminal that a run is started from.
//!
//! The terminal belongs to the foreground job of its shell. A run reads keys and changes the mode of the terminal only as long
//! as it is that job: `phalanx run ... &`, Ctrl-Z with `bg`, and `fg` work as for any program.

use std::io::{self, IsTerminal, Read};
use std::os::unix::net::UnixStream;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};
use signal_hook::SigId;
use signal_hook::consts::SIGTSTP;
use signal_hook::low_level::{emulate_default_handler, pipe, unregister};

use super::RunControl;
use crate::terminal::is_ours;

/// How often to look whether the run is over, or the foreground job.
const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };

/// Space pauses and resumes, `s` does one step, `q` stops, as long as this lives. The terminal gets its mode back then.
pub(crate) struct Keys {
    done: RunControl,
    thread: Option<JoinHandle<()>>,
    suspension: SigId,
}

impl Keys {
    /// Listens, if stdin is a terminal.
    pub(crate) fn listen(stop: &RunControl) -> Option<Self> {
        if !io::stdin().is_terminal() || !io::stderr().is_terminal() {
            return None;
        }
        // A Ctrl-Z comes as a byte, so that the thread that knows the mode of the terminal stops the process.
        let (suspended, signal) = UnixStream::pair().ok()?;
        suspended.set_nonblocking(true).ok()?;
        let suspension = pipe::register(SIGTSTP, signal).ok()?;
        let done = RunControl::new();
        let listener = Listener { stop: stop.clone(), end: done.clone(), suspended, before: None };
        let thread = thread::Builder::new().name("keys".into()).spawn(move || listener.listen()).ok();
        Some(Self { done, thread, suspension })
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        self.done.request();
        if let Some(thread) = self.thread.take() {
            // A panic in it has been printed.
            let _ = thread.join();
        }
        unregister(self.suspension);
    }
}

/// What the thread does.
struct Listener {
    stop: RunControl,
    end: RunControl,
    /// Readable after a Ctrl-Z.
    suspended: UnixStream,
    /// The mode that the terminal is to have again; `None` as long as it is not changed.
    before: Option<Termios>,
}

impl Listener {
    fn listen(mut self) {
        while !self.end.is_requested() {
            if is_ours(io::stdin()) {
                self.take_keys();
            } else {
                // The process that has the terminal now has set its mode.
                self.before = None;
            }
            let (suspended, key) = self.wait();
            if suspended {
                self.suspend();
            } else if key && is_ours(io::stdin()) && !self.read_key() {
                break;
            }
        }
        self.give_back();
    }

    /// Waits for a Ctrl-Z and for a key.
    fn wait(&self) -> (bool, bool) {
        let stdin = io::stdin();
        let keys = if self.before.is_some() { PollFlags::IN } else { PollFlags::empty() };
        let mut files = [PollFd::new(&self.suspended, PollFlags::IN), PollFd::new(&stdin, keys)];
        if poll(&mut files, Some(&LOOK)).is_err() {
            return (false, false);
        }
        let hangs_up = files[1].revents().intersects(PollFlags::HUP | PollFlags::ERR);
        if hangs_up && self.before.is_none() {
            // It would be reported again at once.
            thread::sleep(Duration::from_nanos(LOOK.tv_nsec as u64));
        }
        (!files[0].revents().is_empty(), files[1].revents().contains(PollFlags::IN))
    }

    /// Keys come at once and are not shown; Ctrl-C and Ctrl-Z stay signals. For the foreground job.
    fn take_keys(&mut self) {
        let stdin = io::stdin();
        let Ok(now) = tcgetattr(&stdin) else { return };
        let ours = LocalModes::ICANON | LocalModes::ECHO;
        if self.before.is_some() && !now.local_modes.intersects(ours) {
            return;
        }
        let mut mode = now.clone();
        mode.local_modes.remove(ours);
        if tcsetattr(&stdin, OptionalActions::Now, &mode).is_ok() {
            self.before = Some(now);
        }
    }

    /// The terminal gets its mode back, if it is still that of this run.
    fn give_back(&mut self) {
        if let Some(before) = self.before.take().filter(|_| is_ours(io::stdin())) {
            // If the terminal is gone, its mode does not matter.
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &before);
        }
    }

    /// Stops the process, as Ctrl-Z does without this. Returns when the shell continues it.
    fn suspend(&mut self) {
        let _ = self.suspended.read(&mut [0; 64]);
        self.give_back();
        // If that is not possible, the run goes on.
        let _ = emulate_default_handler(SIGTSTP);
    }

    /// Whether there may be more keys.
    fn read_key(&self) -> bool {
        let mut key = [0];
        match rustix::io::read(io::stdin(), &mut key) {
            Ok(1) => press(key[0], &self.stop),
            // The terminal went to another job in between.
            Err(rustix::io::Errno::IO | rustix::io::Errno::INTR) if !is_ours(io::stdin()) => {}
            _ => return false,
        }
        true
    }
}

fn press(key: u8, stop: &RunControl) {
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
