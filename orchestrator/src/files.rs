//! Files that commands write: none takes the place of what the command reads or of a log, and none stands half written in the place
//! of an earlier one.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use filesystem::{draft_name, draft_of, follow, is_same_file};
use rustix::fs::OFlags;
use rustix::io::Errno;

use crate::failure::Failure;
use recording::starts_as_log;

/// Refuses an output that is one of the inputs, by path, link, or hard link.
///
/// # Errors
/// [`Failure::Usage`] that names both.
pub(crate) fn spare<P: AsRef<Path>>(output: &Path, inputs: impl IntoIterator<Item = P>) -> Result<(), Failure> {
    let draft = draft_of(output);
    for input in inputs {
        let input = input.as_ref();
        if means_same(output, input) || draft.as_ref().is_some_and(|draft| means_same(draft, input)) {
            return Err(Failure::Usage(format!(
                "{} cannot be written: it is {}, which this command reads or writes, too; name another file",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}

fn means_same(one: &Path, other: &Path) -> bool {
    let absolute = |path: &Path| follow(path).and_then(std::path::absolute).ok();
    is_same_file(one, other) || absolute(one).is_some_and(|path| absolute(other) == Some(path))
}

/// A file that takes its place when it is complete. A FIFO or a device is written to directly.
pub(crate) struct OutFile {
    file: BufWriter<File>,
    draft: Option<Draft>,
}

/// A file under its temporary name; removed unless it gets its own.
struct Draft {
    path: PathBuf,
    target: PathBuf,
}

impl OutFile {
    /// Starts the file `path`.
    ///
    /// # Errors
    /// What the operating system says; that `path` is a log, a folder, or a FIFO that no process reads.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        let target = follow(path)?;
        match target.metadata() {
            Ok(found) if found.is_dir() => return Err(Errno::ISDIR.into()),
            Ok(found) if found.is_file() => {
                // Not to write into it, but a file that the user has protected is not replaced.
                let mut earlier = OpenOptions::new().read(true).write(true).open(&target)?;
                if starts_as_log(&mut earlier)? {
                    let what = "it is a log, which would be lost; name another file";
                    return Err(io::Error::new(ErrorKind::AlreadyExists, what));
                }
            }
            Ok(_) => return Ok(Self { file: BufWriter::new(open_special(&target)?), draft: None }),
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
        let name = target.file_name().ok_or(Errno::ISDIR)?;
        let path = target.with_file_name(draft_name(name, &format!(".{}", std::process::id())));
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(true).custom_flags(OFlags::NOFOLLOW.bits() as i32);
        let file = BufWriter::new(options.open(&path)?);
        Ok(Self { file, draft: Some(Draft { path, target }) })
    }

    /// Gives the file its place.
    ///
    /// # Errors
    /// What the operating system says; an earlier file is there then as it was.
    pub(crate) fn commit(mut self) -> io::Result<()> {
        self.file.flush()?;
        match &self.draft {
            Some(draft) => fs::rename(&draft.path, &draft.target),
            None => Ok(()),
        }
    }
}

impl Write for OutFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // Once it has its own name, there is nothing here.
        let _ = fs::remove_file(&self.path);
    }
}

/// Writes a file in one piece.
///
/// # Errors
/// As those of [`OutFile::create`] and [`OutFile::commit`].
pub(crate) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = OutFile::create(path)?;
    file.write_all(bytes.as_ref())?;
    file.commit()
}

/// Finds out before a long command whether a file can be written at its end, and spares the inputs.
///
/// # Errors
/// As those of [`spare`], and [`Failure::System`] as [`OutFile::create`] fails.
pub(crate) fn prepare<P: AsRef<Path>>(output: &Path, inputs: impl IntoIterator<Item = P>) -> Result<(), Failure> {
    spare(output, inputs)?;
    let tried = follow(output).and_then(|target| match target.metadata() {
        // A reader of a FIFO would see the end of it.
        Ok(found) if !found.is_file() && !found.is_dir() => Ok(()),
        _ => OutFile::create(output).map(drop),
    });
    tried.map_err(Failure::system(format!("write {}", output.display())))
}

/// Opens a FIFO or a device without waiting for a reader.
fn open_special(path: &Path) -> io::Result<File> {
    let opened = OpenOptions::new().write(true).custom_flags(OFlags::NONBLOCK.bits() as i32).open(path);
    let file = opened.map_err(|error| match Errno::from_io_error(&error) {
        Some(Errno::NXIO) => io::Error::new(ErrorKind::NotConnected, "it is a FIFO that no process reads"),
        _ => error,
    })?;
    let flags = rustix::fs::fcntl_getfl(&file)?;
    rustix::fs::fcntl_setfl(&file, flags - OFlags::NONBLOCK)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use filesystem::HeldDirectory;

    use super::*;

    fn folder() -> HeldDirectory {
        HeldDirectory::create_in(&std::env::temp_dir(), "phalanx-test-").unwrap()
    }

    fn count(folder: &HeldDirectory) -> usize {
        fs::read_dir(folder.path()).unwrap().count()
    }

    #[test]
    fn an_output_is_no_input() {
        let folder = folder();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "a").unwrap();
        fs::write(path("b"), "b").unwrap();
        std::os::unix::fs::symlink("a", path("link")).unwrap();
        fs::hard_link(path("a"), path("hard")).unwrap();
        for name in ["a", "link", "hard", "../x/../a"] {
            let output = path(name.rsplit('/').next().unwrap());
            assert!(matches!(spare(&output, [path("b"), path("a")]), Err(Failure::Usage(_))), "{name}");
        }
        assert!(matches!(spare(&path("new"), [path("new")]), Err(Failure::Usage(_))), "two outputs, none there yet");
        assert!(matches!(spare(&path("x"), [path(".x.part")]), Err(Failure::Usage(_))), "where it would grow");
        spare(&path("b"), [path("a")]).unwrap();
        spare(&path("new"), [path("a"), path("b")]).unwrap();
    }

    #[test]
    fn a_file_takes_its_place_when_it_is_complete() {
        let folder = folder();
        let path = folder.path().join("report.html");
        write(&path, "old").unwrap();
        let mut file = OutFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(file);
        assert_eq!((fs::read(&path).unwrap(), count(&folder)), (b"old".to_vec(), 1), "given up");
        write(&path, "new").unwrap();
        assert_eq!((fs::read(&path).unwrap(), count(&folder)), (b"new".to_vec(), 1));
        write(&folder.path().join("n".repeat(255)), "a name as long as names may be").unwrap();
        assert_eq!(count(&folder), 2);
    }

    #[test]
    fn what_is_no_file_is_written_directly_or_refused() {
        let folder = folder();
        write(Path::new("/dev/null"), "text").unwrap();
        assert_eq!(write(Path::new("/dev/full"), "text").unwrap_err().kind(), ErrorKind::StorageFull);
        assert_eq!(write(folder.path(), "text").unwrap_err().kind(), ErrorKind::IsADirectory);
        let fifo = folder.path().join("fifo");
        rustix::fs::mknodat(rustix::fs::CWD, &fifo, rustix::fs::FileType::Fifo, 0o600.into(), 0).unwrap();
        assert!(write(&fifo, "text").unwrap_err().to_string().contains("no process reads"));
        let reader = OpenOptions::new().read(true).custom_flags(OFlags::NONBLOCK.bits() as i32).open(&fifo).unwrap();
        write(&fifo, "text").unwrap();
        assert_eq!(io::read_to_string(reader).unwrap(), "text");
        let log = folder.path().join("run.mcap");
        fs::write(&log, b"\x89MCAP0\r\n and more").unwrap();
        assert!(write(&log, "text").unwrap_err().to_string().contains("it is a log"));
        assert_eq!(count(&folder), 2);
    }
}
