//! Which run takes which core.

use std::fs::File;
use std::io;

use super::allowed_cores;

/// A core that this run has taken, so that another run takes another one. Given back when it is dropped, or with the process.
#[derive(Debug)]
pub struct CoreSlot {
    /// Its number.
    pub core: usize,
    /// Whether all cores were taken, so that this one is shared with another run.
    pub shared: bool,
    /// Held, not used: the lock goes with it.
    _lock: Option<File>,
}

impl CoreSlot {
    /// Takes the last allowed core that no other run has taken, or shares the last one if there is none.
    ///
    /// # Errors
    /// If the operating system does not tell which cores are allowed.
    pub fn take() -> io::Result<Self> {
        let cores = allowed_cores()?;
        let last = *cores.last().ok_or(io::ErrorKind::NotFound)?;
        for &core in cores.iter().rev() {
            let Ok(lock) = open(core) else {
                return Ok(Self { core: last, shared: false, _lock: None });
            };
            if lock.try_lock().is_ok() {
                return Ok(Self { core, shared: false, _lock: Some(lock) });
            }
        }
        Ok(Self { core: last, shared: true, _lock: None })
    }

    /// Takes this core; `None` if another run has it.
    pub(crate) fn take_core(core: usize) -> Option<Self> {
        match open(core) {
            Ok(lock) => lock.try_lock().is_ok().then(|| Self { core, shared: false, _lock: Some(lock) }),
            Err(_) => Some(Self { core, shared: false, _lock: None }),
        }
    }
}

/// The kernel's own directory of a core: every process finds it, and no file of ours is left behind.
fn open(core: usize) -> io::Result<File> {
    File::open(format!("/sys/devices/system/cpu/cpu{core}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_runs_take_different_cores() {
        // Other tests and runs take cores, too, so that only what differs is certain.
        let slots: Vec<CoreSlot> = allowed_cores().unwrap().iter().map(|_| CoreSlot::take().unwrap()).collect();
        let mut owned: Vec<usize> = slots.iter().filter(|slot| !slot.shared).map(|slot| slot.core).collect();
        owned.sort_unstable();
        let count = owned.len();
        owned.dedup();
        assert_eq!(owned.len(), count, "{slots:?}");
        assert!(CoreSlot::take().unwrap().shared);
    }
}
