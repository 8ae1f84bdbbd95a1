//! The directory of a run, and the removal of what dead runs have left.

use std::fs::{self, DirBuilder, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use lockstep::{PLAN_FILE, Plan, PlanError};
use rustix::fs::{FallocateFlags, fallocate, statvfs};

/// Where POSIX shared memory lives on Linux; a tmpfs, so nothing here waits for a disk.
const SHARED_MEMORY: &str = "/dev/shm";
/// Its lock is held as long as the run lives.
pub(crate) const LOCK_FILE: &str = "lock";
/// Longest name of a run: socket paths and file names in shared memory are limited.
const MAX_NAME: usize = 40;

/// What could not be done with a run directory.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {action}: {source}")]
pub struct DirectoryError {
    /// Of which file or directory.
    pub path: PathBuf,
    /// What was tried.
    pub action: &'static str,
    /// Why it failed.
    pub source: io::Error,
}

/// `/dev/shm/phalanx-<uid>/<run>/`, readable by the user alone, locked while the run lives, removed with the value.
#[derive(Debug)]
pub struct RunDirectory {
    name: String,
    path: PathBuf,
    /// Held, not used: the lock goes with it.
    _lock: File,
    /// Nothing is left to be removed.
    closed: bool,
}

impl RunDirectory {
    /// A directory for a run called `base`, or `base-2`, `base-3` and so on if there is such a run already.
    ///
    /// Characters other than letters, digits and `-` become `-`; the name is cut at 40 characters.
    ///
    /// # Errors
    /// [`DirectoryError`] if the file system refuses, or if somebody else owns the place.
    pub fn create(base: &str) -> Result<Self, DirectoryError> {
        let base = clean(base);
        let parent = Parent::lock()?;
        for number in 1u64.. {
            let name = if number == 1 { base.clone() } else { format!("{base}-{number}") };
            let path = parent.path.join(&name);
            match DirBuilder::new().mode(0o700).create(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                result => result.map_err(at(&path, "create"))?,
            }
            let lock_path = path.join(LOCK_FILE);
            let options = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&lock_path);
            let lock = options.map_err(at(&lock_path, "create"))?;
            lock.lock().map_err(at(&lock_path, "lock"))?;
            return Ok(Self { name, path, _lock: lock, closed: false });
        }
        unreachable!("there are more numbers than directories")
    }

    /// Removes what dead runs of this user have left, and returns their names.
    ///
    /// A run whose lock is held is never touched.
    ///
    /// # Errors
    /// [`DirectoryError`] if something of a dead run cannot be removed.
    pub fn sweep() -> Result<Vec<String>, DirectoryError> {
        let parent = Parent::lock()?;
        let mut removed = Vec::new();
        for entry in fs::read_dir(&parent.path).map_err(at(&parent.path, "read"))? {
            let entry = entry.map_err(at(&parent.path, "read"))?;
            let lock_path = entry.path().join(LOCK_FILE);
            match File::open(&lock_path) {
                Ok(lock) => match lock.try_lock() {
                    Ok(()) => {}
                    Err(TryLockError::WouldBlock) => continue,
                    Err(TryLockError::Error(source)) => {
                        return Err(DirectoryError { path: lock_path, action: "lock", source });
                    }
                },
                // Its owner died between creating the directory and the lock; it cannot be at it, we hold the parent.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(source) => return Err(DirectoryError { path: lock_path, action: "open", source }),
            }
            let name = entry.file_name().to_string_lossy().into_owned();
            remove(&entry.path(), &name)?;
            removed.push(name);
        }
        for (run, file) in all_shared_files()? {
            // A run has its directory before, and longer than, its memory.
            if !parent.path.join(&run).exists() {
                tolerate_absence(fs::remove_file(&file)).map_err(at(&file, "remove"))?;
                removed.push(run);
            }
        }
        removed.sort();
        removed.dedup();
        Ok(removed)
    }

    /// The names of this user's runs that are going on, in ascending order.
    ///
    /// # Errors
    /// [`DirectoryError`] if the directory of all runs cannot be read.
    pub fn list() -> Result<Vec<String>, DirectoryError> {
        let parent = parent_path();
        let entries = match fs::read_dir(&parent) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            result => result.map_err(at(&parent, "read"))?,
        };
        let is_alive = |path: &Path| {
            let lock = File::open(path.join(LOCK_FILE));
            lock.is_ok_and(|lock| matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock)))
        };
        let alive = entries.filter_map(Result::ok).filter(|entry| is_alive(&entry.path()));
        let mut names: Vec<String> = alive.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        Ok(names)
    }

    /// Where the directory of the run called `name` is, if there is such a run of this user.
    pub fn path_of(name: &str) -> PathBuf {
        parent_path().join(name)
    }

    /// Name of the run.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the directory and the run's shared memory. Dropping does the same, silently.
    ///
    /// # Errors
    /// [`DirectoryError`] if something resists.
    pub fn close(mut self) -> Result<(), DirectoryError> {
        self.closed = true;
        self.remove()
    }

    /// Writes `plan.json`, for this user only.
    pub(crate) fn write_plan(&self, plan: &Plan) -> Result<(), PlanError> {
        let path = self.path.join(PLAN_FILE);
        let text = plan.to_json(&path)?;
        let file = OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(&path);
        file.and_then(|mut file| file.write_all(&text)).map_err(|source| PlanError::File { path, source })
    }

    /// Takes from everybody else what iceoryx2 has opened to them: a counter of 16 bytes. And takes the memory that was only
    /// promised so far: if others filled it meanwhile, whoever writes to it would be killed.
    pub(crate) fn protect(&self) -> Result<(), DirectoryError> {
        for path in shared_files(&self.name)? {
            let private = fs::Permissions::from_mode(0o600);
            tolerate_absence(fs::set_permissions(&path, private)).map_err(at(&path, "protect"))?;
            tolerate_absence(reserve(&path)).map_err(at(&path, "reserve memory for"))?;
        }
        Ok(())
    }

    fn remove(&self) -> Result<(), DirectoryError> {
        // The parent is locked meanwhile, so that no sweep takes a half-removed directory for a dead run.
        let parent = Parent::lock()?;
        let result = remove(&self.path, &self.name);
        drop(parent);
        result
    }
}

impl Drop for RunDirectory {
    fn drop(&mut self) {
        // Not twice: another run may have taken the name. Nobody could be told of an error; the next sweep tries again.
        if !self.closed {
            let _ = self.remove();
        }
    }
}

/// Whether there is room for `bytes` in shared memory.
///
/// # Errors
/// Says how much there is and what to do. Without the question, the process would be killed by a SIGBUS when it writes.
pub(crate) fn require_room(bytes: usize) -> io::Result<()> {
    let shared = statvfs(SHARED_MEMORY)?;
    let free = shared.f_bavail.saturating_mul(shared.f_frsize);
    if bytes as u64 <= free {
        return Ok(());
    }
    Err(io::Error::other(format!(
        "{SHARED_MEMORY} is full: {} KiB are free, {} KiB are needed; `phalanx doctor` removes what dead runs have left there, \
         and `mount -o remount,size=1G {SHARED_MEMORY}` (of a container: `--shm-size=1g`) makes it larger",
        free >> 10,
        bytes.div_ceil(1 << 10)
    )))
}

fn reserve(path: &Path) -> io::Result<()> {
    let file = OpenOptions::new().write(true).open(path)?;
    match file.metadata()?.len() {
        0 => Ok(()),
        length => Ok(fallocate(&file, FallocateFlags::empty(), 0, length)?),
    }
}

/// What the names of a run's shared memory begin with. No run name contains the `_` at the end, so none begins another.
pub(crate) fn prefix(run: &str) -> String {
    format!("phalanx{}-{run}_", rustix::process::getuid().as_raw())
}

/// `/dev/shm/phalanx-<uid>`, locked, so that nobody creates, sweeps or removes runs in it meanwhile.
pub(crate) struct Parent {
    path: PathBuf,
    _lock: File,
}

impl Parent {
    /// Waits until nobody else holds it.
    ///
    /// # Errors
    /// [`DirectoryError`] if it cannot be made, or is not this user's alone.
    pub(crate) fn lock() -> Result<Self, DirectoryError> {
        let user = rustix::process::getuid().as_raw();
        let path = parent_path();
        loop {
            match DirBuilder::new().mode(0o700).create(&path) {
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(at(&path, "create")(error)),
                _ => {}
            }
            let file = match File::open(&path) {
                // Removed again by another run that ended.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                result => result.map_err(at(&path, "open"))?,
            };
            file.lock().map_err(at(&path, "lock"))?;
            let locked = file.metadata().map_err(at(&path, "look at"))?;
            if path.is_symlink() || !locked.is_dir() || locked.uid() != user || locked.mode() & 0o077 != 0 {
                let source = io::Error::other("it must be a directory of this user alone; somebody else made it");
                return Err(DirectoryError { path, action: "use", source });
            }
            // While we waited for the lock, its holder may have removed the directory and somebody made a new one.
            match fs::symlink_metadata(&path) {
                Ok(now) if (now.dev(), now.ino()) == (locked.dev(), locked.ino()) => {
                    return Ok(Self { path, _lock: file });
                }
                _ => continue,
            }
        }
    }
}

impl Drop for Parent {
    fn drop(&mut self) {
        // Only succeeds when no run is left, and then leaves nothing at all.
        let _ = fs::remove_dir(&self.path);
    }
}

/// The directory of all runs of this user.
fn parent_path() -> PathBuf {
    let user = rustix::process::getuid().as_raw();
    Path::new(SHARED_MEMORY).join(format!("phalanx-{user}"))
}

/// Removes a run's shared memory, then its directory.
fn remove(path: &Path, run: &str) -> Result<(), DirectoryError> {
    for file in shared_files(run)? {
        tolerate_absence(fs::remove_file(&file)).map_err(at(&file, "remove"))?;
    }
    tolerate_absence(fs::remove_dir_all(path)).map_err(at(path, "remove"))
}

/// The shared memory of a run.
fn shared_files(run: &str) -> Result<Vec<PathBuf>, DirectoryError> {
    let files = all_shared_files()?.into_iter();
    Ok(files.filter(|(owner, _)| owner == run).map(|(_, path)| path).collect())
}

/// The shared memory of all runs of this user, with the names of the runs.
fn all_shared_files() -> Result<Vec<(String, PathBuf)>, DirectoryError> {
    let shared_memory = Path::new(SHARED_MEMORY);
    let prefix = prefix("");
    let prefix = prefix.trim_end_matches('_');
    let mut files = Vec::new();
    for entry in fs::read_dir(shared_memory).map_err(at(shared_memory, "read"))? {
        let entry = entry.map_err(at(shared_memory, "read"))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if let Some((run, _)) = name.strip_prefix(prefix).and_then(|rest| rest.split_once('_')) {
            files.push((run.into(), entry.path()));
        }
    }
    Ok(files)
}

fn tolerate_absence(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

fn at(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> DirectoryError {
    let path = path.to_path_buf();
    move |source| DirectoryError { path, action, source }
}

fn clean(base: &str) -> String {
    let allowed = |character: char| if character.is_ascii_alphanumeric() { character } else { '-' };
    let name: String = base.chars().map(allowed).take(MAX_NAME).collect();
    if name.is_empty() { "run".into() } else { name }
}
