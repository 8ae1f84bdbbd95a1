//! Where a log goes: what is written stays; what is shown stands behind it until something is written.
//!
//! A chunk is written when it is full, so that equal runs give equal bytes, however slow they are. Of a slow run, a chunk takes
//! seconds to fill. What has come together so far is shown in the meantime: it stands at the end of the file as a chunk of its
//! own, for whoever reads the log of a run that goes on or was killed, and gives way to what is written next.

use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;

/// What a log is written to.
pub(super) trait Target: Write + Send {
    /// Puts `bytes` behind what is written, in the place of what was shown before.
    fn show(&mut self, bytes: &[u8]) -> io::Result<()>;
}

impl<T: Target + ?Sized> Target for Box<T> {
    fn show(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).show(bytes)
    }
}

/// A file.
pub(super) struct LogFile {
    file: File,
    /// Bytes that were written.
    written: u64,
    /// Whether anything is shown behind them.
    shows: bool,
    /// Whether it is a file in which one can go back, and not a pipe or a device.
    is_regular: bool,
}

impl LogFile {
    /// An empty file.
    pub(super) fn new(file: File) -> io::Result<Self> {
        let is_regular = file.metadata()?.is_file();
        Ok(Self { file, written: 0, shows: false, is_regular })
    }
}

impl Write for LogFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.shows {
            self.file.set_len(self.written)?;
            self.shows = false;
        }
        let count = self.file.write(bytes)?;
        self.written += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Target for LogFile {
    fn show(&mut self, bytes: &[u8]) -> io::Result<()> {
        if !self.is_regular {
            return Ok(());
        }
        self.shows = true;
        // It only grows until something is written, so nothing of an earlier one remains behind it.
        self.file.write_all_at(bytes, self.written)
    }
}

/// Anything else that bytes go to, which shows nothing.
pub(super) struct Plain<W>(pub(super) W);

impl<W: Write> Write for Plain<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl<W: Write + Send> Target for Plain<W> {
    fn show(&mut self, _: &[u8]) -> io::Result<()> {
        Ok(())
    }
}
