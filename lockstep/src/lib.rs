//! The contract of participants that exchange samples at a fixed step, and a run of them in one process.
//!
//! This crate knows no robot, no operating system and no way to move samples between processes. It knows *participants* (nodes
//! with a `step`), *channels* (one writer, many readers, one sample per step), the *phases* that follow from which node reads
//! which in the same step, and a run of all of them in the calling thread ([`Local`]). The crate `processes` runs the same
//! network in many processes, as a [`Plan`] says, with the same bits.
//!
//! Start with [`Participant`] and [`Network`].

pub mod execute;
pub mod initial;
mod layout;
mod local;
mod network;
mod participant;
mod period;
mod plan;
mod sample;
mod seconds;
mod store;

pub use layout::{Field, Layout, Shape};
pub use local::{Local, LocalCounts, StepError};
pub use network::{Channel, ChannelId, Input, LoopError, Network, Node, Timing};
pub use participant::{Fault, In, Io, Out, Participant, Ports, Slice, Step};
pub use period::Period;
pub use plan::{MAX_MEMBERS, PLAN_FILE, Plan, PlanError, Wake, WorkerPlan, sha256};
pub use sample::{HEADER_BYTES, Header, MAX_WORDS, Status};
pub use seconds::{LONGEST_WAIT, duration, wait_time};
pub use store::Store;
