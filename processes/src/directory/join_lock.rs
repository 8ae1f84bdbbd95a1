//! The lock for joining a run from outside: shared by processes that join it, for as long as that takes, and taken alone when the
//! run ends.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use filesystem::holder;
use rustix::fs::OFlags;

/// Its file in the directory of the run.
const DOOR_FILE: &str = "door";
/// How long the end of a run waits for processes that join it. Joining takes milliseconds, unless the process is stopped.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two tries of a lock.
const LOOK: Duration = Duration::from_millis(5);

/// A hold on the lock; as long as it lives, the run does not remove its files, but for a second at most.
#[derive(Debug)]
pub(crate) struct JoinLock(#[allow(dead_code, reason = "the lock goes with it")] File);

impl JoinLock {
    /// Holds the lock of the run in `directory` open; `None` if it is closed already.
    pub(crate) fn hold(directory: &Path) -> Option<Self> {
        let lock = open(directory).ok()?;
        lock.try_lock_shared().ok()?;
        Some(Self(lock))
    }

    /// Closes the lock. `Err` names the process that holds it open, if it does not let go.
    pub(super) fn close(directory: &Path) -> Result<Option<Self>, String> {
        let Ok(lock) = open(directory) else { return Ok(None) };
        let start = Instant::now();
        loop {
            match lock.try_lock() {
                Ok(()) => return Ok(Some(Self(lock))),
                Err(TryLockError::Error(_)) => return Ok(None),
                Err(TryLockError::WouldBlock) if start.elapsed() > PATIENCE => return Err(holder(&lock)),
                Err(TryLockError::WouldBlock) => thread::sleep(LOOK),
            }
        }
    }
}

fn open(directory: &Path) -> io::Result<File> {
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).mode(0o600).custom_flags(flags.bits() as i32);
    options.open(directory.join(DOOR_FILE))
}
