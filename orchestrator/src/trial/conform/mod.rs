//! The contract of a participant, tried on a program point by point: against recorded inputs, without a run of its own.

mod inspect;
mod kit;
mod point;
mod probe;
mod supervise;
mod trial;

pub use inspect::Range;
pub use kit::{Demands, conform};
pub use point::{Point, Report, Verdict};
pub use supervise::supervise;
