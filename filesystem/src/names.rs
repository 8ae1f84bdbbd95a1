//! What a path means, and the temporary name beside it.

use std::ffi::{OsStr, OsString};
use std::fs::{self, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustix::io::Errno;

/// Links that are followed to the file of a log; the kernel follows as many.
const LINKS_MAX: usize = 40;
/// Length of a file name to which a prefix and an ending can still be added, bytes.
const NAME_MAX: usize = 230;

/// Whether two paths mean one file, by link or hard link, too; `false` if one of both is not there.
pub fn is_same_file(one: &Path, other: &Path) -> bool {
    matches!((fs::metadata(one), fs::metadata(other)), (Ok(one), Ok(other)) if is_same(&one, &other))
}

/// Whether both describe one file.
pub fn is_same(one: &Metadata, other: &Metadata) -> bool {
    (one.dev(), one.ino()) == (other.dev(), other.ino())
}

/// The path without links at its end; what it means does not have to be there.
pub fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..LINKS_MAX {
        let Ok(next) = fs::read_link(&path) else { return Ok(path) };
        let next = path.parent().unwrap_or(Path::new("")).join(next);
        // Links of /proc lead to open files that may have no name.
        if next.symlink_metadata().is_err() && path.metadata().is_ok() {
            return Ok(path);
        }
        path = next;
    }
    Err(Errno::LOOP.into())
}

/// Where a log grows that replaces an earlier one at `path`; `None` if that names no file.
pub fn draft_of(path: &Path) -> Option<PathBuf> {
    let target = follow(path).ok()?;
    Some(target.with_file_name(draft_name(target.file_name()?, "")))
}

/// `.uav.mcap.part` for `uav.mcap`, with a mark before its ending; a long name is shortened.
pub fn draft_name(name: &OsStr, mark: &str) -> OsString {
    let mut draft = OsString::from(".");
    match name.len() <= NAME_MAX {
        true => draft.push(name),
        false => draft.push(format!("phalanx-{:08x}", crc32fast::hash(name.as_encoded_bytes()))),
    }
    draft.push(format!("{mark}.part"));
    draft
}
