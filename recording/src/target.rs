//! Where a log goes: what is written stays; what is shown stands behind it until something is written.
//!
//! A chunk is written when it is full, so that equal runs give equal bytes, however slow they are. Of a slow run, a chunk takes
//! seconds to fill. What has come together so far is shown in the meantime: it stands behind what is written in chunks of their
//! own, not compressed, for readers of the log of a run that goes on or was killed. The compressed chunk takes their place.
//!
//! What a reader could read once stays readable when writing fails: chunks that are shown are only appended, and they give way when
//! the file system has room for what replaces them.

use std::fs::File;
use std::io;
#[cfg(test)]
use std::io::Write;
use std::os::unix::fs::FileExt;

use rustix::fs::FallocateFlags;
use rustix::process::{Resource, getrlimit};

use super::place::LogPlace;

/// What a log is written to.
pub(super) trait Target: Send {
    /// Writes `bytes` in the place of all that is shown, and leaves room for `reserve` bytes more.
    ///
    /// # Errors
    /// If they cannot be written; what was written and shown before is still there then.
    fn write(&mut self, bytes: &[u8], reserve: u64) -> io::Result<()>;

    /// Shows `bytes` behind what is shown already, and leaves room for `reserve` bytes more.
    ///
    /// # Errors
    /// As those of [`write`](Self::write).
    fn show(&mut self, _bytes: &[u8], _reserve: u64) -> io::Result<()> {
        Ok(())
    }

    /// Whether anything is shown that is not written yet.
    fn shows(&self) -> bool {
        false
    }

    /// Lets the file take its place, in which an earlier one only gives way to a file with a step. Returns whether it has its place.
    ///
    /// # Errors
    /// If the operating system refuses.
    fn publish(&mut self, _has_step: bool) -> io::Result<bool> {
        Ok(true)
    }
}

impl<T: Target + ?Sized> Target for Box<T> {
    fn write(&mut self, bytes: &[u8], reserve: u64) -> io::Result<()> {
        (**self).write(bytes, reserve)
    }

    fn show(&mut self, bytes: &[u8], reserve: u64) -> io::Result<()> {
        (**self).show(bytes, reserve)
    }

    fn shows(&self) -> bool {
        (**self).shows()
    }

    fn publish(&mut self, has_step: bool) -> io::Result<bool> {
        (**self).publish(has_step)
    }
}

/// A file in its place.
pub(super) struct LogFile {
    file: File,
    place: LogPlace,
    /// Bytes that are written.
    written: u64,
    /// Bytes that are shown behind them.
    shown: u64,
    /// Largest size that the operating system allows, bytes.
    limit: u64,
}

impl LogFile {
    /// An empty file.
    pub(super) fn new(place: LogPlace) -> io::Result<Self> {
        let limit = getrlimit(Resource::Fsize).current.unwrap_or(u64::MAX);
        Ok(Self { file: place.file()?, place, written: 0, shown: 0, limit })
    }

    fn end(&self) -> u64 {
        self.written + self.shown
    }

    /// Whether a file of this size is allowed. The kernel would tell by a signal.
    fn check_limit(&self, size: u64) -> io::Result<()> {
        if size > self.limit { Err(rustix::io::Errno::FBIG.into()) } else { Ok(()) }
    }

    /// Writes at the end of the file, all or nothing.
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all_at(bytes, self.end()).inspect_err(|_| {
            let _ = self.file.set_len(self.end());
        })
    }
}

impl Target for LogFile {
    fn write(&mut self, bytes: &[u8], reserve: u64) -> io::Result<()> {
        let length = bytes.len() as u64;
        self.check_limit(self.written + length + reserve)?;
        if self.shown == 0 {
            self.append(bytes)?;
        } else {
            if length > self.shown {
                // So that the rest cannot fail when what is shown has been overwritten. Not every file system can do it.
                let more = length - self.shown;
                match rustix::fs::fallocate(&self.file, FallocateFlags::KEEP_SIZE, self.end(), more) {
                    Ok(()) | Err(rustix::io::Errno::OPNOTSUPP | rustix::io::Errno::NOSYS) => {}
                    Err(error) => return Err(error.into()),
                }
            }
            self.file.write_all_at(bytes, self.written)?;
            if length < self.shown {
                self.file.set_len(self.written + length)?;
            }
        }
        (self.written, self.shown) = (self.written + length, 0);
        Ok(())
    }

    fn show(&mut self, bytes: &[u8], reserve: u64) -> io::Result<()> {
        let length = bytes.len() as u64;
        self.check_limit(self.end() + length + reserve)?;
        self.append(bytes)?;
        self.shown += length;
        Ok(())
    }

    fn shows(&self) -> bool {
        self.shown > 0
    }

    fn publish(&mut self, has_step: bool) -> io::Result<bool> {
        match has_step {
            true => self.place.publish().map(|()| true),
            false => self.place.publish_where_free(),
        }
    }
}

/// Anything else that bytes go to, which shows nothing.
#[cfg(test)]
pub(super) struct Plain<W>(pub(super) W);

#[cfg(test)]
impl<W: Write + Send> Target for Plain<W> {
    fn write(&mut self, bytes: &[u8], _: u64) -> io::Result<()> {
        self.0.write_all(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use filesystem::HeldDirectory;

    use super::*;

    #[test]
    fn what_was_shown_stays_when_there_is_no_room_for_what_replaces_it() {
        let folder = HeldDirectory::create_in(&std::env::temp_dir(), "phalanx-test-").unwrap();
        let path = folder.path().join("run.mcap");
        let mut file = LogFile::new(LogPlace::claim(&path).unwrap()).unwrap();
        file.limit = 100;
        file.write(&[1; 30], 50).unwrap();
        file.publish(true).unwrap();
        let content = || fs::read(&path).unwrap();
        file.show(&[2; 10], 50).unwrap();
        file.show(&[3; 10], 50).unwrap();
        let before = [[1; 30].as_slice(), &[2; 10], &[3; 10]].concat();
        assert_eq!((content(), file.shows()), (before.clone(), true));
        assert_eq!(file.show(&[4; 1], 50).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(file.write(&[5; 21], 50).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!((content(), file.shows()), (before, true));
        file.write(&[6; 15], 50).unwrap();
        assert_eq!((content(), file.shows()), ([[1; 30].as_slice(), &[6; 15]].concat(), false));
        file.show(&[7; 5], 50).unwrap();
        file.write(&[8; 55], 0).unwrap();
        assert_eq!(content(), [[1; 30].as_slice(), &[6; 15], &[8; 55]].concat());
    }
}
