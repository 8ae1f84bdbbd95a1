//! What the children print: passed on with their names, and the last lines kept for reports.

use std::collections::VecDeque;
use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{self, IsTerminal, PipeReader, Read, Write};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::poll::Poll;
use crate::console;

/// How many lines are kept per child.
const KEPT_LINES: usize = 20;
/// Longer lines are cut into pieces of this many bytes.
const LINE_BYTES: usize = 4096;
/// So much is read at once.
const READ_BYTES: usize = 64 << 10;

/// Reads the pipes of all children in one thread.
pub(super) struct OutputReader {
    outputs: Arc<Outputs>,
    poll: Poll,
    /// Where a file per child is written.
    folder: Option<PathBuf>,
}

#[derive(Default)]
struct Outputs {
    list: Mutex<Vec<Output>>,
    /// Signalled whenever a pipe ends.
    ended: Condvar,
}

struct Output {
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

impl Outputs {
    fn lock(&self) -> MutexGuard<'_, Vec<Output>> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl OutputReader {
    /// Starts the thread. Lines are passed on to stderr if `forward`; those for which stderr has no room are dropped.
    pub(super) fn start(forward: bool) -> io::Result<Self> {
        let outputs = Arc::new(Outputs::default());
        let shared = Arc::clone(&outputs);
        let mut buffer = vec![0; READ_BYTES];
        let colour = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        if forward {
            console::start();
        }
        let poll = Poll::start("phalanx-output", move |token| {
            let mut list = shared.lock();
            let output = &mut list[token];
            let fresh = output.read(&mut buffer);
            let name = if colour { in_colour(token, &output.name) } else { format!("[{}]", output.name) };
            drop(list);
            shared.ended.notify_all();
            if forward && console::has_room() {
                console::forward(with_name(&name, &fresh));
            } else if forward {
                console::drop_lines(&fresh);
            }
        })?;
        Ok(Self { outputs, poll, folder: None })
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
                let path = folder.join(format!("{name}.log"));
                // A child that is started anew goes on in the file of the one before.
                let is_first = !self.outputs.lock().iter().any(|output| output.worker == worker);
                Some(if is_first { console::new_file(&path)? } else { OpenOptions::new().append(true).open(path)? })
            }
            None => None,
        };
        let mut list = self.outputs.lock();
        // The thread finds the output, since it has to wait for the lock.
        self.poll.add(&pipe, list.len(), false)?;
        let (partial, lines) = (Vec::new(), VecDeque::new());
        list.push(Output { worker, name: name.into(), pipe: Some(pipe), partial, lines, file });
        Ok(())
    }

    /// The last lines of a child. Waits for the end of its output for `patience`, since a dead child may not be read yet.
    pub(super) fn last_lines(&self, worker: usize, patience: Duration) -> Vec<String> {
        let is_open =
            |list: &mut Vec<Output>| list.iter().any(|output| output.worker == worker && output.pipe.is_some());
        let waited = self.outputs.ended.wait_timeout_while(self.outputs.lock(), patience, is_open);
        let (list, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let outputs = list.iter().filter(|output| output.worker == worker);
        outputs.flat_map(|output| output.lines.iter().cloned()).collect()
    }
}

impl Output {
    /// Reads what is there; returns the lines that are complete now, each with its end.
    fn read(&mut self, buffer: &mut [u8]) -> Vec<u8> {
        let count = match self.pipe.as_mut().map(|pipe| pipe.read(buffer)) {
            Some(Ok(count)) => count,
            Some(Err(error)) if error.kind() == io::ErrorKind::Interrupted => return Vec::new(),
            _ => 0,
        };
        let mut lines = std::mem::take(&mut self.partial);
        lines.extend_from_slice(&buffer[..count]);
        if count == 0 {
            self.pipe = None;
            if !lines.is_empty() {
                lines.push(b'\n');
            }
        }
        let end = lines.iter().rposition(|&byte| byte == b'\n').map_or(0, |place| place + 1);
        self.partial = lines.split_off(end);
        if self.partial.len() >= LINE_BYTES {
            lines.append(&mut self.partial);
            lines.push(b'\n');
        }
        self.keep(&lines);
        lines
    }

    /// Writes lines into the file, and keeps the last of them.
    fn keep(&mut self, lines: &[u8]) {
        if let Some(file) = &mut self.file
            && file.write_all(lines).is_err()
        {
            // A full disk ends the file, not the run.
            self.file = None;
        }
        let last: Vec<&[u8]> = pieces(lines).rev().take(KEPT_LINES).collect();
        self.lines.extend(last.into_iter().rev().map(text));
        let surplus = self.lines.len().saturating_sub(KEPT_LINES);
        self.lines.drain(..surplus);
    }
}

/// Lines without their ends.
fn pieces(lines: &[u8]) -> impl DoubleEndedIterator<Item = &[u8]> {
    lines.strip_suffix(b"\n").into_iter().flat_map(|lines| lines.split(|&byte| byte == b'\n'))
}

/// A line as text; of one that is too long, the begin.
fn text(line: &[u8]) -> String {
    let line = line.strip_suffix(b"\r").unwrap_or(line);
    String::from_utf8_lossy(&line[..line.len().min(LINE_BYTES)]).into_owned()
}

/// The lines with a name in front of each. Those that are too long are cut into pieces.
fn with_name(name: &str, lines: &[u8]) -> Vec<u8> {
    let mut named = Vec::with_capacity(2 * lines.len());
    for line in pieces(lines) {
        let parts = line.chunks(LINE_BYTES).chain(line.is_empty().then_some(line));
        parts.for_each(|part| {
            named.extend_from_slice(name.as_bytes());
            named.push(b' ');
            named.extend_from_slice(text(part).as_bytes());
            named.push(b'\n');
        });
    }
    named
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
        let output_reader = OutputReader::start(false).unwrap();
        let (reader, mut writer) = io::pipe().unwrap();
        output_reader.add(3, "child", reader).unwrap();
        for number in 0..50 {
            writeln!(writer, "line {number}").unwrap();
        }
        write!(writer, "unfinished").unwrap();
        drop(writer);
        let lines = output_reader.last_lines(3, Duration::from_secs(10));
        assert_eq!(lines.len(), KEPT_LINES);
        assert_eq!((lines[0].as_str(), lines[KEPT_LINES - 1].as_str()), ("line 31", "unfinished"));
        assert!(output_reader.last_lines(4, Duration::from_secs(10)).is_empty());
    }

    #[test]
    fn all_lines_are_kept_in_a_file() {
        let folder = std::env::temp_dir().join(format!("phalanx-output-{}", std::process::id()));
        let mut output_reader = OutputReader::start(false).unwrap();
        output_reader.keep_in(&folder).unwrap();
        for _ in 0..2 {
            let (reader, mut writer) = io::pipe().unwrap();
            output_reader.add(3, "child", reader).unwrap();
            (0..50).for_each(|number| writeln!(writer, "line {number}").unwrap());
            drop(writer);
            output_reader.last_lines(3, Duration::from_secs(10));
        }
        let text = std::fs::read_to_string(folder.join("child.log")).unwrap();
        assert_eq!(text.lines().count(), 100, "the second process went on where the first had ended");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn long_lines_are_cut_and_bytes_become_text() {
        let named = String::from_utf8(with_name("[x]", b"one\r\n\n\xff\n")).unwrap();
        assert_eq!(named, "[x] one\n[x] \n[x] \u{fffd}\n");
        let long = [vec![b'y'; 2 * LINE_BYTES + 1], vec![b'\n']].concat();
        assert_eq!(with_name("[x]", &long).split(|&byte| byte == b'\n').count(), 4);
        assert!(with_name("[x]", b"").is_empty());
        let output_reader = OutputReader::start(false).unwrap();
        let (reader, mut writer) = io::pipe().unwrap();
        output_reader.add(0, "child", reader).unwrap();
        let sending = std::thread::spawn(move || writer.write_all(&vec![b'z'; 1 << 20]));
        let lines = output_reader.last_lines(0, Duration::from_secs(10));
        sending.join().unwrap().unwrap();
        assert!(!lines.is_empty() && lines.iter().all(|line| line.len() <= LINE_BYTES));
    }

    #[test]
    fn neighbours_differ_in_colour() {
        assert_eq!(in_colour(0, "plant"), "\u{1b}[38;5;33m[plant]\u{1b}[0m");
        assert_ne!(in_colour(1, "a"), in_colour(2, "a"));
    }
}
