//! The door of a run: held open by those who join it from outside for as long as that takes, and closed when it ends.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rustix::fs::OFlags;

/// Its file in the directory of the run.
const DOOR_FILE: &str = "door";
/// How long the end of a run waits for those who join it. They take milliseconds, unless they are stopped.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two tries of a lock.
const LOOK: Duration = Duration::from_millis(5);

/// A hold on the door; as long as it lives, the run does not remove its files, but for a second at most.
#[derive(Debug)]
pub(crate) struct Door(#[allow(dead_code, reason = "the lock goes with it")] File);

impl Door {
    /// Holds the door of the run in `directory` open; `None` if it is closed already.
    pub(crate) fn hold(directory: &Path) -> Option<Self> {
        let door = open(directory).ok()?;
        door.try_lock_shared().ok()?;
        Some(Self(door))
    }

    /// Closes the door. `Err` names the process that holds it open, if it does not let go.
    pub(super) fn close(directory: &Path) -> Result<Option<Self>, String> {
        let Ok(door) = open(directory) else { return Ok(None) };
        let start = Instant::now();
        loop {
            match door.try_lock() {
                Ok(()) => return Ok(Some(Self(door))),
                Err(TryLockError::Error(_)) => return Ok(None),
                Err(TryLockError::WouldBlock) if start.elapsed() > PATIENCE => return Err(holder(&door)),
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

/// The process that holds the lock of a file, in words.
pub(super) fn holder(file: &File) -> String {
    let Some(pid) = lock_holder(file) else { return "another process".into() };
    describe(pid, &fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default())
}

/// A process in words, from its number and what the kernel tells of it.
fn describe(pid: u32, stat: &str) -> String {
    let parts = stat.split_once('(').and_then(|(_, rest)| rest.rsplit_once(") "));
    let Some((name, rest)) = parts else { return format!("process {pid}") };
    let is_stopped = rest.starts_with(['T', 't']);
    // Any name is possible, and this one ends up in a terminal.
    let name: String = name.chars().map(|letter| if letter.is_control() { '?' } else { letter }).collect();
    format!("process {pid} ({name}){}", if is_stopped { ", which is stopped" } else { "" })
}

/// The process that holds the exclusive lock of a file (`flock`). `None` if there is no such lock, or the kernel does not name its
/// holder, as in another process namespace.
pub fn lock_holder(file: &File) -> Option<u32> {
    let found = file.metadata().ok()?;
    let (major, minor) = (rustix::fs::major(found.dev()), rustix::fs::minor(found.dev()));
    let identity = format!("{major:02x}:{minor:02x}:{}", found.ino());
    // 1: FLOCK  ADVISORY  WRITE 4711 00:1c:4242 0 EOF
    let of_line = |line: &str| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let is_it = ["FLOCK", "WRITE", identity.as_str()].iter().all(|word| fields.contains(word));
        is_it.then(|| fields.get(4)?.parse().ok()).flatten().filter(|&process| process > 0)
    };
    fs::read_to_string("/proc/locks").ok()?.lines().find_map(of_line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_holder_of_a_lock_is_named_with_its_state() {
        let stopped = describe(1234, "1234 (phalanx) T 1 1234 1 0 -1");
        assert_eq!(stopped, "process 1234 (phalanx), which is stopped");
        assert_eq!(describe(7, "7 (a (b) c) S 1 7 1"), "process 7 (a (b) c)");
        assert_eq!(describe(7, "7 (\u{1b}[2J) t 1 7 1"), "process 7 (?[2J), which is stopped");
        assert_eq!(describe(7, ""), "process 7");
    }

    #[test]
    fn a_lock_that_is_held_is_traced_to_its_process() {
        let path = std::env::temp_dir().join(format!("phalanx-door-{}", std::process::id()));
        let file = File::create(&path).unwrap();
        file.lock().unwrap();
        let other = File::open(&path).unwrap();
        let told = holder(&other);
        assert_eq!(lock_holder(&other), Some(std::process::id()));
        drop(file);
        assert_eq!(lock_holder(&other), None);
        fs::remove_file(&path).unwrap();
        assert!(told.starts_with(&format!("process {} (", std::process::id())), "{told}");
    }
}
