//! Where data files come from.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

#[cfg(doc)]
use super::DataFile;
use crate::config::read_bytes;

/// Most bytes of a data file.
pub(super) const MOST_BYTES: usize = 64 << 20;

/// Where the data files that formulas name come from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DataSource {
    /// There are none.
    #[default]
    None,
    /// They are files; relative paths start at this folder. The directory of a run has them under names with the SHA-256 that its
    /// scenario gives for them, [`DataFile::name`].
    Folder(PathBuf),
    /// These bytes, by the path that formulas name: those of a log.
    Bytes(BTreeMap<String, Arc<[u8]>>),
}

/// The name in the directory of a run of a file with this SHA-256.
pub(super) fn file_name(digest: &str) -> String {
    format!("data-{digest}")
}

impl DataSource {
    /// The bytes of the file that a formula calls `path`, whose SHA-256 is `digest` as far as the scenario says so.
    pub(super) fn read(&self, path: &str, digest: Option<&str>) -> Result<Arc<[u8]>, String> {
        let file = match self {
            DataSource::Folder(folder) => {
                let of_run = digest.map(|digest| folder.join(file_name(digest))).filter(|file| file.exists());
                of_run.unwrap_or_else(|| folder.join(path))
            }
            DataSource::Bytes(all) => {
                let missing = || format!("{path}: the file is not among the data of the log");
                return all.get(path).cloned().ok_or_else(missing);
            }
            DataSource::None => return Err(format!("{path}: there are no data files here")),
        };
        let bytes =
            read_bytes(&file, MOST_BYTES).map_err(|error| format!("cannot read {}: {error}", file.display()))?;
        if bytes.len() > MOST_BYTES {
            return Err(format!("{path}: expected at most {} MiB of data, found more", MOST_BYTES >> 20));
        }
        Ok(bytes.into())
    }
}
