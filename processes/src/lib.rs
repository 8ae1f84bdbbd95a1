//! Runs of a network in many processes, in lockstep: they meet at gates and exchange samples through iceoryx2.
//!
//! What runs is said in the words of the crate [`lockstep`], which also runs it in one process ([`lockstep::Local`]) with the
//! same bits.
//!
//! Spread the nodes of a network over the workers of a [`Plan`](lockstep::Plan), create a [`Conductor`] in a [`RunDirectory`],
//! and have every spawned program call [`serve`]; the example `chain14` does all of this in a hundred lines.
//!
//! The functions of a worker's step carry `link_section = "lockstep_step"`: they stand together in the program, on four or five
//! pages instead of one each. Where hundreds of processes take turns on a core, each fetches all that it touches anew, and
//! pages are what costs most. SAFETY: the section is code, as `.text` is, of a name that nothing else uses.

mod board;
mod board_parts;
mod bus;
mod cell;
mod conductor;
pub mod console;
mod cores;
mod descendants;
mod directory;
mod monitor;
mod page;
mod seal;
mod service;
mod tap;
mod ticks;
mod worker;

pub use conductor::{
    Activity, Conductor, CoreFindings, Death, History, Interrupt, Late, PhaseUsage, RunError, Settings, Snapshot, Span,
    Statistics, WorkerUsage,
};
pub use cores::{CoreSlot, allowed_cores, keep_off_core, pin_to_core};
pub use directory::{DirectoryError, RunDirectory, Swept};
pub use monitor::{Monitor, MonitorError};
pub use page::run_name;
pub use service::ServiceError;
pub use tap::{Tap, TapHeader};
pub use worker::{DueNode, Link, NotAWorker, Replacement, Worker, serve};
