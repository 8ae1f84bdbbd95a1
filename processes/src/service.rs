//! What every service of iceoryx2 needs: its configuration for a run, and its errors.

use std::fmt::Debug;
use std::path::Path;

use iceoryx2::prelude::{Config, FileName, LogLevel, SemanticString, set_log_level};

use crate::directory;

/// A service that could not be created or opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}: {cause}")]
pub struct ServiceError {
    /// What was tried, with the name of the service.
    pub what: String,
    /// What iceoryx2 says.
    pub cause: String,
}

/// How iceoryx2 is to keep its files of a run, in the directory `root`.
///
/// # Errors
/// [`ServiceError`] if it cannot use the directory or the name of the run.
pub(crate) fn configuration(root: &Path, run: &str) -> Result<Config, ServiceError> {
    set_log_level(LogLevel::Error);
    let failed = |what: &str| format!("iceoryx2 cannot use {what} of the run");
    // Not the global configuration: that reads files from the working directory and from the home of the user.
    let mut config = Config::default();
    config.global.prefix = FileName::new(directory::prefix(run).as_bytes()).map_err(error(failed("the name")))?;
    let root = iceoryx2::prelude::Path::new(root.as_os_str().as_encoded_bytes());
    config.global.set_root_path(&root.map_err(error(failed("the directory")))?);
    // Cleaning up after dead processes races with living ones; the run directory is removed as a whole.
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

/// The errors of iceoryx2 are many small enums; what matters is their names.
pub(crate) fn error<E: Debug>(what: String) -> impl FnOnce(E) -> ServiceError {
    move |cause| ServiceError { what, cause: format!("{cause:?}") }
}
