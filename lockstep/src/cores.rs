//! Cores of the machine, by the numbers that the kernel gives them.

use std::io;

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

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
/// long as switching to it on the same one.
///
/// # Errors
/// If there is no such core, or if it is not allowed.
pub fn pin_to_core(core: usize) -> io::Result<()> {
    Ok(sched_setaffinity(None, &only(core)?)?)
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
