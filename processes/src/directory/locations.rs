//! The directories in shared memory that hold the runs of this user.
//!
//! There is one, `/dev/shm/phalanx-<uid>`, unless its name is taken by anything that is not a directory of this user alone.
//! Then another name serves. All commands find every such directory by looking at all names, so that no order matters.

use std::ffi::OsStr;
use std::fs::{self, DirBuilder, File};
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use filesystem::open_own;

use super::SHARED_MEMORY;

/// Numbers that are tried as endings of the name, and random endings behind them.
const NUMBERED: u32 = 9;
const RANDOM: usize = 8;

/// A directory of runs.
#[derive(Debug)]
pub(super) struct Location {
    pub(super) path: PathBuf,
    /// The directory, open.
    pub(super) directory: File,
}

impl Location {
    /// Those that there are, the preferred one first.
    pub(super) fn all() -> io::Result<Vec<Self>> {
        let mut locations: Vec<Self> = named()?.into_iter().filter_map(Self::open).collect();
        locations.sort_by_key(|location| (location.path.as_os_str().len(), location.path.clone()));
        Ok(locations)
    }

    /// The names in their place that are not usable.
    pub(super) fn foreign() -> Vec<PathBuf> {
        named().unwrap_or_default().into_iter().filter(|path| open_own(path).is_err()).collect()
    }

    /// What serves if a directory has to be made: usable ones and free names, in order of preference.
    pub(super) fn candidates() -> impl Iterator<Item = PathBuf> {
        let base = preferred();
        let with = move |ending: String| PathBuf::from(format!("{}-{ending}", preferred().display()));
        let numbered = (2..=NUMBERED).map(move |number| with(number.to_string()));
        let random = (0..RANDOM).map(move |number| with(format!("{:016x}", RandomState::new().hash_one(number))));
        std::iter::once(base).chain(numbered).chain(random)
    }

    /// The directory at `path`, which is created if the name is free; `None` if something else has it.
    ///
    /// # Errors
    /// That of the operating system if it does not create it.
    pub(super) fn ensure(path: PathBuf) -> io::Result<Option<Self>> {
        match DirBuilder::new().mode(0o700).create(&path) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => Err(error),
            _ => Ok(Self::open(path)),
        }
    }

    fn open(path: PathBuf) -> Option<Self> {
        let directory = open_own(&path).ok()?;
        Some(Self { path, directory })
    }

    /// The names in it, those that are hidden too.
    pub(super) fn entries(&self) -> io::Result<Vec<String>> {
        let entries = fs::read_dir(&self.path)?.flatten();
        Ok(entries.filter_map(|entry| entry.file_name().into_string().ok()).collect())
    }

    /// Removes it if nothing is in it.
    pub(super) fn leave(&self) {
        let _ = fs::remove_dir(&self.path);
    }
}

/// The one that everything is in unless something is wrong.
pub(super) fn preferred() -> PathBuf {
    Path::new(SHARED_MEMORY).join(format!("phalanx-{}", rustix::process::getuid().as_raw()))
}

/// Everything that is called like a directory of runs of this user.
fn named() -> io::Result<Vec<PathBuf>> {
    let preferred = preferred();
    let name = preferred.file_name().and_then(OsStr::to_str).unwrap_or_default().to_owned();
    let is_named = |other: &str| other.strip_prefix(&name).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'));
    let entries = fs::read_dir(SHARED_MEMORY)?.flatten();
    Ok(entries.filter(|entry| entry.file_name().to_str().is_some_and(is_named)).map(|entry| entry.path()).collect())
}
