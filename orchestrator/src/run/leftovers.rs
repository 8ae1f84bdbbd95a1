//! What runs leave that were killed: their directories, their shared memory, their temporary folders.
//!
//! Every command of a user removes them before it does anything else, so that nothing outlives the next start of the program.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use processes::{DirectoryError, RunDirectory};

/// What the names of temporary folders begin with; the number of the process follows, and a `-`.
pub(crate) const TEMPORARY: &str = "phalanx-conform-";

/// What was removed.
#[derive(Debug, Default)]
pub(crate) struct Removed {
    /// Names of dead runs.
    pub(crate) runs: Vec<String>,
    /// Temporary folders.
    pub(crate) folders: Vec<PathBuf>,
}

/// Removes what dead runs of this user have left, and nothing that a living one uses.
///
/// # Errors
/// [`DirectoryError`] if something of a dead run cannot be removed.
pub(crate) fn sweep() -> Result<Removed, DirectoryError> {
    let folders = abandoned(&std::env::temp_dir());
    // Another process may be at the same.
    folders.iter().for_each(|folder| drop(fs::remove_dir_all(folder)));
    Ok(Removed { runs: RunDirectory::sweep()?, folders })
}

/// The same for a command that has something else to do, and must not fail for this.
pub(crate) fn sweep_silently() {
    match sweep() {
        Ok(removed) if !removed.runs.is_empty() => {
            tracing::info!(runs = removed.runs.join(", "), "removed what dead runs had left");
        }
        Ok(_) => {}
        Err(error) => tracing::debug!(%error, "what dead runs have left cannot be removed"),
    }
}

/// The temporary folders of this user whose processes are no more.
fn abandoned(temporary: &Path) -> Vec<PathBuf> {
    let user = rustix::process::getuid().as_raw();
    let Ok(entries) = fs::read_dir(temporary) else { return Vec::new() };
    let is_abandoned = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let pid = name.strip_prefix(TEMPORARY).and_then(|rest| rest.split('-').next()?.parse::<u32>().ok());
        let is_own = || fs::symlink_metadata(path).is_ok_and(|found| found.is_dir() && found.uid() == user);
        pid.is_some_and(|pid| !Path::new(&format!("/proc/{pid}")).exists()) && is_own()
    };
    entries.flatten().map(|entry| entry.path()).filter(is_abandoned).collect()
}
