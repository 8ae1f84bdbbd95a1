//! A small process that outlives the conductor by a moment, however that ends, and ends all that descends from its run.
//!
//! The kernel kills the participants with the conductor, but not what they have started themselves. The supervisor holds one end
//! of a pipe; when the conductor is gone, the other end is closed.

use std::fs::File;
use std::io;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd, RawFd};

use rustix::process::{Pid, Signal, WaitOptions};

use crate::descendants::Descendants;

/// The descriptor that the supervisor keeps.
const LIFELINE: RawFd = 0;
/// Descriptors that are closed one by one where the kernel cannot close a range.
const MANY: RawFd = 4096;

/// The supervisor of a run. Dropping it ends what descends from the run, and then the supervisor.
pub(super) struct Supervisor {
    descendants: Descendants,
    process: Pid,
    /// Held open, not used.
    _lifeline: OwnedFd,
}

impl Supervisor {
    /// Starts it, before any process of the run.
    ///
    /// # Errors
    /// That of the operating system if there cannot be another process.
    pub(super) fn start(descendants: Descendants) -> io::Result<Self> {
        let (reader, writer) = io::pipe()?;
        let mut before = std::mem::MaybeUninit::uninit();
        // SAFETY: `all` is initialised by sigfillset, `before` by sigprocmask. With all signals blocked, no handler of this
        // program runs in the child, which makes system calls only from here to its end: no allocation and no lock.
        let forked = unsafe {
            let mut all = std::mem::zeroed();
            libc::sigfillset(&mut all);
            libc::pthread_sigmask(libc::SIG_SETMASK, &all, before.as_mut_ptr());
            let forked = libc::fork();
            if forked == 0 {
                watch(reader.as_raw_fd(), descendants);
            }
            let error = io::Error::last_os_error();
            libc::pthread_sigmask(libc::SIG_SETMASK, before.as_ptr(), std::ptr::null_mut());
            if forked < 0 { Err(error) } else { Ok(forked) }
        };
        let process = Pid::from_raw(forked?).ok_or(io::ErrorKind::Other)?;
        Ok(Self { descendants, process, _lifeline: writer.into() })
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        self.descendants.end();
        // Not reaped before, so the number is still its own.
        let _ = rustix::process::kill_process(self.process, Signal::KILL);
        let _ = rustix::process::waitpid(Some(self.process), WaitOptions::empty());
    }
}

/// What the supervisor does.
fn watch(lifeline: RawFd, descendants: Descendants) -> ! {
    // A signal to the group or the terminal of the conductor ends the conductor, not the supervisor.
    let _ = rustix::process::setsid();
    let _ = rustix::process::chdir(c"/");
    let _ = rustix::thread::set_name(c"phalanx-guard");
    keep_only(lifeline);
    // SAFETY: descriptor 0 is the end of the pipe since `keep_only`, and nothing else in this process uses it.
    let lifeline = unsafe { File::from_raw_fd(LIFELINE) };
    // No process writes to it: what can be read is its end.
    while rustix::io::read(&lifeline, &mut [0; 16]).is_ok_and(|count| count > 0) {}
    descendants.end();
    // SAFETY: ends the process without running anything of the program that it was forked from.
    unsafe { libc::_exit(0) }
}

/// Closes all descriptors but one: locks, pipes and files of the conductor end with the conductor.
fn keep_only(descriptor: RawFd) {
    // SAFETY: plain system calls; this process uses nothing of what they close.
    unsafe {
        libc::dup2(descriptor, LIFELINE);
        if libc::syscall(libc::SYS_close_range, LIFELINE + 1, libc::c_uint::MAX, 0) != 0 {
            for other in LIFELINE + 1..MANY {
                libc::close(other);
            }
        }
    }
}
