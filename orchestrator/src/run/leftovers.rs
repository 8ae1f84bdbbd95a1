//! What commands leave that were killed: the directories and the shared memory of runs, and temporary folders.
//!
//! Every command that starts something removes them first, so that nothing outlives the next start of a run. Commands that
//! only read remove nothing.

use std::path::{Path, PathBuf};

use filesystem::HeldDirectory;
use processes::{RunDirectory, Swept};

use crate::failure::Failure;

/// What was removed.
#[derive(Debug, Default)]
pub(crate) struct Removed {
    /// What was done about dead runs.
    pub(crate) runs: Swept,
    /// Temporary folders.
    pub(crate) folders: Vec<PathBuf>,
}

/// Removes what dead commands of this user have left, and nothing that a living one uses.
pub(crate) fn sweep() -> Removed {
    let folders = HeldDirectory::sweep_in(&std::env::temp_dir(), &prefix());
    Removed { runs: RunDirectory::sweep(), folders }
}

/// The same for a command that has something else to do.
pub(crate) fn sweep_silently() {
    let Removed { runs, .. } = sweep();
    if !runs.removed.is_empty() {
        tracing::info!(runs = runs.removed.join(", "), "removed what dead runs had left");
    }
    for error in &runs.kept {
        tracing::debug!(%error, "something of a dead run cannot be removed");
    }
    if let Some(process) = &runs.busy {
        tracing::debug!(process, "another process removes what dead runs have left");
    }
}

/// A temporary folder of this process, removed at its end, and by the next sweep if the process is killed.
#[derive(Debug)]
pub(crate) struct Scratch(HeldDirectory);

impl Scratch {
    /// Creates one.
    ///
    /// # Errors
    /// [`Failure::System`] if the folder for temporary files cannot be written.
    pub(crate) fn create() -> Result<Self, Failure> {
        let parent = std::env::temp_dir();
        let created = HeldDirectory::create_in(&parent, &prefix());
        let what = format!("create a folder in {} (TMPDIR names another place)", parent.display());
        Ok(Self(created.map_err(Failure::system(what))?))
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }
}

/// What the names of temporary folders of this user begin with.
fn prefix() -> String {
    format!("phalanx-scratch-{}-", rustix::process::getuid().as_raw())
}
