//! Stderr, written by a thread: a run never waits for what reads it.
//!
//! Stderr may be a pipe that is full, or a terminal that is held (Ctrl-S). So everything that this process says goes into a
//! queue, which the thread writes. The queue has a limit; what does not fit is dropped, and counted. What participants print
//! and what the program itself says have separate limits: a participant that floods its output drowns no error message.
//!
//! Until [`start`] is called, [`say`] writes to stderr directly. Participants do that: the conductor reads their stderr.

use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Bytes of messages of this process that may wait.
const OWN: usize = 1 << 20;
/// Bytes of output of participants that may wait.
const FORWARDED: usize = 1 << 20;
/// Bytes after which what comes next is written separately.
const BATCH: usize = 16 << 10;
/// Removes the line of the terminal that the cursor is in.
const CLEAR_LINE: &[u8] = b"\r\x1b[2K";

/// Creates a file for what a process prints, readable by this user only. An earlier file of the name goes; what a link of the name
/// leads to stays.
///
/// # Errors
/// That of the operating system; [`ErrorKind::AlreadyExists`] if a folder, a FIFO or a device has the name.
pub fn new_file(path: &Path) -> io::Result<File> {
    match path.symlink_metadata() {
        Ok(found) if found.is_file() || found.is_symlink() => fs::remove_file(path)?,
        Ok(_) => return Err(io::Error::new(ErrorKind::AlreadyExists, format!("{} is no file", path.display()))),
        Err(_) => {}
    }
    OpenOptions::new().write(true).create_new(true).mode(0o600).open(path)
}

/// Output of participants and messages that were dropped, since stderr was not read fast enough.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// How many lines.
    pub lines: u64,
    /// How many bytes.
    pub bytes: u64,
}

impl Dropped {
    /// Counts the lines of `text`.
    fn of(text: &[u8]) -> Self {
        let lines = text.iter().filter(|&&byte| byte == b'\n').count();
        Self { lines: lines as u64, bytes: text.len() as u64 }
    }

    fn add(&mut self, other: Self) {
        self.lines += other.lines;
        self.bytes += other.bytes;
    }
}

static CONSOLE: Console =
    Console { queue: Mutex::new(Queue::EMPTY), changed: Condvar::new(), is_started: AtomicBool::new(false) };

/// From now on nothing waits for stderr. If there can be no thread, everything stays as it is.
pub fn start() {
    if !CONSOLE.is_started.swap(true, SeqCst) {
        let thread = thread::Builder::new().name("phalanx-stderr".into()).spawn(|| CONSOLE.serve());
        CONSOLE.is_started.store(thread.is_ok(), SeqCst);
    }
}

/// Says something on stderr: whole lines.
pub fn say(text: &[u8]) {
    CONSOLE.put(text.into(), Origin::Own);
}

/// Passes on what a participant has printed: whole lines.
pub(crate) fn forward(text: Vec<u8>) {
    CONSOLE.put(text, Origin::Participant);
}

/// Whether there is room for output of participants.
pub(crate) fn has_room() -> bool {
    CONSOLE.lock().waiting[Origin::Participant as usize] < FORWARDED
}

/// Counts output of participants that is not passed on for want of room.
pub(crate) fn drop_lines(text: &[u8]) {
    CONSOLE.lock().lose(Dropped::of(text));
}

/// Shows a line below everything else; an empty one removes it. For terminals.
pub fn footer(text: &str) {
    let mut queue = CONSOLE.lock();
    if queue.footer != text.as_bytes() {
        queue.footer = text.into();
        queue.is_footer_new = true;
        CONSOLE.changed.notify_all();
    }
}

/// Leaves the footer as it stands, and shows none from now on: the terminal belongs to others.
pub fn leave_footer() {
    let mut queue = CONSOLE.lock();
    queue.footer.clear();
    (queue.has_footer, queue.is_footer_new) = (false, false);
}

/// What was dropped so far.
pub fn dropped() -> Dropped {
    CONSOLE.lock().dropped
}

/// Waits until everything is written; gives up when nothing at all has been written for `patience`: nothing reads then.
/// Returns whether everything was written.
pub fn flush(patience: Duration) -> bool {
    let mut queue = CONSOLE.lock();
    let (mut written, mut since) = (queue.written, Instant::now());
    while CONSOLE.is_started.load(SeqCst) && !queue.is_done() {
        if queue.written != written {
            (written, since) = (queue.written, Instant::now());
        }
        let left = patience.saturating_sub(since.elapsed());
        if left.is_zero() || queue.is_stuck_at == Some(written) {
            queue.is_stuck_at = Some(written);
            return false;
        }
        queue = CONSOLE.changed.wait_timeout(queue, left).unwrap_or_else(PoisonError::into_inner).0;
    }
    true
}

/// Who says something.
#[derive(Clone, Copy)]
enum Origin {
    Own,
    Participant,
}

struct Console {
    queue: Mutex<Queue>,
    /// Signalled when there is something to be written, and when something was written.
    changed: Condvar,
    is_started: AtomicBool,
}

impl Console {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        // Nothing is left half-done by a panic in between.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, text: Vec<u8>, origin: Origin) {
        if text.is_empty() {
            return;
        }
        if !self.is_started.load(SeqCst) {
            // If stderr is closed, there is nothing to be done about it.
            let _ = io::stderr().lock().write_all(&text);
            return;
        }
        let mut queue = self.lock();
        let limit = [OWN, FORWARDED][origin as usize];
        if queue.waiting[origin as usize] + text.len() > limit {
            queue.lose(Dropped::of(&text));
        } else {
            queue.waiting[origin as usize] += text.len();
            queue.pieces.push_back((text, origin));
        }
        self.changed.notify_all();
    }

    fn serve(&self) {
        let mut batch = Vec::with_capacity(2 * BATCH);
        let mut queue = self.lock();
        loop {
            queue.take(&mut batch);
            if batch.is_empty() {
                queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            queue.is_writing = true;
            drop(queue);
            // Bit by bit, so that a slow reader is not taken for none. If stderr is closed, it is closed.
            for piece in batch.chunks(4096) {
                let _ = io::stderr().lock().write_all(piece);
                self.lock().written += piece.len() as u64;
                self.changed.notify_all();
            }
            queue = self.lock();
            queue.is_writing = false;
            self.changed.notify_all();
        }
    }
}

struct Queue {
    pieces: VecDeque<(Vec<u8>, Origin)>,
    /// Bytes of the pieces of each origin.
    waiting: [usize; 2],
    /// All that was dropped.
    dropped: Dropped,
    /// What of it stderr does not show yet.
    unsaid: Dropped,
    /// The line below everything else.
    footer: Vec<u8>,
    is_footer_new: bool,
    /// Whether the terminal shows a footer.
    has_footer: bool,
    /// Whether the thread is writing.
    is_writing: bool,
    /// Bytes that were written.
    written: u64,
    /// How many were written when a [`flush`] gave up: the next one does not wait before there are more.
    is_stuck_at: Option<u64>,
}

impl Queue {
    const EMPTY: Self = Self {
        pieces: VecDeque::new(),
        waiting: [0; 2],
        dropped: Dropped { lines: 0, bytes: 0 },
        unsaid: Dropped { lines: 0, bytes: 0 },
        footer: Vec::new(),
        is_footer_new: false,
        has_footer: false,
        is_writing: false,
        written: 0,
        is_stuck_at: None,
    };

    fn lose(&mut self, dropped: Dropped) {
        self.dropped.add(dropped);
        self.unsaid.add(dropped);
    }

    fn is_done(&self) -> bool {
        self.pieces.is_empty() && !self.is_writing && !self.is_footer_new && self.unsaid == Dropped::default()
    }

    /// Fills `batch` with what is to be written next; leaves it empty if that is nothing.
    fn take(&mut self, batch: &mut Vec<u8>) {
        batch.clear();
        if self.pieces.is_empty() && !self.is_footer_new && self.unsaid == Dropped::default() {
            return;
        }
        if self.has_footer {
            batch.extend_from_slice(CLEAR_LINE);
        }
        while batch.len() < BATCH
            && let Some((text, origin)) = self.pieces.pop_front()
        {
            self.waiting[origin as usize] -= text.len();
            batch.extend_from_slice(&text);
        }
        if self.pieces.is_empty() && self.unsaid != Dropped::default() {
            let Dropped { lines, bytes } = std::mem::take(&mut self.unsaid);
            let text =
                format!("[phalanx] stderr was not read fast enough: {lines} lines ({bytes} bytes) were dropped\n");
            batch.extend_from_slice(text.as_bytes());
        }
        batch.extend_from_slice(&self.footer);
        (self.has_footer, self.is_footer_new) = (!self.footer.is_empty(), false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(queue: &mut Queue) -> String {
        let mut batch = Vec::new();
        queue.take(&mut batch);
        String::from_utf8(batch).unwrap()
    }

    #[test]
    fn a_footer_stays_below_and_what_was_dropped_is_reported() {
        let mut queue = Queue::EMPTY;
        assert_eq!(taken(&mut queue), "");
        queue.pieces.push_back((b"one\n".to_vec(), Origin::Own));
        queue.waiting[0] = 4;
        assert_eq!(taken(&mut queue), "one\n");
        (queue.footer, queue.is_footer_new) = (b"50 %".to_vec(), true);
        assert_eq!(taken(&mut queue), "50 %");
        queue.lose(Dropped::of(b"a\nb\n"));
        let reported = "[phalanx] stderr was not read fast enough: 2 lines (4 bytes) were dropped\n";
        assert_eq!(taken(&mut queue), format!("\r\x1b[2K{reported}50 %"));
        (queue.footer, queue.is_footer_new) = (Vec::new(), true);
        assert_eq!(taken(&mut queue), "\r\x1b[2K");
        assert_eq!((taken(&mut queue).as_str(), queue.is_done()), ("", true));
        assert_eq!(queue.dropped, Dropped { lines: 2, bytes: 4 });
    }
}
