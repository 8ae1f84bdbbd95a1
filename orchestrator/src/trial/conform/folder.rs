//! A temporary folder.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::failure::Failure;
use crate::run::leftovers::TEMPORARY;

/// A temporary folder of this process, removed at the end.
pub(super) struct Folder {
    pub(super) path: PathBuf,
}

impl Folder {
    pub(super) fn create() -> Result<Self, Failure> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("{TEMPORARY}{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(Failure::system(format!("create the folder {}", path.display())))?;
        Ok(Self { path })
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed from a temporary folder is removed by the system.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}
