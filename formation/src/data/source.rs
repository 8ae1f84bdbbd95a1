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
    /// They are files; relative paths start at this folder.
    Folder(PathBuf),
    /// They are in the directory of a run, under names with the SHA-256 that the scenario gives for them: [`DataFile::name`].
    Run(PathBuf),
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
        let file = match (self, digest) {
            (DataSource::Folder(folder), _) => folder.join(path),
            (DataSource::Run(folder), Some(digest)) => folder.join(file_name(digest)),
            (DataSource::Bytes(all), _) => {
                return all
                    .get(path)
                    .cloned()
                    .ok_or_else(|| format!("{path}: the file is not among the data of the log"));
            }
            (DataSource::None | DataSource::Run(_), _) => {
                return Err(format!("{path}: there are no data files here"));
            }
        };
        let bytes =
            read_bytes(&file, MOST_BYTES).map_err(|error| format!("cannot read {}: {error}", file.display()))?;
        if bytes.len() > MOST_BYTES {
            return Err(format!("{path}: expected at most {} MiB of data, found more", MOST_BYTES >> 20));
        }
        Ok(bytes.into())
    }
}
