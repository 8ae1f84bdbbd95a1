//! The numbers of a log in memory, or in a file where they would take too much of it.
//!
//! Metrics read the signals of a run in any order, so all of them have to be at hand. Those of a long run go to a file without a
//! name that is mapped: pages that have not been used for a while leave the memory of the process again.

#![allow(unsafe_code, reason = "a file is mapped into memory, and its pages are given back")]

use std::fs::{File, OpenOptions};
use std::io;
use std::ops::Deref;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use rustix::fs::{FallocateFlags, OFlags};
use rustix::mm::{Advice, MapFlags, ProtFlags};

/// Numbers that are kept in memory in any case, bytes.
const IN_MEMORY: u64 = 64 << 20;
/// Size of all numbers per byte of the log, at most: a small file does not fill a disk.
const EXPANSION_MAX: u64 = 16;
/// Uses after which the pages leave the memory of the process.
const USES: usize = 1 << 13;
const NUMBER_BYTES: u64 = size_of::<f64>() as u64;

/// A mapped file without a name.
#[derive(Debug)]
pub(super) struct Arena {
    start: NonNull<f64>,
    bytes: usize,
    uses: AtomicUsize,
}

// SAFETY: the mapping belongs to the value. It is written through exclusive references to disjoint `Numbers` only, and read
// through shared ones.
unsafe impl Send for Arena {}
// SAFETY: as above.
unsafe impl Sync for Arena {}

impl Arena {
    /// Room for so many numbers of the log `path`, in a file beside it; `None` if they are few, or there is no room for them.
    pub(super) fn for_log(path: &Path, numbers: u64) -> Option<Arc<Self>> {
        let bytes = numbers.checked_mul(NUMBER_BYTES)?;
        let limit = std::fs::metadata(path).ok()?.len().saturating_mul(EXPANSION_MAX);
        if bytes <= IN_MEMORY || bytes > limit {
            return None;
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Self::create(folder, bytes).or_else(|_| Self::create(&std::env::temp_dir(), bytes)).ok().map(Arc::new)
    }

    fn create(folder: &Path, bytes: u64) -> io::Result<Self> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).mode(0o600).custom_flags(OFlags::TMPFILE.bits() as i32);
        let file: File = options.open(folder)?;
        // All of it now: a page without room behind it could not be written later.
        rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, bytes)?;
        let bytes = usize::try_from(bytes).map_err(io::Error::other)?;
        let protection = ProtFlags::READ | ProtFlags::WRITE;
        // SAFETY: a new mapping at an address that the kernel chooses. The file has no name, so no other process can cut it.
        let start = unsafe { rustix::mm::mmap(std::ptr::null_mut(), bytes, protection, MapFlags::SHARED, &file, 0)? };
        let start = NonNull::new(start.cast()).ok_or_else(|| io::Error::other("mapped at address 0"))?;
        Ok(Self { start, bytes, uses: AtomicUsize::new(0) })
    }

    /// Notes that a page is about to be used.
    pub(super) fn use_page(&self) {
        if self.uses.fetch_add(1, Relaxed) % USES == USES - 1 {
            // SAFETY: the pages of a shared mapping are those of the file; they are mapped again with the same content when they
            // are used.
            let _ = unsafe { rustix::mm::madvise(self.start.as_ptr().cast(), self.bytes, Advice::LinuxDontNeed) };
        }
    }
}

impl Drop for Arena {
    fn drop(&mut self) {
        // SAFETY: mapped by `create`; no `Numbers` is left that could use it.
        let _ = unsafe { rustix::mm::munmap(self.start.as_ptr().cast(), self.bytes) };
    }
}

/// A list of numbers that grows at its end.
#[derive(Debug)]
pub(super) enum Numbers {
    Memory(Vec<f64>),
    Mapped(Region),
}

/// A part of an [`Arena`] that belongs to one list, in numbers.
#[derive(Debug)]
pub(super) struct Region {
    arena: Arc<Arena>,
    start: usize,
    length: usize,
    capacity: usize,
}

impl Numbers {
    /// An empty list in the part of `arena` that begins at `start` numbers; `None` if the arena is shorter.
    ///
    /// Parts do not overlap if each caller gives every number of the arena once.
    fn mapped(arena: &Arc<Arena>, start: usize, capacity: usize) -> Option<Self> {
        let end = start.checked_add(capacity)?;
        if end > arena.bytes / NUMBER_BYTES as usize {
            return None;
        }
        Some(Self::Mapped(Region { arena: arena.clone(), start, length: 0, capacity }))
    }

    /// Empty lists of these capacities, one after the other in an arena of their own; `None` if they are to be in memory.
    pub(super) fn for_log(path: &Path, capacities: &[u64]) -> Option<Vec<Self>> {
        let total = capacities.iter().try_fold(0_u64, |sum, capacity| sum.checked_add(*capacity))?;
        let arena = Arena::for_log(path, total)?;
        let mut next = 0;
        let part = |capacity: &u64| {
            let (start, capacity) = (next, usize::try_from(*capacity).ok()?);
            next += capacity;
            Self::mapped(&arena, start, capacity)
        };
        capacities.iter().map(part).collect()
    }

    /// Where the numbers are, if not in memory.
    pub(super) fn arena(&self) -> Option<&Arena> {
        match self {
            Self::Memory(_) => None,
            Self::Mapped(region) => Some(&region.arena),
        }
    }

    /// Appends numbers.
    pub(super) fn extend(&mut self, numbers: impl IntoIterator<Item = f64>) {
        for number in numbers {
            match self {
                Self::Memory(list) => list.push(number),
                Self::Mapped(region) if region.length < region.capacity => {
                    // SAFETY: within the part, as was just checked, and nothing else refers to it.
                    unsafe { region.arena.start.add(region.start + region.length).write(number) };
                    region.length += 1;
                }
                // The log said that there are fewer.
                Self::Mapped(_) => {
                    let mut list = self.to_vec();
                    list.push(number);
                    *self = Self::Memory(list);
                }
            }
        }
        self.arena().into_iter().for_each(Arena::use_page);
    }

    /// Forgets all but the first `length` numbers.
    pub(super) fn truncate(&mut self, length: usize) {
        match self {
            Self::Memory(list) => {
                list.truncate(length);
                list.shrink_to_fit();
            }
            Self::Mapped(region) => region.length = region.length.min(length),
        }
    }
}

impl Default for Numbers {
    fn default() -> Self {
        Self::Memory(Vec::new())
    }
}

impl From<Vec<f64>> for Numbers {
    fn from(list: Vec<f64>) -> Self {
        Self::Memory(list)
    }
}

impl Deref for Numbers {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        match self {
            Self::Memory(list) => list,
            // SAFETY: within the part, written by `extend`, and borrowed with the value.
            Self::Mapped(Region { arena, start, length, .. }) => unsafe {
                std::slice::from_raw_parts(arena.start.add(*start).as_ptr(), *length)
            },
        }
    }
}

impl Clone for Numbers {
    fn clone(&self) -> Self {
        Self::Memory(self.to_vec())
    }
}

impl PartialEq for Numbers {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

#[cfg(test)]
mod tests {
    use filesystem::HeldDirectory;

    use super::*;

    fn value(list: usize, number: usize) -> f64 {
        (list * 1_000_003 + number) as f64
    }

    #[test]
    fn mapped_numbers_are_those_that_were_put_in() {
        let folder = HeldDirectory::create_in(&std::env::temp_dir(), "phalanx-test-").unwrap();
        let arena = Arc::new(Arena::create(folder.path(), 3 * 40_000 * NUMBER_BYTES).unwrap());
        let mut lists: Vec<Numbers> =
            (0..3).map(|list| Numbers::mapped(&arena, list * 40_000, 40_000).unwrap()).collect();
        assert!(Numbers::mapped(&arena, 2 * 40_000 + 1, 40_000).is_none(), "beyond the end");
        for number in 0..40_000 {
            for (index, list) in lists.iter_mut().enumerate() {
                list.extend([value(index, number)]);
            }
        }
        let check = |lists: &[Numbers], length: usize| {
            for (index, list) in lists.iter().enumerate() {
                assert_eq!(list.len(), length);
                assert!(list.iter().enumerate().all(|(number, found)| *found == value(index, number)));
            }
        };
        check(&lists, 40_000);
        (0..3 * USES).for_each(|_| arena.use_page());
        check(&lists, 40_000);
        // More than the log had said.
        for (index, list) in lists.iter_mut().enumerate() {
            list.extend((40_000..40_010).map(|number| value(index, number)));
            assert!(list.arena().is_none());
        }
        check(&lists, 40_010);
        lists.iter_mut().for_each(|list| list.truncate(17));
        check(&lists.clone(), 17);
    }

    #[test]
    fn few_numbers_stay_in_memory_and_lies_take_no_disk() {
        let path = std::env::current_exe().unwrap();
        assert!(Numbers::for_log(&path, &[100, 200]).is_none());
        assert!(Numbers::for_log(&path, &[u64::MAX, 2]).is_none());
        assert!(Numbers::for_log(&path, &[u64::MAX / 16]).is_none());
    }
}
