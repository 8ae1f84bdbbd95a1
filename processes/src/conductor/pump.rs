//! What the children print: passed on with their names, and the last lines kept for reports.

use std::collections::VecDeque;
use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{self, IsTerminal, PipeReader, Read, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::poll::Poll;

/// How many lines are kept per child.
const KEPT_LINES: usize = 20;
/// Longer lines are cut into pieces of this many bytes.
const LINE_BYTES: usize = 4096;

/// Reads the pipes of all children in one thread.
pub(super) struct Pump {
    feeds: Arc<Feeds>,
    poll: Poll,
    /// Where a file per child is written.
    folder: Option<PathBuf>,
}

#[derive(Default)]
struct Feeds {
    list: Mutex<Vec<Feed>>,
    /// Signalled whenever a pipe ends.
    ended: Condvar,
}

struct Feed {
    worker: usize,
    name: String,
    /// `None` after its end.
    pipe: Option<PipeReader>,
    /// A line that has not ended yet.
    partial: Vec<u8>,
    lines: VecDeque<String>,
    /// Gets every line.
    file: Option<File>,
}

impl Feeds {
    fn lock(&self) -> MutexGuard<'_, Vec<Feed>> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Pump {
    /// Starts the thread. Lines are passed on to stderr if `forward`.
    pub(super) fn start(forward: bool) -> io::Result<Self> {
        let feeds = Arc::new(Feeds::default());
        let shared = Arc::clone(&feeds);
        let mut buffer = vec![0; 16 * 1024];
        let colour = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let poll = Poll::start("phalanx-pump", move |token| {
            let fresh = shared.lock()[token].read(&mut buffer);
            if let Some((name, lines)) = fresh
                && forward
            {
                let mut stderr = io::stderr().lock();
                // Nobody could be told that stderr is closed.
                let name = if colour { in_colour(token, &name) } else { format!("[{name}]") };
                lines.iter().for_each(|line| drop(writeln!(stderr, "{name} {line}")));
            }
            shared.ended.notify_all();
        })?;
        Ok(Self { feeds, poll, folder: None })
    }

    /// Keeps all lines of the children that are added from now on, in a file each in `folder`, which is created if necessary.
    pub(super) fn keep_in(&mut self, folder: &Path) -> io::Result<()> {
        DirBuilder::new().recursive(true).mode(0o700).create(folder)?;
        self.folder = Some(folder.into());
        Ok(())
    }

    /// Takes on the output of a child.
    pub(super) fn add(&self, worker: usize, name: &str, pipe: PipeReader) -> io::Result<()> {
        let file = match &self.folder {
            Some(folder) => {
                let mut options = OpenOptions::new();
                // A child that is started anew goes on in the file of the one before.
                let first = !self.feeds.lock().iter().any(|feed| feed.worker == worker);
                options.create(true).write(true).truncate(first).append(!first).mode(0o600);
                Some(options.open(folder.join(format!("{name}.log")))?)
            }
            None => None,
        };
        let mut list = self.feeds.lock();
        // The thread finds the feed, since it has to wait for the lock.
        self.poll.add(&pipe, list.len(), false)?;
        let (partial, lines) = (Vec::new(), VecDeque::new());
        list.push(Feed { worker, name: name.into(), pipe: Some(pipe), partial, lines, file });
        Ok(())
    }

    /// The last lines of a child. Waits for the end of its output for `patience`, since a dead child may not be read yet.
    pub(super) fn last_lines(&self, worker: usize, patience: Duration) -> Vec<String> {
        let is_open = |list: &mut Vec<Feed>| list.iter().any(|feed| feed.worker == worker && feed.pipe.is_some());
        let waited = self.feeds.ended.wait_timeout_while(self.feeds.lock(), patience, is_open);
        let (list, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let feeds = list.iter().filter(|feed| feed.worker == worker);
        feeds.flat_map(|feed| feed.lines.iter().cloned()).collect()
    }
}

impl Feed {
    /// Reads what is there; returns the lines that are complete now.
    fn read(&mut self, buffer: &mut [u8]) -> Option<(String, Vec<String>)> {
        let count = match self.pipe.as_mut()?.read(buffer) {
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => return None,
            Err(_) => 0,
        };
        let mut fresh = Vec::new();
        if count == 0 {
            self.pipe = None;
            if !self.partial.is_empty() {
                fresh.push(self.take_line());
            }
        }
        for &byte in &buffer[..count] {
            if byte != b'\n' {
                self.partial.push(byte);
            }
            if byte == b'\n' || self.partial.len() == LINE_BYTES {
                fresh.push(self.take_line());
            }
        }
        for line in &fresh {
            if let Some(file) = &mut self.file
                && writeln!(file, "{line}").is_err()
            {
                // A full disk ends the file, not the run.
                self.file = None;
            }
            if self.lines.len() == KEPT_LINES {
                self.lines.pop_front();
            }
            self.lines.push_back(line.clone());
        }
        Some((self.name.clone(), fresh))
    }

    fn take_line(&mut self) -> String {
        let line = String::from_utf8_lossy(&self.partial).trim_end_matches('\r').to_string();
        self.partial.clear();
        line
    }
}

/// Colours that are legible on dark and on bright ground, as numbers of the 256 that terminals know.
const COLOURS: [u8; 10] = [33, 166, 71, 133, 37, 136, 62, 168, 107, 172];

/// The name in the colour of its process.
fn in_colour(number: usize, name: &str) -> String {
    format!("\u{1b}[38;5;{}m[{name}]\u{1b}[0m", COLOURS[number % COLOURS.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_lines_are_kept() {
        let pump = Pump::start(false).unwrap();
        let (reader, mut writer) = io::pipe().unwrap();
        pump.add(3, "child", reader).unwrap();
        for number in 0..50 {
            writeln!(writer, "line {number}").unwrap();
        }
        write!(writer, "unfinished").unwrap();
        drop(writer);
        let lines = pump.last_lines(3, Duration::from_secs(10));
        assert_eq!(lines.len(), KEPT_LINES);
        assert_eq!((lines[0].as_str(), lines[KEPT_LINES - 1].as_str()), ("line 31", "unfinished"));
        assert!(pump.last_lines(4, Duration::from_secs(10)).is_empty());
    }

    #[test]
    fn all_lines_are_kept_in_a_file() {
        let folder = std::env::temp_dir().join(format!("phalanx-pump-{}", std::process::id()));
        let mut pump = Pump::start(false).unwrap();
        pump.keep_in(&folder).unwrap();
        for _ in 0..2 {
            let (reader, mut writer) = io::pipe().unwrap();
            pump.add(3, "child", reader).unwrap();
            (0..50).for_each(|number| writeln!(writer, "line {number}").unwrap());
            drop(writer);
            pump.last_lines(3, Duration::from_secs(10));
        }
        let text = std::fs::read_to_string(folder.join("child.log")).unwrap();
        assert_eq!(text.lines().count(), 100, "the second process went on where the first had ended");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn neighbours_differ_in_colour() {
        assert_eq!(in_colour(0, "plant"), "\u{1b}[38;5;33m[plant]\u{1b}[0m");
        assert_ne!(in_colour(1, "a"), in_colour(2, "a"));
    }
}
