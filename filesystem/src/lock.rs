//! The process that holds the lock of a file.

use std::fs::{self, File};
use std::os::unix::fs::MetadataExt;

/// The process that holds the lock of a file, in words: `process 4711 (phalanx run uav)`, `another process` if the kernel does not
/// name it.
pub fn holder(file: &File) -> String {
    let Some(pid) = lock_holder(file) else { return "another process".into() };
    let arguments = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    describe(pid, &arguments, &fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default())
}

/// A process in words, from its number, its arguments and its `/proc/PID/stat`.
fn describe(pid: u32, arguments: &[u8], stat: &str) -> String {
    let words = arguments.split(|&byte| byte == 0).filter(|word| !word.is_empty());
    let mut words = words.map(|word| String::from_utf8_lossy(word).into_owned());
    let program = words.next().map(|word| word.rsplit('/').next().unwrap_or_default().to_string());
    let command = program.into_iter().chain(words).collect::<Vec<_>>().join(" ");
    // Any text is possible, and this one ends up in a terminal.
    let command: String = command.chars().map(|letter| if letter.is_control() { '?' } else { letter }).collect();
    // 4711 (phalanx) S 1 ...: the name may have parentheses itself.
    let is_stopped = stat.rsplit_once(") ").is_some_and(|(_, rest)| rest.starts_with(['T', 't']));
    let name = if command.is_empty() { String::new() } else { format!(" ({command})") };
    format!("process {pid}{name}{}", if is_stopped { ", which is stopped" } else { "" })
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
        let stopped = describe(1234, b"/bin/phalanx\0run\0uav\0", "1234 (phalanx) T 1 1234 1 0 -1");
        assert_eq!(stopped, "process 1234 (phalanx run uav), which is stopped");
        assert_eq!(describe(7, b"a (b) c\0", "7 (a (b) c) S 1 7 1"), "process 7 (a (b) c)");
        assert_eq!(describe(7, b"\x1b[2J\0", "7 (x) T) t 1 7 1"), "process 7 (?[2J), which is stopped");
        assert_eq!(describe(7, b"", ""), "process 7");
    }

    #[test]
    fn a_lock_that_is_held_is_traced_to_its_process() {
        let path = std::env::temp_dir().join(format!("phalanx-lock-{}", std::process::id()));
        let file = File::create(&path).unwrap();
        file.lock().unwrap();
        let other = File::open(&path).unwrap();
        let told = holder(&other);
        assert_eq!(lock_holder(&other), Some(std::process::id()));
        drop(file);
        assert_eq!(lock_holder(&other), None);
        fs::remove_file(&path).unwrap();
        assert!(told.starts_with(&format!("process {} (filesystem", std::process::id())), "{told}");
    }
}
