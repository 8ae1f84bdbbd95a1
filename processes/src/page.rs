//! The page of shared memory at which the processes of a run meet: gates, arrivals, reports, counters.
//!
//! It is an anonymous file inherited by the children: it has no name, so nothing is left of it when the last process ends.
//! Which process may run when is decided in [`protocol`], over the words that [`memory`] maps.

mod counters;
mod events;
mod layout;
mod memory;
mod protocol;
mod wake;
mod words;

use std::io;
use std::os::fd::{BorrowedFd, OwnedFd};
use std::sync::atomic::Ordering::SeqCst;

use lockstep::Plan;

pub(crate) use counters::{Run, Stopwatch};
pub(crate) use events::Events;
use layout::MESSAGE_BYTES;
use memory::SharedMemory;
pub(crate) use protocol::Arrival;
pub use wake::run_name;

/// The page of a run.
pub(crate) type Page = protocol::Page<SharedMemory>;

/// What a worker reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum FaultKind {
    /// It could not start.
    Refusal = 1,
    /// A participant could not compute its step.
    Fault = 2,
    /// It finds the page overwritten that it is about to report its step on.
    Overwritten = 3,
}

/// A worker's report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Report {
    pub(crate) kind: FaultKind,
    pub(crate) node: usize,
    pub(crate) step: u64,
    pub(crate) message: String,
}

impl Page {
    /// A new page for a run.
    pub(crate) fn create(plan: &Plan) -> io::Result<Self> {
        SharedMemory::create(plan).map(|memory| Self { memory })
    }

    /// The page that this process was given.
    ///
    /// # Errors
    /// If `file` is not the page of a run of this plan.
    pub(crate) fn open(file: OwnedFd, plan: &Plan) -> io::Result<Self> {
        SharedMemory::open(file, plan).map(|memory| Self { memory })
    }

    /// The file, to hand it to a child.
    pub(crate) fn file(&self) -> BorrowedFd<'_> {
        self.memory.file()
    }

    /// From now on this process wakes others by `events` and is woken by them; with `None`, no longer.
    pub(crate) fn use_events(&self, events: Option<Events>) {
        self.memory.waker.use_events(events);
    }
}

/// For the conductor.
impl Page {
    /// How many workers are connected.
    pub(crate) fn ready_count(&self) -> usize {
        self.memory.head().ready.load(SeqCst) as usize
    }

    /// Clears the place of a worker whose process has ended, with what it reported.
    pub(crate) fn vacate(&self, worker: usize) {
        let slot = self.memory.slot(worker);
        if slot.ready.swap(0, SeqCst) != 0 {
            self.memory.head().ready.fetch_sub(1, SeqCst);
        }
        if slot.kind.swap(0, SeqCst) != 0 {
            self.memory.head().faults.fetch_sub(1, SeqCst);
        }
        slot.dismissed.store(0, SeqCst);
        slot.process.store(0, SeqCst);
    }

    /// Whether a process has taken the place of a worker.
    pub(crate) fn is_taken(&self, worker: usize) -> bool {
        self.memory.slot(worker).process.load(SeqCst) != 0
    }

    /// Whether a worker is connected.
    pub(crate) fn is_ready(&self, worker: usize) -> bool {
        self.memory.slot(worker).ready.load(SeqCst) != 0
    }

    /// How many reports there are.
    pub(crate) fn report_count(&self) -> u32 {
        self.memory.head().faults.load(SeqCst)
    }

    /// What a worker reported, if it did.
    pub(crate) fn report(&self, worker: usize) -> Option<Report> {
        let slot = self.memory.slot(worker);
        let kind = match slot.kind.load(SeqCst) {
            0 => return None,
            1 => FaultKind::Refusal,
            2 => FaultKind::Fault,
            3 => FaultKind::Overwritten,
            // No worker writes that: the page was overwritten.
            _ => return None,
        };
        let length = (slot.length.load(SeqCst) as usize).min(MESSAGE_BYTES);
        let bytes: Vec<u8> = slot.message[..length].iter().map(|byte| byte.load(SeqCst)).collect();
        let message = String::from_utf8_lossy(&bytes).into_owned();
        Some(Report { kind, node: slot.node.load(SeqCst) as usize, step: slot.step.load(SeqCst), message })
    }
}

/// Which process serves as a worker.
impl Page {
    /// Number of the process that serves as a worker.
    pub(crate) fn incarnation(&self, worker: usize) -> u32 {
        self.memory.slot(worker).incarnation.load(SeqCst)
    }

    /// From now on the process with this number serves as a worker.
    pub(crate) fn take_over(&self, worker: usize, incarnation: u32) {
        self.memory.slot(worker).incarnation.store(incarnation, SeqCst);
        self.memory.head().settings.replacements.fetch_add(1, SeqCst);
    }

    /// How often a worker was replaced.
    pub(crate) fn replacements(&self) -> u32 {
        self.memory.head().settings.replacements.load(SeqCst)
    }
}

/// Whether the page was overwritten.
impl Page {
    /// What is overwritten on the page of a run; arguments and times as for `invalid_words`.
    pub(crate) fn damage(&self, recorded: u64, limit: u64, allowed: u64) -> Option<&'static str> {
        if self.memory.has_its_mark() { self.invalid_words(recorded, limit, allowed) } else { Some("its first words") }
    }

    /// Whether the page is as a worker must find it that is about to arrive in a phase of `step`.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn is_intact(&self, phase: usize, position: usize, step: u64) -> bool {
        self.expects_arrival(phase, position, step) && self.memory.has_its_mark()
    }
}

/// For the workers.
impl Page {
    /// Takes the place of a worker for the process `pid`.
    ///
    /// # Errors
    /// The process that has it already.
    pub(crate) fn take_place(&self, worker: usize, pid: u32) -> Result<(), u32> {
        self.memory.slot(worker).process.compare_exchange(0, pid, SeqCst, SeqCst).map(drop)
    }

    /// This worker is connected.
    pub(crate) fn mark_ready(&self, worker: usize) {
        self.memory.slot(worker).ready.store(1, SeqCst);
        if self.memory.head().ready.fetch_add(1, SeqCst) + 1 == self.memory.workers as u32 {
            self.ring();
        }
    }

    /// Leaves a report; the message is cut at 1000 bytes.
    pub(crate) fn leave(&self, worker: usize, report: &Report) {
        let slot = self.memory.slot(worker);
        let mut length = report.message.len().min(MESSAGE_BYTES);
        while !report.message.is_char_boundary(length) {
            length -= 1;
        }
        slot.message.iter().zip(&report.message.as_bytes()[..length]).for_each(|(to, &from)| to.store(from, SeqCst));
        slot.length.store(length as u32, SeqCst);
        slot.node.store(report.node as u32, SeqCst);
        slot.step.store(report.step, SeqCst);
        slot.kind.store(report.kind as u32, SeqCst);
        self.memory.head().faults.fetch_add(1, SeqCst);
        self.ring();
    }
}
