//! The memory behind the page: made, mapped and unmapped here, and nowhere else looked at as raw bytes.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};

use rustix::fs::{MemfdFlags, SealFlags};
use rustix::mm::{MapFlags, ProtFlags};

use super::counters::{Counters, Event};
use super::layout::{Head, MAGIC, Phase, Slot, size};
use super::protocol::WaitPoint;
use super::wake::Waker;
use lockstep::Plan;

/// Memory that this process shares with others; nothing of it is looked at but by atomics.
struct Mapping {
    base: NonNull<Head>,
    bytes: usize,
}

// SAFETY: an address and a length. What is there consists of atomics, for every thread alike, and stays until the drop.
unsafe impl Send for Mapping {}
// SAFETY: a shared reference gives access to atomics only.
unsafe impl Sync for Mapping {}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: what `map` mapped; no reference into it outlives the value. Failure leaves a mapping behind, no more.
        let _ = unsafe { rustix::mm::munmap(self.base.as_ptr().cast(), self.bytes) };
    }
}

/// The mapped page of a run.
pub(crate) struct SharedMemory {
    mapping: Mapping,
    /// How many workers take part in each phase. Not read from the page, where a stray pointer may change it.
    pub(super) members: Box<[u32]>,
    /// The [`Plan::fingerprint`] of the run.
    fingerprint: u64,
    pub(super) phases: usize,
    pub(super) workers: usize,
    /// Runs of every worker that are kept for a trace.
    pub(super) traced: usize,
    /// How this process sleeps and wakes others.
    pub(super) waker: Waker,
    file: OwnedFd,
}

impl SharedMemory {
    /// A new page for a run.
    pub(super) fn create(plan: &Plan) -> io::Result<Self> {
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        let file = rustix::fs::memfd_create("phalanx", flags)?;
        rustix::fs::ftruncate(&file, size(plan) as u64)?;
        // If a child cut the file short, every process that touches it would be killed.
        rustix::fs::fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        let memory = Self::map(file, plan)?;
        for (phase, &members) in memory.members.iter().enumerate() {
            memory.phase(phase).groups[0].count.store(members, SeqCst);
        }
        memory.head().plan.store(memory.fingerprint, SeqCst);
        memory.head().magic.store(MAGIC, SeqCst);
        Ok(memory)
    }

    /// The page that this process was given.
    ///
    /// # Errors
    /// If `file` is not the page of a run of this plan.
    pub(super) fn open(file: OwnedFd, plan: &Plan) -> io::Result<Self> {
        let file = File::from(file);
        if file.metadata()?.len() != size(plan) as u64 {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "its size does not fit the plan"));
        }
        let memory = Self::map(file.into(), plan)?;
        let foreign = |what| Err(io::Error::new(io::ErrorKind::InvalidData, what));
        if memory.head().magic.load(SeqCst) != MAGIC {
            return foreign(
                "it belongs to another version of Phalanx; build all programs of the run from the same one",
            );
        }
        if memory.head().plan.load(SeqCst) != memory.fingerprint {
            return foreign("it belongs to another plan");
        }
        Ok(memory)
    }

    fn map(file: OwnedFd, plan: &Plan) -> io::Result<Self> {
        let (phases, workers, traced) = (plan.phase_count(), plan.workers.len(), plan.traced as usize);
        let bytes = size(plan);
        // SAFETY: a new mapping at an address that the kernel chooses; the file is at least `bytes` long.
        let address = unsafe {
            rustix::mm::mmap(
                std::ptr::null_mut(),
                bytes,
                ProtFlags::READ | ProtFlags::WRITE,
                MapFlags::SHARED | MapFlags::POPULATE,
                &file,
                0,
            )?
        };
        let base = NonNull::new(address.cast()).ok_or(io::ErrorKind::OutOfMemory)?;
        let members = (0..phases).map(|phase| plan.members(phase).len() as u32).collect();
        let (mapping, fingerprint, waker) = (Mapping { base, bytes }, plan.fingerprint(), plan.wake.into());
        Ok(Self { mapping, members, fingerprint, phases, workers, traced, waker, file })
    }

    /// The file, to hand it to a child.
    pub(super) fn file(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }

    #[inline]
    pub(super) fn head(&self) -> &Head {
        // SAFETY: the mapping begins with a head; all bit patterns are valid atomics.
        unsafe { self.mapping.base.as_ref() }
    }

    /// The word on which processes sleep at `point`.
    #[inline]
    pub(super) fn wait_word(&self, point: WaitPoint) -> &AtomicU32 {
        match point {
            WaitPoint::Bell => &self.head().bell,
            WaitPoint::Gate(phase) => &self.phase(phase).gate,
        }
    }

    #[inline]
    pub(super) fn phase(&self, phase: usize) -> &Phase {
        assert!(phase < self.phases);
        // SAFETY: `map` made room for `phases` of them behind the head, where one is aligned (see the assertions).
        unsafe { self.mapping.base.add(1).cast::<Phase>().add(phase).as_ref() }
    }

    #[inline]
    pub(super) fn slot(&self, worker: usize) -> &Slot {
        assert!(worker < self.workers);
        // SAFETY: `map` made room for `workers` of them behind the phases, where one is aligned (see the assertions).
        unsafe { self.mapping.base.add(1).cast::<Phase>().add(self.phases).cast::<Slot>().add(worker).as_ref() }
    }

    pub(super) fn counters(&self, worker: usize) -> &Counters {
        &self.slot(worker).counters
    }

    /// Whether the page is that of this run, as far as its first words say.
    pub(super) fn has_its_mark(&self) -> bool {
        let head = self.head();
        head.magic.load(SeqCst) == MAGIC && head.plan.load(SeqCst) == self.fingerprint
    }

    /// Where run number `run` of a worker is traced, in the place of an older one; `None` if nothing is.
    pub(super) fn event(&self, worker: usize, run: u64) -> Option<&Event> {
        let place = run.checked_rem(self.traced as u64)? as usize;
        assert!(worker < self.workers);
        // SAFETY: behind the slots, `map` made room for `traced` events of every worker; `place` is below that.
        Some(unsafe {
            let slots = self.mapping.base.add(1).cast::<Phase>().add(self.phases).cast::<Slot>();
            slots.add(self.workers).cast::<Event>().add(worker * self.traced + place).as_ref()
        })
    }
}
