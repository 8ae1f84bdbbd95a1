//! What the conductor has open of its run, and how it lets go of it.
//!
//! iceoryx2 takes leave of every service by following references in its memory, which any process of the run may have
//! overwritten. The files of a run are removed as a whole, so nothing has to be taken leave of: the memory is unmapped and the
//! files are closed, and nothing in them is looked at.

use std::collections::BTreeSet;
use std::mem::ManuallyDrop;
use std::os::fd::RawFd;
use std::path::{Path, PathBuf};
use std::{fs, ptr};

use crate::board::{self, Boards, ChannelReader};
use crate::directory;
use crate::service::ServiceError;

/// Readers of all channels, and the boards that they belong to.
pub(super) struct Ports {
    pub(super) readers: ManuallyDrop<Vec<ChannelReader>>,
    pub(super) boards: ManuallyDrop<Boards>,
    holdings: Holdings,
    run: String,
    directory: PathBuf,
}

/// What this process has mapped and opened of a run.
#[derive(Debug, Default)]
struct Holdings {
    /// Starts and ends.
    mappings: BTreeSet<(usize, usize)>,
    files: BTreeSet<RawFd>,
}

impl Ports {
    /// Joins the run in `directory`, with no readers yet.
    ///
    /// # Errors
    /// [`ServiceError`] if iceoryx2 cannot work there.
    pub(super) fn open(directory: &Path, run: &str) -> Result<Self, ServiceError> {
        let before = Holdings::look(run, directory);
        let boards = ManuallyDrop::new(Boards::join(directory, run, "conductor")?);
        let (readers, holdings) = (ManuallyDrop::new(Vec::new()), Holdings::default());
        let mut ports = Self { readers, boards, holdings, run: run.into(), directory: directory.into() };
        ports.add(before);
        Ok(ports)
    }

    /// Does what opens more.
    pub(super) fn extend<T>(&mut self, open: impl FnOnce(&Boards, &mut Vec<ChannelReader>) -> T) -> T {
        let before = Holdings::look(&self.run, &self.directory);
        let result = open(&self.boards, &mut self.readers);
        self.add(before);
        result
    }

    fn add(&mut self, before: Holdings) {
        let now = Holdings::look(&self.run, &self.directory);
        self.holdings.mappings.extend(now.mappings.difference(&before.mappings));
        self.holdings.files.extend(now.files.difference(&before.files));
    }
}

impl Drop for Ports {
    fn drop(&mut self) {
        for &(start, end) in &self.holdings.mappings {
            // SAFETY: mapped for the readers and the boards, which are never used or dropped from here on.
            let _ = unsafe { rustix::mm::munmap(ptr::with_exposed_provenance_mut(start), end - start) };
        }
        // SAFETY: opened for the readers and the boards, as above.
        self.holdings.files.iter().for_each(|&file| unsafe { rustix::io::close(file) });
    }
}

impl Holdings {
    fn look(run: &str, directory: &Path) -> Self {
        let memory = Path::new(directory::SHARED_MEMORY).join(directory::prefix(run)).into_os_string();
        let memory = memory.to_string_lossy().into_owned();
        let root = directory.join(board::ROOT).to_string_lossy().into_owned();
        let is_meant = |path: &str| path.starts_with(&memory) || path.starts_with(&root);
        let maps = fs::read_to_string("/proc/self/maps").unwrap_or_default();
        let mappings = maps.lines().filter(|line| line.split_whitespace().nth(5).is_some_and(is_meant));
        let number = |text: &str| usize::from_str_radix(text, 16).ok();
        let range = |line: &str| {
            let (start, end) = line.split(' ').next()?.split_once('-')?;
            Some((number(start)?, number(end)?))
        };
        let entries = fs::read_dir("/proc/self/fd").into_iter().flatten().flatten();
        let files =
            entries.filter(|entry| fs::read_link(entry.path()).is_ok_and(|path| is_meant(&path.to_string_lossy())));
        let files = files.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        Self { mappings: mappings.filter_map(range).collect(), files: files.collect() }
    }
}
