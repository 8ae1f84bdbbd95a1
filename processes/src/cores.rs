//! Cores of the machine, by the numbers that the kernel gives them.

mod slot;

use std::io;

use rustix::process::Pid;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
pub use slot::CoreSlot;

/// The cores that this process may use, in ascending order.
///
/// # Errors
/// If the operating system does not tell.
pub fn allowed_cores() -> io::Result<Vec<usize>> {
    let allowed = sched_getaffinity(None)?;
    Ok((0..CpuSet::MAX_CPU).filter(|&core| allowed.is_set(core)).collect())
}

/// Keeps the calling thread, and all that it spawns from now on, on one core.
///
/// A run is fastest if the conductor shares the core of its workers: waking a process on another core takes many times as
/// long as switching to it on the same one. For the same reason the thread asks not to interrupt others when it is woken
/// (`SCHED_BATCH`): a process that wakes many wakes them all before one of them runs.
///
/// # Errors
/// If there is no such core, or if it is not allowed.
pub fn pin_to_core(core: usize) -> io::Result<()> {
    settle(&only(core)?)
}

/// Keeps the calling thread, and all that it spawns from now on, off a core, if there is another one: for helpers that work
/// beside a run that has the core.
///
/// # Errors
/// If the operating system refuses.
pub fn keep_off_core(core: usize) -> io::Result<()> {
    let mut cores = sched_getaffinity(None)?;
    if core < CpuSet::MAX_CPU && cores.is_set(core) && cores.count() > 1 {
        cores.unset(core);
        sched_setaffinity(None, &cores)?;
    }
    Ok(())
}

/// Moves the process `pid`, of one thread, to one core.
pub(crate) fn move_to_core(pid: u32, core: usize) -> io::Result<()> {
    let pid = Pid::from_raw(pid as i32).ok_or(io::ErrorKind::InvalidInput)?;
    Ok(sched_setaffinity(Some(pid), &only(core)?)?)
}

/// What [`pin_to_core`] does, in a form that is allowed between fork and exec.
pub(crate) fn settle(cores: &CpuSet) -> io::Result<()> {
    sched_setaffinity(None, cores)?;
    // SAFETY: two system calls about the calling thread; the parameter outlives the call. If the second one is refused, the
    // thread is as fast as it was.
    unsafe {
        // A real-time policy was chosen by the user and stays.
        if libc::sched_getscheduler(0) == libc::SCHED_OTHER {
            libc::sched_setscheduler(0, libc::SCHED_BATCH, &libc::sched_param { sched_priority: 0 });
        }
    }
    Ok(())
}

/// The set of one core.
pub(crate) fn only(core: usize) -> io::Result<CpuSet> {
    if core >= CpuSet::MAX_CPU {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("there is no core {core}")));
    }
    let mut cores = CpuSet::new();
    cores.set(core);
    Ok(cores)
}
