//! Lockstep execution of participants that exchange samples at a fixed step.
//!
//! This crate knows no robot. It knows *participants* (nodes with a `step`), *channels* (one writer, many readers, one
//! sample per step), the *phases* that follow from who reads whom in the same step, and two ways to run them: all in one
//! process ([`Local`]), or spread over processes that meet at futex gates and exchange samples through iceoryx2.
//!
//! Start with [`Participant`] and [`Network`].

mod layout;
mod local;
mod network;
mod participant;
mod sample;
mod store;

pub use layout::{Field, Layout, Shape};
pub use local::{Local, StepError};
pub use network::{Channel, ChannelId, Input, LoopError, Network, Node, Timing};
pub use participant::{Fault, In, Io, Out, Participant, Ports, Slice, Step};
pub use sample::{HEADER_BYTES, Header, Status};
pub use store::Store;
