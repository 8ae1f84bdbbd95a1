//! The memory behind the page: made, mapped and unmapped here, and nowhere else looked at as raw bytes.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering::SeqCst};

use rustix::fs::{MemfdFlags, SealFlags};
use rustix::mm::{MapFlags, ProtFlags};

use super::claim::Claim;
use super::side::{SIDES, Share, Side};
use super::tally::{Event, Tally};
use super::wake::Waker;
use lockstep::{MAX_MEMBERS, Plan};

/// First word of a page: its kind and version.
pub(super) const MAGIC: u64 = u64::from_le_bytes(*b"phalanx5");
/// Bytes of a message in a slot.
pub(super) const MESSAGE_BYTES: usize = 1000;

#[repr(C, align(128))]
pub(super) struct Head {
    pub(super) magic: AtomicU64,
    /// The [`Plan::fingerprint`] of the run.
    pub(super) plan: AtomicU64,
    /// Rung for the conductor; counts up, so that a change while it looks around is not lost.
    pub(super) bell: AtomicU32,
    /// How many workers are connected.
    pub(super) ready: AtomicU32,
    /// How many workers have filled their fault slot.
    pub(super) faults: AtomicU32,
    /// Where to look for changes; on a line of its own, because everybody reads it in every step.
    pub(super) changes: Changes,
    /// The pace of the run; on a line of its own, because every step writes here.
    pub(super) pace: Pace,
    /// The cores that the run is spread over.
    pub(super) sides: [Side; SIDES],
}

/// What all look at in every step and few change.
#[repr(C, align(128))]
pub(super) struct Changes {
    /// How often a worker was replaced.
    pub(super) count: AtomicU32,
    /// Ticks within which who hands its core on must get it back; 0: nobody hands it on.
    pub(super) passing: AtomicU64,
    /// Ticks for which a side may be watched; 0: the run has one side only.
    pub(super) watching: AtomicU64,
}

/// How far the run is and how far it may go, in numbers of steps.
#[repr(C, align(128))]
pub(super) struct Pace {
    /// Steps below this may run.
    pub(super) limit: AtomicU64,
    /// Who completes a step.
    pub(super) finish: Claim,
    /// Steps that are complete.
    pub(super) completed: AtomicU64,
    /// The conductor wants to be woken as soon as so many are complete.
    pub(super) wake_at: AtomicU64,
}

#[repr(C, align(128))]
pub(super) struct Phase {
    /// Number of steps released, modulo 2^31, and [`STOP`].
    pub(super) gate: AtomicU32,
    /// Who opens the gate for a step.
    pub(super) claim: Claim,
    /// When the gate was opened last, in ticks; written before it opens.
    pub(super) opened_at: AtomicU64,
    /// How long the phase has lasted in all steps together, in ticks.
    pub(super) lasted: AtomicU64,
    /// The workers of each side.
    pub(super) shares: [Share; SIDES],
    /// Who has arrived, 64 workers to a word.
    pub(super) masks: [AtomicU64; MAX_MEMBERS / 64],
}

#[repr(C, align(128))]
pub(super) struct Slot {
    /// 1 as soon as the worker is connected.
    pub(super) ready: AtomicU32,
    /// Number of the process that serves as this worker: 0 is the one that was started first.
    pub(super) incarnation: AtomicU32,
    /// The process that has taken the place; 0 as long as nobody has.
    pub(super) process: AtomicU32,
    /// 1 if the process is to leave its place to another one.
    pub(super) dismissed: AtomicU32,
    /// Which side it belongs to.
    pub(super) side: AtomicU32,
    /// A [`FaultKind`] as number, or 0.
    pub(super) kind: AtomicU32,
    pub(super) step: AtomicU64,
    pub(super) node: AtomicU32,
    pub(super) length: AtomicU32,
    pub(super) tally: Tally,
    pub(super) message: [AtomicU8; MESSAGE_BYTES],
}

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

/// The mapped page.
pub(crate) struct Page {
    mapping: Mapping,
    /// How many workers take part in each phase. Not read from the page, where a stray pointer may change it.
    members: Box<[u32]>,
    /// The [`Plan::fingerprint`] of the run.
    pub(super) fingerprint: u64,
    pub(super) phases: usize,
    pub(super) workers: usize,
    /// Runs of every worker that are kept for a trace.
    pub(super) traced: usize,
    /// Of this process.
    pub(super) waker: Waker,
    file: OwnedFd,
}

// Phases stand behind the head, slots behind the phases, events behind the slots, without a gap: each part must end where the
// next one may begin. The kernel places a mapping at the start of a memory page, which is aligned for a head.
const _: () = {
    assert!(size_of::<Head>().is_multiple_of(align_of::<Phase>()));
    assert!(size_of::<Phase>().is_multiple_of(align_of::<Slot>()));
    assert!(size_of::<Head>().is_multiple_of(align_of::<Slot>()));
    assert!(size_of::<Slot>().is_multiple_of(align_of::<Event>()));
    assert!(size_of::<Head>().is_multiple_of(align_of::<Event>()));
    assert!(size_of::<Phase>().is_multiple_of(align_of::<Event>()));
    assert!(align_of::<Head>() <= 4096);
};

fn size(plan: &Plan) -> usize {
    let (phases, workers) = (plan.phase_count(), plan.workers.len());
    size_of::<Head>()
        + phases * size_of::<Phase>()
        + workers * (size_of::<Slot>() + plan.traced as usize * size_of::<Event>())
}

impl Page {
    /// A new page for a run.
    pub(crate) fn create(plan: &Plan) -> io::Result<Self> {
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        let file = rustix::fs::memfd_create("phalanx", flags)?;
        rustix::fs::ftruncate(&file, size(plan) as u64)?;
        // A child that cut the file short would kill everybody who touches it.
        rustix::fs::fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        let page = Self::map(file, plan)?;
        for phase in 0..page.phases {
            let members = page.members(phase);
            page.phase(phase).shares[0].members.store(members, SeqCst);
        }
        page.head().plan.store(page.fingerprint, SeqCst);
        page.head().magic.store(MAGIC, SeqCst);
        Ok(page)
    }

    /// The page that this process was given.
    ///
    /// # Errors
    /// If `file` is not the page of a run of this plan.
    pub(crate) fn open(file: OwnedFd, plan: &Plan) -> io::Result<Self> {
        let file = File::from(file);
        if file.metadata()?.len() != size(plan) as u64 {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "its size does not fit the plan"));
        }
        let page = Self::map(file.into(), plan)?;
        let stranger = |what| Err(io::Error::new(io::ErrorKind::InvalidData, what));
        if page.head().magic.load(SeqCst) != MAGIC {
            return stranger(
                "it belongs to another version of Phalanx; build all programs of the run from the same one",
            );
        }
        if page.head().plan.load(SeqCst) != page.fingerprint {
            return stranger("it belongs to another plan");
        }
        Ok(page)
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
    pub(crate) fn file(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }

    pub(super) fn head(&self) -> &Head {
        // SAFETY: the mapping begins with a head; all bit patterns are valid atomics.
        unsafe { self.mapping.base.as_ref() }
    }

    /// How many workers take part in a phase.
    pub(super) fn members(&self, phase: usize) -> u32 {
        self.members[phase]
    }

    pub(super) fn phase(&self, phase: usize) -> &Phase {
        assert!(phase < self.phases);
        // SAFETY: `map` made room for `phases` of them behind the head, where one is aligned (see the assertions).
        unsafe { self.mapping.base.add(1).cast::<Phase>().add(phase).as_ref() }
    }

    pub(super) fn slot(&self, worker: usize) -> &Slot {
        assert!(worker < self.workers);
        // SAFETY: `map` made room for `workers` of them behind the phases, where one is aligned (see the assertions).
        unsafe { self.mapping.base.add(1).cast::<Phase>().add(self.phases).cast::<Slot>().add(worker).as_ref() }
    }

    pub(super) fn tally(&self, worker: usize) -> &Tally {
        &self.slot(worker).tally
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
