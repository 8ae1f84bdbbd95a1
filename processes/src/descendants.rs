//! Which processes descend from a run, whatever they have become since: daemons, processes behind a shell, in sessions of
//! their own, with an empty environment, adopted by init.
//!
//! The kernel hands resource limits on to every descendant, also across `exec`. One of them, that of file locks, has had no
//! effect since Linux 2.4.25; every process of a run is given a number as its soft limit, which `/proc/PID/limits` shows to
//! every process. No privilege is needed for any of it. Only a process that sets this very limit itself gets away.
//!
//! Everything here that looks at processes runs in a forked process, too: it makes system calls only, and allocates nothing.

use std::ffi::CStr;
use std::hash::{BuildHasher, RandomState};
use std::mem::MaybeUninit;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::fs::{Mode, OFlags, RawDir, openat};
use rustix::process::{Pid, PidfdFlags, Resource, Rlimit, Signal};

/// Bits of a mark that tell the processes of a run apart.
const NUMBER_BITS: u32 = 20;
/// Bits of a mark that tell runs apart.
const RUN_BITS: u32 = 40;
/// The line of `/proc/PID/limits`.
const LINE: &[u8] = b"Max file locks";
/// How long processes that start others faster than they are killed are fought.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time between two looks.
const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };

/// The processes of one run, and all that descend from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Descendants {
    run: u64,
}

/// One process of a run, and all that descend from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mark(u64);

impl Descendants {
    /// That of a new run.
    pub(crate) fn new() -> Self {
        // Seeded anew by the system in every process; not 0, which is an ordinary limit.
        let random = RandomState::new().hash_one(std::process::id());
        Self { run: (random & ((1 << RUN_BITS) - 1)).max(1) }
    }

    /// The descendants in the text that [`Descendants::to_text`] made.
    pub(crate) fn from_text(text: &str) -> Option<Self> {
        let run = u64::from_str_radix(text.trim(), 16).ok()?;
        (1..1 << RUN_BITS).contains(&run).then_some(Self { run })
    }

    /// In a text.
    pub(crate) fn to_text(self) -> String {
        format!("{:x}\n", self.run)
    }

    /// The mark of process number `number` of the run.
    pub(crate) fn mark(self, number: u32) -> Mark {
        Mark(self.run << NUMBER_BITS | u64::from(number) & ((1 << NUMBER_BITS) - 1))
    }

    /// Kills all processes of the run and all that descend from them; returns when none is alive, or after ten seconds.
    pub(crate) fn end(self) {
        end(|mark| mark >> NUMBER_BITS == self.run);
    }
}

impl Mark {
    /// Marks this process. If the system does not permit it, its descendants cannot be told apart from others.
    pub(crate) fn put_on(self) {
        let limit = rustix::process::getrlimit(Resource::Locks);
        let _ = rustix::process::setrlimit(Resource::Locks, Rlimit { current: Some(self.0), ..limit });
    }

    /// Kills the process that was marked, and all that descend from it.
    pub(crate) fn end(self) {
        end(|mark| mark == self.0);
    }
}

/// Kills processes until none that lives is meant.
fn end(is_meant: impl Fn(u64) -> bool) {
    let start = Instant::now();
    while kill_once(&is_meant) && start.elapsed() < PATIENCE {
        // Those that were killed are ending; what they have started in between is seen by the next look.
        let _ = poll(&mut [], Some(&LOOK));
    }
}

/// Kills all processes that are meant; whether there was any.
fn kill_once(is_meant: &impl Fn(u64) -> bool) -> bool {
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let Ok(processes) = rustix::fs::open(c"/proc", flags, Mode::empty()) else { return false };
    let mut buffer = [MaybeUninit::uninit(); 4096];
    let mut entries = RawDir::new(&processes, &mut buffer);
    let mut any = false;
    while let Some(Ok(entry)) = entries.next() {
        if let Some(pid) = number(entry.file_name().to_bytes()).and_then(|pid| Pid::from_raw(pid as i32)) {
            any |= kill(&processes, entry.file_name(), pid, is_meant);
        }
    }
    any
}

/// Kills one process if it is meant and alive.
fn kill(processes: &OwnedFd, name: &CStr, pid: Pid, is_meant: &impl Fn(u64) -> bool) -> bool {
    if !mark_of(processes, name).is_some_and(is_meant) {
        return false;
    }
    let Ok(process) = rustix::process::pidfd_open(pid, PidfdFlags::empty()) else { return false };
    // The number may have become that of another process meanwhile; behind the descriptor it cannot.
    if !mark_of(processes, name).is_some_and(is_meant) {
        return false;
    }
    let mut dead = [PollFd::new(&process, PollFlags::IN)];
    let now = Timespec { tv_sec: 0, tv_nsec: 0 };
    let is_dead = poll(&mut dead, Some(&now)).is_ok_and(|count| count > 0);
    // A process of another user, by a program that may do so, is not to be had.
    !is_dead && rustix::process::pidfd_send_signal(&process, Signal::KILL).is_ok()
}

/// The limit of file locks of the process called `name`.
fn mark_of(processes: &OwnedFd, name: &CStr) -> Option<u64> {
    let mut path = [0; 32];
    let name = name.to_bytes();
    let end = name.len();
    path.get_mut(..end)?.copy_from_slice(name);
    path.get_mut(end..end + 7)?.copy_from_slice(b"/limits");
    let path = CStr::from_bytes_until_nul(&path).ok()?;
    let file = openat(processes, path, OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty()).ok()?;
    let mut text = [0; 4096];
    let length = rustix::io::read(&file, &mut text).ok()?;
    mark_in(text.get(..length)?)
}

fn mark_in(limits: &[u8]) -> Option<u64> {
    let line = limits.split(|&byte| byte == b'\n').find_map(|line| line.strip_prefix(LINE))?;
    number(line.trim_ascii_start().split(|&byte| byte == b' ').next()?)
}

/// A number in decimal digits and nothing else.
fn number(digits: &[u8]) -> Option<u64> {
    let add = |number: u64, &digit: &u8| {
        digit.is_ascii_digit().then(|| number.checked_mul(10)?.checked_add(u64::from(digit - b'0')))?
    };
    (!digits.is_empty()).then(|| digits.iter().try_fold(0, add))?
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn a_mark_is_read_from_the_text_of_the_kernel() {
        let limits = b"Limit      Soft Limit   Hard Limit  Units \nMax processes  7  7  processes \nMax file locks            77   unlimited            locks     \n";
        assert_eq!(mark_in(limits), Some(77));
        assert_eq!(mark_in(b"Max file locks            unlimited            unlimited            locks     \n"), None);
        assert_eq!(mark_in(b""), None);
        assert_eq!([number(b""), number(b"12x"), number(b"99999999999999999999")], [None; 3]);
    }

    #[test]
    fn a_lineage_survives_being_written_down() {
        let descendants = Descendants::new();
        assert_eq!(Descendants::from_text(&descendants.to_text()), Some(descendants));
        assert_eq!(
            [Descendants::from_text("0"), Descendants::from_text("x"), Descendants::from_text("ffffffffffffffff")],
            [None; 3]
        );
    }

    #[test]
    fn descendants_end_whatever_they_have_become_and_no_other_process() {
        use std::os::unix::process::CommandExt;
        let descendants = Descendants::new();
        let start = |number| {
            let mut command = Command::new("sh");
            // A daemon of a new session, whose parent is gone and whose environment is empty.
            command.args(["-c", "env -i setsid sh -c 'sleep 98765 & echo $!; exec sleep 98765' & wait"]);
            command.stdout(std::process::Stdio::piped());
            // SAFETY: system calls only.
            unsafe {
                command.pre_exec(move || {
                    descendants.mark(number).put_on();
                    Ok(())
                })
            };
            let mut shell = command.spawn().unwrap();
            let mut line = String::new();
            let mut output = std::io::BufReader::new(shell.stdout.take().unwrap());
            std::io::BufRead::read_line(&mut output, &mut line).unwrap();
            (shell, line.trim().to_owned())
        };
        let is_alive = |pid: &str| {
            let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
            stat.rsplit_once(") ").is_some_and(|(_, rest)| !rest.starts_with(['Z', 'X']))
        };
        let ((mut one, sleeper_of_one), (mut other, sleeper_of_other)) = (start(1), start(2));
        descendants.mark(1).end();
        assert!(!is_alive(&sleeper_of_one) && is_alive(&sleeper_of_other));
        descendants.end();
        assert!(!is_alive(&sleeper_of_other));
        one.wait().unwrap();
        other.wait().unwrap();
    }
}
