//! Directories that a process holds: locked while it lives, and removed without a step beyond them.
//!
//! They stand in places where every user may make anything under any name. So a name is never followed (`O_NOFOLLOW`), never
//! waited for (`O_NONBLOCK`, locks are only tried), and what is not a directory of this user alone is left as it is.

use std::ffi::{CStr, CString};
use std::fs::{self, DirBuilder, File, OpenOptions, TryLockError};
use std::io;
use std::os::fd::AsFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rustix::fs::{AtFlags, Dir, Mode, OFlags, RenameFlags, ResolveFlags};
use rustix::io::Errno;

/// How often a new name is tried before creating a directory is given up.
const ATTEMPTS: usize = 100;
/// Folders within each other that are removed; what is deeper is left with an error.
const MAX_DEPTH: usize = 128;

/// A directory of this user alone, locked by this process, and removed with the value.
#[derive(Debug)]
pub struct HeldDirectory {
    path: PathBuf,
    /// The directory itself: nothing in it has to be there for the lock to hold.
    lock: File,
    /// Nothing is left to be removed.
    removed: bool,
}

/// What stands under a name.
#[derive(Debug)]
pub enum Found {
    /// A directory of this user whose holder is dead; this process holds it from now on.
    Abandoned(HeldDirectory),
    /// A directory of this user that a process holds.
    Held,
    /// Anything else.
    Foreign,
}

impl HeldDirectory {
    /// Creates a directory in `parent` whose name begins with `prefix`, with the number of this process behind it.
    ///
    /// # Errors
    /// That of the operating system if it refuses, or if every name that was tried is taken.
    pub fn create_in(parent: &Path, prefix: &str) -> io::Result<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        for _ in 0..ATTEMPTS {
            let number = COUNT.fetch_add(1, Relaxed);
            let path = parent.join(format!("{prefix}{}-{number}", std::process::id()));
            match DirBuilder::new().mode(0o700).create(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                result => result?,
            }
            // In between, a sweep may have taken it for that of a dead process.
            if let Found::Abandoned(directory) = Self::find(&path) {
                return Ok(directory);
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, "every name that was tried is taken"))
    }

    /// Removes all directories in `parent` whose names begin with `prefix` and whose holders are dead; returns their paths.
    ///
    /// What belongs to others, is no directory, or cannot be removed is left, without an error.
    pub fn sweep_in(parent: &Path, prefix: &str) -> Vec<PathBuf> {
        let entries = fs::read_dir(parent).into_iter().flatten().flatten();
        let named = entries.filter(|entry| entry.file_name().as_bytes().starts_with(prefix.as_bytes()));
        let abandoned = named.filter_map(|entry| match Self::find(&entry.path()) {
            Found::Abandoned(directory) => Some(directory),
            _ => None,
        });
        abandoned
            .filter_map(|directory| Some((directory.path.clone(), directory.remove().ok()?)).map(|(path, ())| path))
            .collect()
    }

    /// What stands under a name; takes it if its holder is dead.
    pub fn find(path: &Path) -> Found {
        let Ok(lock) = open_own(path) else { return Found::Foreign };
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Found::Held,
            Err(TryLockError::Error(_)) => return Found::Foreign,
        }
        // Its holder may have removed it before the lock, and another process may have made a new one.
        match is_at(&lock, path) {
            true => Found::Abandoned(Self { path: path.into(), lock, removed: false }),
            false => Found::Foreign,
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives it another name in the same directory; `false` if that is taken.
    pub fn rename(&mut self, name: &str) -> io::Result<bool> {
        let path = self.path.with_file_name(name);
        let here = rustix::fs::CWD;
        match rustix::fs::renameat_with(here, &self.path, here, &path, RenameFlags::NOREPLACE) {
            Ok(()) => {
                self.path = path;
                Ok(true)
            }
            Err(Errno::EXIST | Errno::NOTEMPTY) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    /// Removes it with all that is in it, but never anything behind a mount or a link.
    ///
    /// # Errors
    /// The first thing that resists; all else is removed.
    pub fn remove(mut self) -> io::Result<()> {
        self.clear()
    }

    fn clear(&mut self) -> io::Result<()> {
        self.removed = true;
        // Not by its path alone: another directory may have come to stand there.
        match is_at(&self.lock, &self.path) {
            true => remove_tree(&self.path),
            false => Ok(()),
        }
    }
}

impl Drop for HeldDirectory {
    fn drop(&mut self) {
        if !self.removed {
            // Nothing could be done about an error; the next sweep tries again.
            let _ = self.clear();
        }
    }
}

/// Opens a directory of this user alone, without following or waiting for anything.
///
/// # Errors
/// That of the operating system; `PermissionDenied` if it is another user's or open to others.
pub fn open_own(path: &Path) -> io::Result<File> {
    let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let directory = OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(path)?;
    let found = directory.metadata()?;
    let is_own = found.is_dir() && found.uid() == rustix::process::getuid().as_raw() && found.mode() & 0o077 == 0;
    if is_own { Ok(directory) } else { Err(io::ErrorKind::PermissionDenied.into()) }
}

/// Whether a file is the one at `path`.
pub fn is_at(file: &File, path: &Path) -> bool {
    let identity = |found: fs::Metadata| (found.dev(), found.ino());
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(file), Ok(there)) => identity(file) == identity(there),
        _ => false,
    }
}

/// Removes a file, or a directory with all that is in it, as far as it stands on the same mount.
fn remove_tree(path: &Path) -> io::Result<()> {
    let (Some(parent), Some(name)) = (path.parent(), path.file_name()) else {
        return Err(io::ErrorKind::InvalidInput.into());
    };
    let parent = rustix::fs::open(parent, OFlags::DIRECTORY | OFlags::CLOEXEC | OFlags::NONBLOCK, Mode::empty())?;
    remove_entry(parent, &CString::new(name.as_bytes())?, 0).map_err(Into::into)
}

fn remove_entry(parent: impl AsFd, name: &CStr, depth: usize) -> Result<(), Errno> {
    match rustix::fs::unlinkat(&parent, name, AtFlags::empty()) {
        Err(Errno::ISDIR) => {}
        // What POSIX has for a directory; also that of a file that is immutable.
        Err(Errno::PERM) if is_directory(&parent, name) => {}
        result => return tolerate_absence(result),
    }
    if depth == MAX_DEPTH {
        return Err(Errno::NAMETOOLONG);
    }
    let emptied = open_below(&parent, name).and_then(|directory| {
        let entries = Dir::read_from(&directory)?.filter_map(Result::ok);
        // Listed before anything is removed, which would change what is listed.
        let names: Vec<CString> = entries.map(|entry| entry.file_name().to_owned()).collect();
        let real = names.iter().filter(|name| ![c".", c".."].contains(&name.as_c_str()));
        real.map(|name| remove_entry(&directory, name, depth + 1)).fold(Ok(()), Result::and)
    });
    emptied.and(tolerate_absence(rustix::fs::unlinkat(&parent, name, AtFlags::REMOVEDIR)))
}

/// Opens a directory that is no mount point and no link: what is mounted there is the data of others.
fn open_below(parent: impl AsFd, name: &CStr) -> Result<rustix::fd::OwnedFd, Errno> {
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    rustix::fs::openat2(parent, name, flags, Mode::empty(), ResolveFlags::NO_XDEV | ResolveFlags::NO_SYMLINKS)
}

fn is_directory(parent: impl AsFd, name: &CStr) -> bool {
    let found = rustix::fs::statat(parent, name, AtFlags::SYMLINK_NOFOLLOW);
    found.is_ok_and(|found| rustix::fs::FileType::from_raw_mode(found.st_mode).is_dir())
}

fn tolerate_absence(result: Result<(), Errno>) -> Result<(), Errno> {
    if result == Err(Errno::NOENT) { Ok(()) } else { result }
}
