//! The shared memory of runs: files in `/dev/shm` whose names begin with that of the run.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FallocateFlags, OFlags, fallocate};

use super::{DirectoryError, SHARED_MEMORY, at, prefix, tolerate_absence};

/// A file in shared memory that is called like one of a run.
struct Segment {
    run: String,
    path: PathBuf,
}

impl Segment {
    /// Whether it is a file of this user; all else under such a name is left as it is.
    fn is_own(&self) -> bool {
        let user = rustix::process::getuid().as_raw();
        fs::symlink_metadata(&self.path).is_ok_and(|found| found.is_file() && found.uid() == user)
    }
}

/// The names of all runs that anything in shared memory is called after, whichever process made it.
pub(super) fn runs() -> Result<BTreeSet<String>, DirectoryError> {
    Ok(all()?.into_iter().map(|segment| segment.run).collect())
}

/// The shared memory of a run, with its sizes.
pub(super) fn sizes(run: &str) -> Result<Vec<(PathBuf, u64)>, DirectoryError> {
    let size = |path: PathBuf| Some((fs::symlink_metadata(&path).ok()?.len(), path));
    Ok(own(run)?.into_iter().filter_map(size).map(|(size, path)| (path, size)).collect())
}

/// Removes the shared memory of a run.
pub(super) fn remove(run: &str) -> Result<(), DirectoryError> {
    let removed =
        own(run)?.into_iter().map(|path| tolerate_absence(fs::remove_file(&path)).map_err(at(&path, "remove")));
    removed.fold(Ok(()), Result::and)
}

/// Removes the shared memory of the runs that are not `alive`; returns their names.
pub(super) fn remove_others(is_alive: impl Fn(&str) -> bool) -> Result<Vec<String>, DirectoryError> {
    let segments = all()?;
    let orphans = segments.into_iter().filter(|segment| !is_alive(&segment.run) && segment.is_own());
    Ok(orphans.filter(|orphan| fs::remove_file(&orphan.path).is_ok()).map(|orphan| orphan.run).collect())
}

/// Takes from other users what iceoryx2 has opened to them: a counter of 16 bytes. And takes the memory that was only
/// promised so far: if others filled it meanwhile, a process that writes to it would be killed.
pub(super) fn protect(run: &str) -> Result<(), DirectoryError> {
    for path in own(run)? {
        let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
        let file = OpenOptions::new().write(true).custom_flags(flags.bits() as i32).open(&path);
        let taken = file.and_then(|file| {
            file.set_permissions(fs::Permissions::from_mode(0o600))?;
            reserve(&file)
        });
        tolerate_absence(taken).map_err(at(&path, "reserve memory for"))?;
    }
    Ok(())
}

fn reserve(file: &File) -> io::Result<()> {
    match file.metadata()?.len() {
        0 => Ok(()),
        length => Ok(fallocate(file, FallocateFlags::empty(), 0, length)?),
    }
}

fn own(run: &str) -> Result<Vec<PathBuf>, DirectoryError> {
    let segments = all()?.into_iter();
    Ok(segments.filter(|segment| segment.run == run && segment.is_own()).map(|segment| segment.path).collect())
}

/// All that is called like shared memory of a run of this user.
fn all() -> Result<Vec<Segment>, DirectoryError> {
    let shared_memory = Path::new(SHARED_MEMORY);
    let prefix = prefix("");
    let prefix = prefix.trim_end_matches('_');
    let entries = fs::read_dir(shared_memory).map_err(at(shared_memory, "read"))?.flatten();
    let segment = |entry: fs::DirEntry| {
        let name = entry.file_name().into_string().ok()?;
        let (run, _) = name.strip_prefix(prefix)?.split_once('_')?;
        Some(Segment { run: run.into(), path: entry.path() })
    };
    Ok(entries.filter_map(segment).collect())
}
