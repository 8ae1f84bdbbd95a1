//! Lockstep execution of participants that exchange samples at a fixed step.
//!
//! This crate knows no robot. It knows *participants* (nodes with a `step`), *channels* (one writer, many readers, one
//! sample per step), the *phases* that follow from who reads whom in the same step, and two ways to run them: all in one
//! process ([`Local`]), or spread over processes that meet at gates and exchange samples through iceoryx2.
//!
//! Start with [`Participant`] and [`Network`]. To run a network in processes, spread its nodes over the workers of a [`Plan`],
//! create a [`Conductor`] in a [`RunDirectory`], and have every spawned program call [`serve`]; the example `chain14` does
//! all of this in a hundred lines.
//!
//! The functions of a worker's step carry `link_section = "lockstep_step"`: they stand together in the program, on four or five
//! pages instead of one each. Where hundreds of processes take turns on a core, each fetches all that it touches anew, and
//! pages are what costs most. SAFETY: the section is code, as `.text` is, of a name that nothing else uses.

mod board;
mod cell;
mod conductor;
mod cores;
mod directory;
mod execute;
mod layout;
mod local;
mod network;
mod onlooker;
mod page;
mod participant;
mod plan;
mod sample;
mod store;
mod tap;
mod ticks;
mod worker;

pub use board::ServiceError;
pub use cell::MAX_WORDS;
pub use conductor::{
    Activity, Balanced, Conductor, Death, Gauge, History, Interrupt, Late, PhaseUsage, RunError, Settings, Snapshot,
    Span, WorkerUsage,
};
pub use cores::{CoreSlot, allowed_cores, keep_off_core, pin_to_core};
pub use directory::{DirectoryError, RunDirectory};
pub use layout::{Field, Layout, Shape};
pub use local::{Local, StepError};
pub use network::{Channel, ChannelId, Input, LoopError, Network, Node, Timing};
pub use onlooker::{LookError, Onlooker};
pub use page::Wake;
pub use participant::{Fault, In, Io, Out, Participant, Ports, Slice, Step};
pub use plan::{Plan, PlanError, WorkerPlan};
pub use sample::{HEADER_BYTES, Header, Status};
pub use store::Store;
pub use tap::Tap;
pub use worker::{Comeback, Link, NotAWorker, Turn, Worker, serve};
