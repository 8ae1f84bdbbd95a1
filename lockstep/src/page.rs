//! The page of shared memory at which the processes of a run meet: gates, arrivals, faults.
//!
//! It is an anonymous file inherited by the children: it has no name, so nothing is left of it when the last process ends.
//!
//! A step goes through the phases like this. The conductor clears the arrivals and opens the gate of phase 0. Every worker
//! of the phase runs and sets its bit; whoever sets the last bit opens the gate of the next phase, or, after the last phase,
//! rings the bell for the conductor. So a phase takes one wake-up per worker and the whole step one for the conductor. The
//! bits are the truth about who is where; gates and bell only wake.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering::SeqCst};
use std::time::Duration;

use rustix::fs::{MemfdFlags, SealFlags};
use rustix::mm::{MapFlags, ProtFlags};
use rustix::thread::futex;

use crate::plan::{MAX_MEMBERS, Plan};

/// First word of a page: its kind and version.
const MAGIC: u64 = u64::from_le_bytes(*b"phalanx1");
/// Bit of a gate that says: no further step.
const STOP: u32 = 1 << 31;
/// Bytes of a message in a fault slot.
const MESSAGE_BYTES: usize = 1000;

#[repr(C, align(128))]
struct Head {
    magic: AtomicU64,
    /// Rung for the conductor; counts up, so that a change while it looks around is not lost.
    bell: AtomicU32,
    /// How many workers are connected.
    ready: AtomicU32,
    /// How many workers have filled their fault slot.
    faults: AtomicU32,
}

#[repr(C, align(128))]
struct Phase {
    /// Number of steps released, modulo 2^31, and [`STOP`].
    gate: AtomicU32,
    /// How many workers take part.
    members: AtomicU32,
    /// Which of the masks are full.
    summary: AtomicU64,
    /// Who has arrived, 64 workers to a word.
    masks: [AtomicU64; MAX_MEMBERS / 64],
}

#[repr(C, align(128))]
struct Slot {
    /// 1 as soon as the worker is connected.
    ready: AtomicU32,
    /// A [`FaultKind`] as number, or 0.
    kind: AtomicU32,
    step: AtomicU64,
    node: AtomicU32,
    length: AtomicU32,
    message: [AtomicU8; MESSAGE_BYTES],
}

/// What a worker reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum FaultKind {
    /// It could not start.
    Refusal = 1,
    /// A participant could not compute its step.
    Fault = 2,
}

/// A worker's report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Report {
    pub(crate) kind: FaultKind,
    pub(crate) node: usize,
    pub(crate) step: u64,
    pub(crate) message: String,
}

/// The mapped page.
pub(crate) struct Page {
    base: NonNull<Head>,
    bytes: usize,
    phases: usize,
    workers: usize,
    file: OwnedFd,
}

// SAFETY: the page consists of atomics only; the mapping lives as long as the value.
unsafe impl Send for Page {}
// SAFETY: as above.
unsafe impl Sync for Page {}

fn size(phases: usize, workers: usize) -> usize {
    size_of::<Head>() + phases * size_of::<Phase>() + workers * size_of::<Slot>()
}

impl Page {
    /// A new page for a run.
    pub(crate) fn create(plan: &Plan) -> io::Result<Self> {
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        let file = rustix::fs::memfd_create("phalanx", flags)?;
        rustix::fs::ftruncate(&file, size(plan.phase_count(), plan.workers.len()) as u64)?;
        // A child that cut the file short would kill everybody who touches it.
        rustix::fs::fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        let page = Self::map(file, plan)?;
        for phase in 0..page.phases {
            page.phase(phase).members.store(plan.members(phase).len() as u32, SeqCst);
        }
        page.head().magic.store(MAGIC, SeqCst);
        Ok(page)
    }

    /// The page that this process was given.
    ///
    /// # Errors
    /// If `file` is not the page of a run of this plan.
    pub(crate) fn open(file: OwnedFd, plan: &Plan) -> io::Result<Self> {
        let file = File::from(file);
        if file.metadata()?.len() != size(plan.phase_count(), plan.workers.len()) as u64 {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "its size does not fit the plan"));
        }
        let page = Self::map(file.into(), plan)?;
        match page.head().magic.load(SeqCst) {
            MAGIC => Ok(page),
            _ => Err(io::Error::new(io::ErrorKind::InvalidData, "it belongs to another version")),
        }
    }

    fn map(file: OwnedFd, plan: &Plan) -> io::Result<Self> {
        let (phases, workers) = (plan.phase_count(), plan.workers.len());
        let bytes = size(phases, workers);
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
        Ok(Self { base, bytes, phases, workers, file })
    }

    /// The file, to hand it to a child.
    pub(crate) fn file(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }

    fn head(&self) -> &Head {
        // SAFETY: the mapping begins with a head; all bit patterns are valid atomics.
        unsafe { self.base.as_ref() }
    }

    fn phase(&self, phase: usize) -> &Phase {
        assert!(phase < self.phases);
        // SAFETY: `map` made room for `phases` of them behind the head; sizes are multiples of the alignment.
        unsafe { self.base.add(1).cast::<Phase>().add(phase).as_ref() }
    }

    fn slot(&self, worker: usize) -> &Slot {
        assert!(worker < self.workers);
        // SAFETY: as for the phases, behind them.
        unsafe { self.base.add(1).cast::<Phase>().add(self.phases).cast::<Slot>().add(worker).as_ref() }
    }

    // The conductor's side.

    /// Opens a step: nobody has arrived anywhere, and phase 0 may go.
    pub(crate) fn begin(&self, step: u64) {
        for phase in (0..self.phases).map(|phase| self.phase(phase)) {
            phase.summary.store(0, SeqCst);
            let words = phase.members.load(SeqCst).div_ceil(64) as usize;
            phase.masks[..words].iter().for_each(|mask| mask.store(0, SeqCst));
        }
        self.open_gate(0, step);
    }

    /// Whether all workers of a phase have arrived.
    pub(crate) fn is_complete(&self, phase: usize) -> bool {
        let phase = self.phase(phase);
        phase.summary.load(SeqCst) == full(phase.members.load(SeqCst).div_ceil(64))
    }

    /// Whether the worker at `position` in a phase has arrived.
    pub(crate) fn has_arrived(&self, phase: usize, position: usize) -> bool {
        self.phase(phase).masks[position / 64].load(SeqCst) & 1 << (position % 64) != 0
    }

    /// How often the bell has been rung.
    pub(crate) fn rings(&self) -> u32 {
        self.head().bell.load(SeqCst)
    }

    /// Sleeps until the bell is rung more often than `rings`, or for `patience`.
    pub(crate) fn sleep(&self, rings: u32, patience: Duration) {
        let timeout =
            rustix::event::Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: patience.subsec_nanos().into() };
        // Whatever ends the wait, the caller looks at the page again.
        let _ = futex::wait(&self.head().bell, futex::Flags::empty(), rings, Some(&timeout));
    }

    /// Lets every worker end, now or at its next gate.
    pub(crate) fn stop(&self) {
        for phase in (0..self.phases).map(|phase| self.phase(phase)) {
            phase.gate.fetch_or(STOP, SeqCst);
            wake_all(&phase.gate);
        }
    }

    /// How many workers are connected.
    pub(crate) fn ready_count(&self) -> usize {
        self.head().ready.load(SeqCst) as usize
    }

    /// Whether a worker is connected.
    pub(crate) fn is_ready(&self, worker: usize) -> bool {
        self.slot(worker).ready.load(SeqCst) != 0
    }

    /// How many reports there are.
    pub(crate) fn report_count(&self) -> u32 {
        self.head().faults.load(SeqCst)
    }

    /// What a worker reported, if it did.
    pub(crate) fn report(&self, worker: usize) -> Option<Report> {
        let slot = self.slot(worker);
        let kind = match slot.kind.load(SeqCst) {
            0 => return None,
            1 => FaultKind::Refusal,
            _ => FaultKind::Fault,
        };
        let length = (slot.length.load(SeqCst) as usize).min(MESSAGE_BYTES);
        let bytes: Vec<u8> = slot.message[..length].iter().map(|byte| byte.load(SeqCst)).collect();
        let message = String::from_utf8_lossy(&bytes).into_owned();
        Some(Report { kind, node: slot.node.load(SeqCst) as usize, step: slot.step.load(SeqCst), message })
    }

    // The workers' side.

    /// Waits until a phase of `step` is open; `false` if there is no such step any more.
    pub(crate) fn await_gate(&self, phase: usize, step: u64) -> bool {
        let gate = &self.phase(phase).gate;
        let wanted = released(step);
        loop {
            let value = gate.load(SeqCst);
            if value & STOP != 0 {
                return false;
            }
            if value == wanted {
                return true;
            }
            // EAGAIN and EINTR mean: look again.
            let _ = futex::wait(gate, futex::Flags::empty(), value, None);
        }
    }

    /// The worker at `position` in a phase is done with it; the last one lets the run go on.
    pub(crate) fn arrive(&self, phase: usize, position: usize, step: u64) {
        let place = self.phase(phase);
        let members = place.members.load(SeqCst);
        let (word, bit) = (position / 64, 1 << (position % 64));
        let in_word = (members - 64 * word as u32).min(64);
        if place.masks[word].fetch_or(bit, SeqCst) | bit != full(in_word) {
            return;
        }
        if place.summary.fetch_or(1 << word, SeqCst) | 1 << word != full(members.div_ceil(64)) {
            return;
        }
        if phase + 1 < self.phases {
            self.open_gate(phase + 1, step);
        } else {
            self.ring();
        }
    }

    /// This worker is connected.
    pub(crate) fn mark_ready(&self, worker: usize) {
        self.slot(worker).ready.store(1, SeqCst);
        if self.head().ready.fetch_add(1, SeqCst) + 1 == self.workers as u32 {
            self.ring();
        }
    }

    /// Leaves a report; the message is cut at 1000 bytes.
    pub(crate) fn leave(&self, worker: usize, report: &Report) {
        let slot = self.slot(worker);
        let mut length = report.message.len().min(MESSAGE_BYTES);
        while !report.message.is_char_boundary(length) {
            length -= 1;
        }
        slot.message.iter().zip(&report.message.as_bytes()[..length]).for_each(|(to, &from)| to.store(from, SeqCst));
        slot.length.store(length as u32, SeqCst);
        slot.node.store(report.node as u32, SeqCst);
        slot.step.store(report.step, SeqCst);
        slot.kind.store(report.kind as u32, SeqCst);
        self.head().faults.fetch_add(1, SeqCst);
        self.ring();
    }

    // Both sides.

    /// Wakes the conductor.
    pub(crate) fn ring(&self) {
        // The word changes first: who is about to sleep on the old value then does not.
        self.head().bell.fetch_add(1, SeqCst);
        wake_all(&self.head().bell);
    }

    fn open_gate(&self, phase: usize, step: u64) {
        let gate = &self.phase(phase).gate;
        // Not a plain store: a stop that comes in between must stay.
        let before = gate.load(SeqCst);
        if before & STOP == 0 && gate.compare_exchange(before, released(step), SeqCst, SeqCst).is_ok() {
            wake_all(gate);
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // SAFETY: what `map` mapped; no reference into it outlives the value. Failure leaves a mapping behind, no more.
        let _ = unsafe { rustix::mm::munmap(self.base.as_ptr().cast(), self.bytes) };
    }
}

/// What a gate shows once `step` may run.
fn released(step: u64) -> u32 {
    (step + 1) as u32 & !STOP
}

/// The lowest `count` bits, up to 64.
fn full(count: u32) -> u64 {
    u64::MAX.checked_shr(64 - count).unwrap_or(0)
}

fn wake_all(word: &AtomicU32) {
    let _ = futex::wake(word, futex::Flags::empty(), i32::MAX as u32);
}
