//! The directory of a run, and the removal of what dead runs have left.
//!
//! A run holds the lock of its directory as long as it lives; the kernel takes it from a process that ends, however it ends.
//! The directory is made under a hidden name and gets its own one when it is locked; it is removed under a hidden name again.
//! So a directory with the name of a run is always locked by its run, or that of a dead one, and no process has to wait for
//! another.

mod join_lock;
mod locations;
mod segments;

use std::fs::{self, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use filesystem::{Found, HeldDirectory, holder, open_own};
use lockstep::{PLAN_FILE, Plan, PlanError};
use rustix::fs::{OFlags, statvfs};
use rustix::io::Errno;

pub(crate) use join_lock::JoinLock;
use locations::Location;

use crate::descendants::Descendants;

/// Where POSIX shared memory lives on Linux; a tmpfs, so nothing here waits for a disk.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";
/// Longest name of a run: socket paths and file names in shared memory are limited.
const MAX_NAME: usize = 40;
/// What the name of a directory begins with that is no run yet ...
const STAGED: &str = ".new-";
/// ... and none any more.
const DEAD: &str = ".dead-";
/// Where a run writes down which processes descend from it.
const LINEAGE_FILE: &str = "lineage";
/// Bytes of it that are read.
const MAX_LINEAGE: u64 = 64;
/// How often making a directory is tried again, because that of all runs was removed meanwhile.
const ATTEMPTS: usize = 100;

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

/// What [`RunDirectory::sweep`] has done.
#[derive(Debug, Default)]
pub struct Swept {
    /// Names of the dead runs whose files were removed.
    pub removed: Vec<String>,
    /// What of dead runs could not be removed.
    pub kept: Vec<DirectoryError>,
    /// Names that look like those of this user's runs, but are not theirs. They do no harm.
    pub foreign: Vec<PathBuf>,
    /// Another process is sweeping, so nothing was done: which one.
    pub busy: Option<String>,
}

/// `/dev/shm/phalanx-<uid>/<run>/`, readable by the user alone, locked while the run lives, removed with the value.
///
/// If `/dev/shm/phalanx-<uid>` is not a directory of this user alone, it is `/dev/shm/phalanx-<uid>-2/<run>/`, and so on.
#[derive(Debug)]
pub struct RunDirectory {
    name: String,
    /// `None` once it is closed.
    held: Option<HeldDirectory>,
    path: PathBuf,
}

impl RunDirectory {
    /// A directory for a run called `base`, or `base-2`, `base-3` and so on if that is taken: by a run, or by anything in
    /// shared memory that is called like a file of such a run.
    ///
    /// Characters other than letters, digits and `-` become `-`; the name is cut at 40 characters.
    ///
    /// # Errors
    /// [`DirectoryError`] if the file system refuses.
    pub fn create(base: &str) -> Result<Self, DirectoryError> {
        let base = clean(base);
        let mut refused = None;
        for place in Location::candidates() {
            match Self::create_at(&place, &base) {
                Ok(Some(directory)) => return Ok(directory),
                Ok(None) => {}
                // Read-only, immutable, or something else that another name may not have.
                Err(error) if is_of_the_place(&error.source) => refused = Some(error),
                Err(error) => return Err(error),
            }
        }
        Err(refused.unwrap_or_else(|| {
            let source = io::Error::other("every name for the directory of all runs belongs to others");
            DirectoryError { path: locations::preferred(), action: "use", source }
        }))
    }

    /// A directory in that of all runs at `place`; `None` if something else is there.
    fn create_at(place: &Path, base: &str) -> Result<Option<Self>, DirectoryError> {
        for _ in 0..ATTEMPTS {
            let Some(location) = Location::ensure(place.into()).map_err(at(place, "create"))? else { return Ok(None) };
            match HeldDirectory::create_in(&location.path, STAGED) {
                // Removed by another run that ended.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                staged => return Self::named(staged.map_err(at(place, "create a directory in"))?, base).map(Some),
            }
        }
        Ok(None)
    }

    /// Gives a directory the name of its run.
    fn named(mut staged: HeldDirectory, base: &str) -> Result<Self, DirectoryError> {
        let locations = Location::all().map_err(at(Path::new(SHARED_MEMORY), "read"))?;
        // No name with anything in shared memory is taken: what a sweep takes away then is never that of a new run.
        let runs = segments::runs()?;
        for number in 1u64.. {
            let name = if number == 1 { base.to_owned() } else { format!("{base}-{number}") };
            let is_taken = || locations.iter().any(|location| fs::symlink_metadata(location.path.join(&name)).is_ok());
            if runs.contains(&name) || is_taken() {
                continue;
            }
            if staged.rename(&name).map_err(at(staged.path(), "rename"))? {
                let path = staged.path().to_path_buf();
                return Ok(Self { name, held: Some(staged), path });
            }
        }
        unreachable!("there are more numbers than directories")
    }

    /// Removes what dead runs of this user have left. A run whose lock is held is never touched.
    ///
    /// Never waits and never fails: what cannot be removed is listed.
    pub fn sweep() -> Swept {
        let mut swept = Swept { foreign: Location::foreign(), ..Swept::default() };
        let Some(first) = Location::candidates().find_map(|place| Location::ensure(place).ok().flatten()) else {
            return swept;
        };
        // One at a time: what one has listed another must not have removed, and a new run made again.
        if first.directory.try_lock().is_err() {
            swept.busy = Some(holder(&first.directory));
            return swept;
        }
        let locations = Location::all().unwrap_or_default();
        locations.iter().for_each(|location| sweep_location(location, &mut swept));
        let is_alive =
            |run: &str| locations.iter().any(|location| fs::symlink_metadata(location.path.join(run)).is_ok());
        match segments::remove_others(is_alive) {
            Ok(runs) => swept.removed.extend(runs),
            Err(error) => swept.kept.push(error),
        }
        locations.iter().for_each(Location::leave);
        first.leave();
        swept.removed.sort();
        swept.removed.dedup();
        swept
    }

    /// The names of this user's runs that are going on, in ascending order.
    ///
    /// # Errors
    /// [`DirectoryError`] if shared memory cannot be read.
    pub fn list() -> Result<Vec<String>, DirectoryError> {
        let locations = Location::all().map_err(at(Path::new(SHARED_MEMORY), "read"))?;
        let mut names = Vec::new();
        for location in &locations {
            let entries = location.entries().map_err(at(&location.path, "read"))?;
            names.extend(
                entries.into_iter().filter(|name| !name.starts_with('.') && is_alive(&location.path.join(name))),
            );
        }
        names.sort();
        Ok(names)
    }

    /// Where the directory of the run called `name` is, if there is such a run of this user.
    pub fn path_of(name: &str) -> PathBuf {
        let locations = Location::all().unwrap_or_default();
        let is_there = |location: &&Location| fs::symlink_metadata(location.path.join(name)).is_ok();
        let location = locations.iter().find(is_there).or(locations.first());
        location.map_or_else(locations::preferred, |location| location.path.clone()).join(name)
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
    /// [`DirectoryError`] if something resists; all else is removed, and the name is free.
    pub fn close(mut self) -> Result<(), DirectoryError> {
        self.remove()
    }

    /// Writes down which processes descend from the run, for those who find its directory when it is dead.
    pub(crate) fn note_descendants(&self, descendants: Descendants) -> Result<(), DirectoryError> {
        let path = self.path.join(LINEAGE_FILE);
        fs::write(&path, descendants.to_text()).map_err(at(&path, "write"))
    }

    /// Writes `plan.json`, for this user only.
    pub(crate) fn write_plan(&self, plan: &Plan) -> Result<(), PlanError> {
        let path = self.path.join(PLAN_FILE);
        let text = plan.to_json(&path)?;
        let file = OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(&path);
        file.and_then(|mut file| file.write_all(&text)).map_err(|source| PlanError::File { path, source })
    }

    /// Takes from other users what iceoryx2 has opened to them, and takes the memory that was only promised so far.
    pub(crate) fn protect(&self) -> Result<(), DirectoryError> {
        segments::protect(&self.name)
    }

    /// The shared memory of the run, with its sizes.
    pub(crate) fn segments(&self) -> Vec<(PathBuf, u64)> {
        segments::sizes(&self.name).unwrap_or_default()
    }

    fn remove(&mut self) -> Result<(), DirectoryError> {
        let Some(held) = self.held.take() else { return Ok(()) };
        // Those who just join the run from outside have made files by the time that they let go.
        let lock = JoinLock::close(&self.path);
        let removed = remove(held, &self.name);
        drop(lock);
        removed
    }
}

impl Drop for RunDirectory {
    fn drop(&mut self) {
        // Nothing could be done about an error; the next sweep tries again.
        let _ = self.remove();
    }
}

/// Removes what dead runs have left in one directory of runs.
fn sweep_location(location: &Location, swept: &mut Swept) {
    for name in location.entries().unwrap_or_default() {
        let Found::Abandoned(held) = HeldDirectory::find(&location.path.join(&name)) else { continue };
        let path = held.path().to_path_buf();
        let removed = match name.starts_with('.') {
            true => held.remove().map_err(at(&path, "remove")),
            false => {
                end_descendants(&path);
                swept.removed.push(name.clone());
                remove(held, &name)
            }
        };
        swept.kept.extend(removed.err());
    }
}

/// Ends what descends from a dead run, if its supervisor was killed with it.
fn end_descendants(directory: &Path) {
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let file = OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(directory.join(LINEAGE_FILE));
    let mut text = String::new();
    let read = file.and_then(|file| file.take(MAX_LINEAGE).read_to_string(&mut text));
    if let (Ok(_), Some(descendants)) = (read, Descendants::from_text(&text)) {
        descendants.end();
    }
}

/// Removes a run's shared memory, then its directory, and that of all runs if this was the last one.
fn remove(mut held: HeldDirectory, run: &str) -> Result<(), DirectoryError> {
    let path = held.path().to_path_buf();
    let segments = segments::remove(run);
    // As long as it has its name, no other run has its shared memory. If it cannot be renamed, it is removed as it is.
    for number in 0..ATTEMPTS {
        if !matches!(held.rename(&format!("{DEAD}{run}-{number}")), Ok(false)) {
            break;
        }
    }
    let removed = held.remove().map_err(at(&path, "remove"));
    if let Some(location) = path.parent() {
        // Only succeeds when no run is left, and then leaves nothing at all.
        let _ = fs::remove_dir(location);
    }
    segments.and(removed)
}

/// Whether a process holds the directory of a run.
pub(crate) fn is_alive(path: &Path) -> bool {
    open_own(path).is_ok_and(|directory| matches!(directory.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// Whether another directory may do where this error came up.
fn is_of_the_place(error: &io::Error) -> bool {
    let of_the_place = [Errno::PERM, Errno::ACCESS, Errno::ROFS, Errno::NOTDIR, Errno::LOOP, Errno::BUSY, Errno::STALE];
    Errno::from_io_error(error).is_some_and(|error| of_the_place.contains(&error))
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

/// What the names of a run's shared memory begin with. No run name contains the `_` at the end, so none begins another.
pub(crate) fn prefix(run: &str) -> String {
    format!("phalanx{}-{run}_", rustix::process::getuid().as_raw())
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
