//! The place of a log: which file it becomes, and that no other run writes it meanwhile.
//!
//! Where an earlier log stands, a log grows under a temporary name beside its own and takes its own name with its first step. So the log of an earlier run is
//! there until there is something to replace it with, and a reader sees either the old one or the new one. Both names are locked
//! as long as the run goes on; the kernel removes the lock when the process ends, however that happens.

use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read};
use std::os::fd::AsFd;
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use filesystem::{draft_name, follow, holder, is_same};
use rustix::fs::{OFlags, RenameFlags};
use rustix::io::Errno;

use super::LogError;
use super::record::MAGIC;

/// Names that are tried for a log without a name of its own.
const NAMES_MAX: u32 = 10_000;
/// How often the temporary name is tried again after another run has given it up.
const ATTEMPTS: usize = 100;

/// The place of a log that this process writes. No other process writes there as long as a clone of this value, or a recorder that
/// was started on it, is there.
#[derive(Clone, Debug)]
pub struct LogPlace(Arc<Claim>);

#[derive(Debug)]
struct Claim {
    /// As the user knows it.
    path: PathBuf,
    /// The file that it means, links followed.
    target: PathBuf,
    /// Where the log grows until its first step is in it.
    draft: PathBuf,
    /// The file, locked.
    file: File,
    /// Whether the file has its own name.
    published: AtomicBool,
}

impl LogPlace {
    /// Takes the place `path` for a log, and creates the folder that it is in. What stands there stays until the log has its first
    /// step.
    ///
    /// # Errors
    /// [`LogError::Busy`] if another process writes a log there, [`LogError::NoPlace`] if a log cannot stand there,
    /// [`LogError::Write`] if the operating system refuses.
    pub fn claim(path: &Path) -> Result<Self, LogError> {
        let failed = |error| LogError::write(path, error);
        let target = follow(path).map_err(failed)?;
        inspect(path, &target)?;
        let name = target.file_name().ok_or_else(|| no_place(path, "it names a folder"))?;
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        fs::create_dir_all(folder).map_err(failed)?;
        let draft = folder.join(draft_name(name, ""));
        let file = lock_draft(path, &draft)?;
        let claim = Claim { path: path.into(), target, draft, file, published: AtomicBool::new(false) };
        // After the temporary name is locked: a run that writes here holds one of both names at every moment.
        inspect(path, &claim.target)?;
        claim.file.set_len(0).map_err(failed)?;
        Ok(Self(Arc::new(claim)))
    }

    /// The same, or the next free name if another run writes there: `uav-2.mcap`, `uav-3.mcap`.
    ///
    /// # Errors
    /// As those of [`claim`](Self::claim).
    pub fn claim_free(path: &Path) -> Result<Self, LogError> {
        let mut busy = match Self::claim(path) {
            Err(error @ LogError::Busy { .. }) => error,
            result => return result,
        };
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let ending = path.extension().map(|ending| format!(".{}", ending.to_string_lossy())).unwrap_or_default();
        for number in 2..NAMES_MAX {
            let next = path.with_file_name(format!("{stem}-{number}{ending}"));
            if next.symlink_metadata().is_ok() {
                continue;
            }
            match Self::claim(&next) {
                Err(error @ LogError::Busy { .. }) => busy = error,
                result => return result,
            }
        }
        Err(busy)
    }

    /// Where the log will be.
    pub fn path(&self) -> &Path {
        &self.0.path
    }

    /// Whether the log has replaced what stood in its place before.
    pub fn is_published(&self) -> bool {
        self.0.published.load(SeqCst)
    }

    /// Whether another file stands in the place, which the log will replace.
    pub fn replaces(&self) -> bool {
        !self.is_published() && self.0.target.exists()
    }

    /// The file to write to.
    pub(super) fn file(&self) -> io::Result<File> {
        self.0.file.try_clone()
    }

    /// Gives the log its own name.
    ///
    /// # Errors
    /// If the operating system refuses, or another file has taken the place of the log since.
    pub(super) fn publish(&self) -> io::Result<()> {
        let Claim { file, draft, target, published, .. } = &*self.0;
        if !self.is_published() {
            fs::rename(draft, target)?;
            published.store(true, SeqCst);
        }
        match is_same(&file.metadata()?, &target.metadata()?) {
            true => Ok(()),
            false => Err(io::Error::other("another file has taken its place during the run")),
        }
    }

    /// Gives the log its own name if there is no other file of that name; whether it has it then.
    pub(super) fn publish_where_free(&self) -> io::Result<bool> {
        let (here, claim) = (rustix::fs::CWD, &*self.0);
        if self.is_published() {
            return Ok(true);
        }
        match rustix::fs::renameat_with(here, &claim.draft, here, &claim.target, RenameFlags::NOREPLACE) {
            Ok(()) => {
                claim.published.store(true, SeqCst);
                Ok(true)
            }
            Err(Errno::EXIST) => Ok(false),
            // A file system without this flag.
            Err(Errno::INVAL) if !claim.target.exists() => self.publish().map(|()| true),
            Err(Errno::INVAL) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        if !self.published.load(SeqCst) {
            // Before the lock goes, so that the name cannot be that of another run. If it stays, the next run takes it over.
            let _ = fs::remove_file(&self.draft);
        }
    }
}

/// Whether a process is writing the log `path`.
pub fn is_being_written(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| is_written_to(&file))
}

/// Whether a process is writing the log `file`.
pub(super) fn is_written_to(file: &File) -> bool {
    match file.try_lock_shared() {
        Ok(()) => {
            let _ = file.unlock();
            false
        }
        Err(TryLockError::WouldBlock) => true,
        // A file system without locks.
        Err(TryLockError::Error(_)) => false,
    }
}

/// Opens and locks the temporary file.
fn lock_draft(path: &Path, draft: &Path) -> Result<File, LogError> {
    let failed = |error| LogError::write(path, error);
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    for _ in 0..ATTEMPTS {
        let mut options = OpenOptions::new();
        options.read(true).write(true).custom_flags(flags.bits() as i32);
        let (mut file, is_new) = match options.clone().create_new(true).open(draft) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => match options.open(draft) {
                // It has been removed in between.
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                opened => (opened.map_err(failed)?, false),
            },
            created => (created.map_err(failed)?, true),
        };
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(busy(path, &file)),
            // A file system without locks: runs can only be kept apart by their names there.
            Err(TryLockError::Error(_)) => {}
        }
        // In between, its holder may have given it its own name, or removed it.
        let is_there = |found: Metadata| file.metadata().is_ok_and(|own| is_same(&own, &found));
        if !draft.symlink_metadata().is_ok_and(is_there) {
            continue;
        }
        if is_new {
            return Ok(file);
        }
        // What a killed run has left begins as a log and has one name. Anything else belongs to the user.
        let found = file.metadata().map_err(failed)?;
        let is_leftover =
            found.is_file() && found.nlink() == 1 && (found.len() == 0 || starts_as_log(&mut file).map_err(failed)?);
        if !is_leftover {
            return Err(no_place(path, format!("{} is in the way, where the log would grow", draft.display())));
        }
        fs::remove_file(draft).map_err(failed)?;
    }
    Err(failed(io::Error::from(ErrorKind::ResourceBusy)))
}

/// Refuses places where a log would destroy something else, or could not be read back.
fn inspect(path: &Path, target: &Path) -> Result<(), LogError> {
    let found = match target.metadata() {
        Ok(found) => found,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(LogError::write(path, error)),
    };
    let kind = found.file_type();
    let what = match () {
        () if kind.is_dir() => "it is a folder",
        () if kind.is_fifo() => "it is a FIFO, and a log is read back at the end of its run",
        () if kind.is_char_device() || kind.is_block_device() => {
            "it is a device, and a log is read back at the end of its run"
        }
        () if !kind.is_file() => "it is no regular file",
        () if is_a_stream(&found) => "what the program prints goes there",
        () => "",
    };
    if !what.is_empty() {
        return Err(no_place(path, what));
    }
    // Not to write into it, but a file that the user has protected is not replaced.
    let opened = OpenOptions::new().read(true).write(true).open(target);
    let mut file = opened.map_err(|error| LogError::write(path, error))?;
    if is_written_to(&file) {
        return Err(busy(path, &file));
    }
    let is_log = starts_as_log(&mut file).map_err(|error| LogError::write(path, error))?;
    match is_log || found.len() == 0 {
        true => Ok(()),
        false => Err(no_place(path, "it is a file of another kind, which would be lost")),
    }
}

/// Whether a file begins with the magic bytes of a log.
pub fn starts_as_log(file: &mut impl Read) -> io::Result<bool> {
    let mut start = [0; MAGIC.len()];
    match file.read_exact(&mut start) {
        Ok(()) => Ok(start == MAGIC),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}

/// Whether it is where this program prints to.
fn is_a_stream(found: &Metadata) -> bool {
    let (stdout, stderr) = (io::stdout(), io::stderr());
    let is_it = |stream: rustix::fd::BorrowedFd| {
        rustix::fs::fstat(stream).is_ok_and(|own| (own.st_dev, own.st_ino) == (found.dev(), found.ino()))
    };
    is_it(stdout.as_fd()) || is_it(stderr.as_fd())
}

fn no_place(path: &Path, what: impl Into<String>) -> LogError {
    LogError::NoPlace { path: path.into(), what: what.into() }
}

fn busy(path: &Path, file: &File) -> LogError {
    LogError::Busy { path: path.into(), writer: holder(file) }
}

#[cfg(test)]
mod tests {
    use filesystem::HeldDirectory;

    use super::*;

    /// A folder that goes away with the test.
    fn folder() -> HeldDirectory {
        HeldDirectory::create_in(&std::env::temp_dir(), "phalanx-test-").unwrap()
    }

    fn names(folder: &HeldDirectory) -> Vec<String> {
        let names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    #[test]
    fn one_process_writes_a_log_at_a_time() {
        let folder = folder();
        let path = folder.path().join("run.mcap");
        let first = LogPlace::claim(&path).unwrap();
        let refused = |path: &Path| match LogPlace::claim(path) {
            Err(LogError::Busy { writer, .. }) => writer,
            other => panic!("{other:?}"),
        };
        assert!(refused(&path).contains(&format!("process {}", std::process::id())));
        first.publish().unwrap();
        assert_eq!((names(&folder), first.is_published()), (vec!["run.mcap".into()], true));
        assert!(refused(&path).starts_with("process"));
        std::os::unix::fs::symlink(&path, folder.path().join("link.mcap")).unwrap();
        refused(&folder.path().join("link.mcap"));
        let second = LogPlace::claim_free(&path).unwrap();
        let third = LogPlace::claim_free(&path).unwrap();
        assert_eq!([second.path(), third.path()], ["run-2.mcap", "run-3.mcap"].map(|name| folder.path().join(name)));
        drop(first);
        assert!(LogPlace::claim(&path).unwrap().replaces());
        drop((second, third));
        assert_eq!(names(&folder), ["link.mcap", "run.mcap"], "what was not published leaves nothing");
    }

    #[test]
    fn an_earlier_file_stays_until_there_is_something_to_replace_it() {
        let folder = folder();
        let path = folder.path().join("run.mcap");
        fs::write(&path, MAGIC).unwrap();
        let place = LogPlace::claim(&path).unwrap();
        assert!(place.replaces() && fs::read(&path).unwrap() == MAGIC);
        drop(place);
        assert_eq!((fs::read(&path).unwrap(), names(&folder)), (MAGIC.to_vec(), vec!["run.mcap".into()]));
        let place = LogPlace::claim(&path).unwrap();
        assert!(!place.publish_where_free().unwrap() && fs::read(&path).unwrap() == MAGIC);
        let free = LogPlace::claim(&folder.path().join("free.mcap")).unwrap();
        assert!(free.publish_where_free().unwrap() && free.is_published() && free.path().exists());
        place.publish().unwrap();
        assert_eq!((fs::read(&path).unwrap().len(), place.replaces()), (0, false));
        place.publish().unwrap();
        fs::remove_file(&path).unwrap();
        fs::write(&path, MAGIC).unwrap();
        assert!(place.publish().unwrap_err().to_string().contains("another file"));
    }

    #[test]
    fn a_log_replaces_nothing_but_logs() {
        let folder = folder();
        let make = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            path
        };
        let refusal = |path: &Path| match LogPlace::claim(path) {
            Err(LogError::NoPlace { what, .. }) => what,
            other => panic!("{other:?}"),
        };
        assert!(refusal(&make("scenario.toml", "name = \"a\"\n")).contains("another kind"));
        assert!(refusal(&make("short", "a")).contains("another kind"));
        LogPlace::claim(&make("empty.mcap", "")).unwrap();
        assert!(refusal(folder.path()).contains("folder"));
        assert!(refusal(Path::new("/dev/full")).contains("device"));
        let fifo = folder.path().join("fifo");
        rustix::fs::mknodat(rustix::fs::CWD, &fifo, rustix::fs::FileType::Fifo, 0o600.into(), 0).unwrap();
        assert!(refusal(&fifo).contains("FIFO"));
        let protected = make("protected.mcap", "");
        fs::set_permissions(&protected, std::os::unix::fs::PermissionsExt::from_mode(0o400)).unwrap();
        if !rustix::process::geteuid().is_root() {
            assert!(matches!(LogPlace::claim(&protected), Err(LogError::Write { .. })));
        }
        fs::write(folder.path().join("input.mcap"), [MAGIC, b"steps"].concat()).unwrap();
        fs::hard_link(folder.path().join("input.mcap"), folder.path().join(".x.mcap.part")).unwrap();
        assert!(refusal(&folder.path().join("x.mcap")).contains(".x.mcap.part is in the way"));
        make(".y.mcap.part", "notes");
        assert!(refusal(&folder.path().join("y.mcap")).contains(".y.mcap.part is in the way"));
        fs::remove_file(folder.path().join(".x.mcap.part")).unwrap();
        fs::remove_file(folder.path().join(".y.mcap.part")).unwrap();
        assert_eq!(fs::read(folder.path().join("input.mcap")).unwrap(), [MAGIC, b"steps"].concat());
        std::os::unix::fs::symlink("loop", folder.path().join("loop")).unwrap();
        assert!(matches!(LogPlace::claim(&folder.path().join("loop")), Err(LogError::Write { .. })));
        let left: Vec<String> = names(&folder).into_iter().filter(|name| name.ends_with(".part")).collect();
        assert!(left.is_empty(), "{left:?}");
    }

    #[test]
    fn a_long_name_has_a_temporary_one() {
        let folder = folder();
        let path = folder.path().join(format!("{}.mcap", "n".repeat(245)));
        let place = LogPlace::claim(&path).unwrap();
        place.publish().unwrap();
        assert_eq!(names(&folder).len(), 1);
    }
}
