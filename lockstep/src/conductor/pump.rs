//! What the children print: passed on with their names, and the last lines kept for reports.

use std::collections::VecDeque;
use std::io::{self, PipeReader, Read, Write};
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
        let poll = Poll::start("phalanx-pump", move |token| {
            let fresh = shared.lock()[token].read(&mut buffer);
            if let Some((name, lines)) = fresh
                && forward
            {
                let mut stderr = io::stderr().lock();
                // Nobody could be told that stderr is closed.
                lines.iter().for_each(|line| drop(writeln!(stderr, "[{name}] {line}")));
            }
            shared.ended.notify_all();
        })?;
        Ok(Self { feeds, poll })
    }

    /// Takes on the output of a child.
    pub(super) fn add(&self, worker: usize, name: &str, pipe: PipeReader) -> io::Result<()> {
        let mut list = self.feeds.lock();
        // The thread finds the feed, since it has to wait for the lock.
        self.poll.add(&pipe, list.len(), false)?;
        let (partial, lines) = (Vec::new(), VecDeque::new());
        list.push(Feed { worker, name: name.into(), pipe: Some(pipe), partial, lines });
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
}
