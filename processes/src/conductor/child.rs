//! One worker process: how it is started and how it ends.

use std::ffi::OsString;
use std::io::{self, PipeReader};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::{env, fs};

use rustix::io::FdFlags;
use rustix::process::{Pid, PidfdFlags, Signal, WaitId, WaitIdOptions};
use rustix::thread::CpuSet;

use super::error::Death;
use crate::cores;
use crate::descendants::Mark;
use crate::worker::{PAGE_FD, REPLACEMENT, RUN_DIRECTORY, ReplacementOrder, WORKER};

/// Environment variable of the C library.
const TUNABLES: &str = "GLIBC_TUNABLES";
/// Restartable sequences, which nothing here uses, cost 5 % of a step: the kernel updates them at every switch.
const NO_RESTARTABLE_SEQUENCES: &str = "glibc.pthread.rseq=0";

/// A worker process. Dropping it kills it, with all that it started itself.
pub(super) struct Child {
    process: std::process::Child,
    pid: Pid,
    pidfd: OwnedFd,
}

/// What a child is given besides its program and arguments.
pub(super) struct ChildSetup<'a> {
    pub(super) directory: &'a Path,
    pub(super) worker: usize,
    pub(super) page: BorrowedFd<'a>,
    pub(super) cpu: Option<usize>,
    /// For a process that takes the place of another one; its pipe must be open.
    pub(super) order: Option<ReplacementOrder>,
    pub(super) mark: Mark,
}

impl Child {
    /// Starts a worker, and returns it with the pipe of its output.
    pub(super) fn spawn(mut command: Command, setup: &ChildSetup) -> io::Result<(Self, PipeReader)> {
        let (reader, writer) = io::pipe()?;
        let page = setup.page.as_raw_fd();
        command
            .env(RUN_DIRECTORY, setup.directory)
            .env(WORKER, setup.worker.to_string())
            .env(PAGE_FD, page.to_string())
            .env(TUNABLES, tunables())
            .env_remove(REPLACEMENT)
            .stdin(Stdio::null())
            .stdout(writer.try_clone()?)
            .stderr(writer)
            // A Ctrl-C at the terminal is for the orchestrator, who then ends the children in order.
            .process_group(0);
        if let Some(order) = &setup.order {
            command.env(REPLACEMENT, serde_json::to_string(order)?);
        }
        let pipe = setup.order.map(|order| order.pipe);
        let (parent, mark) = (rustix::process::getpid(), setup.mark);
        let cpus = setup.cpu.map(cores::only).transpose()?;
        // SAFETY: between fork and exec only system calls are made: no allocation, no lock.
        unsafe { command.pre_exec(move || prepare(parent, mark, page, pipe, cpus.as_ref())) };
        let mut process = command.spawn()?;
        // The command holds ends of the pipe, which would keep it open.
        drop(command);
        let pid = Pid::from_child(&process);
        match rustix::process::pidfd_open(pid, PidfdFlags::empty()) {
            Ok(pidfd) => Ok((Self { process, pid, pidfd }, reader)),
            Err(error) => {
                process.kill().and_then(|()| process.wait())?;
                Err(error.into())
            }
        }
    }

    /// Readable once the process is dead.
    pub(super) fn pidfd(&self) -> BorrowedFd<'_> {
        self.pidfd.as_fd()
    }

    pub(super) fn pid(&self) -> u32 {
        self.process.id()
    }

    /// How it ended, if it did. It is not reaped yet: as long as it is a zombie, its process group cannot be another's.
    pub(super) fn death(&self) -> Option<Death> {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        let status = rustix::process::waitid(WaitId::PidFd(self.pidfd()), options).ok()??;
        let signal = status.terminating_signal().map(Death::Signal);
        signal.or_else(|| status.exit_status().map(Death::Exit))
    }

    /// Its state as the kernel tells it: the first word behind the name in `/proc/<pid>/stat`.
    pub(super) fn state(&self) -> char {
        let stat = fs::read_to_string(format!("/proc/{}/stat", self.pid())).unwrap_or_default();
        // The name is in brackets and may itself contain any character.
        stat.rsplit_once(") ").and_then(|(_, rest)| rest.chars().next()).unwrap_or('?')
    }

    /// The function of the kernel that it waits in, if it waits and the kernel tells.
    pub(super) fn waits_in(&self) -> Option<String> {
        let place = fs::read_to_string(format!("/proc/{}/wchan", self.pid())).ok()?;
        let is_name =
            place.len() < 64 && place.chars().all(|character| character.is_ascii_alphanumeric() || character == '_');
        (is_name && !place.is_empty() && place != "0").then_some(place)
    }

    /// Kills it, with all that it started itself.
    pub(super) fn kill(&self) {
        let _ = rustix::process::kill_process_group(self.pid, Signal::KILL);
    }

    /// Lets it run if it was stopped, so that it can end by itself.
    pub(super) fn resume(&self) {
        // It may be dead, which is just as well.
        let _ = rustix::process::kill_process_group(self.pid, Signal::CONT);
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // Kills what the worker may have started, too. Not reaped before this, so the number is still its own.
        self.kill();
        let _ = self.process.wait();
    }
}

fn tunables() -> OsString {
    match env::var_os(TUNABLES) {
        Some(mut others) if !others.is_empty() => {
            others.push(":");
            others.push(NO_RESTARTABLE_SEQUENCES);
            others
        }
        _ => NO_RESTARTABLE_SEQUENCES.into(),
    }
}

/// Runs in the child before its program starts.
fn prepare(parent: Pid, mark: Mark, page: i32, pipe: Option<i32>, cpus: Option<&CpuSet>) -> io::Result<()> {
    mark.put_on();
    rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
    if rustix::process::getppid() != Some(parent) {
        // It died before the line above.
        return Err(io::ErrorKind::NotConnected.into());
    }
    for inherited in [Some(page), pipe].into_iter().flatten() {
        // SAFETY: the conductor holds the page and the pipe open while it spawns.
        let inherited = unsafe { BorrowedFd::borrow_raw(inherited) };
        rustix::io::fcntl_setfd(inherited, FdFlags::empty())?;
    }
    // SAFETY: `set` is initialised by sigemptyset before it is used.
    let unblocked = unsafe {
        let mut set = std::mem::zeroed();
        libc::sigemptyset(&mut set);
        libc::sigprocmask(libc::SIG_SETMASK, &set, std::ptr::null_mut())
    };
    if unblocked != 0 {
        return Err(io::Error::last_os_error());
    }
    match cpus {
        Some(cpus) => cores::settle(cpus),
        None => Ok(()),
    }
}
