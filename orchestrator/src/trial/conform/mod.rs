//! The contract of a participant, tried on a program point by point: against recorded inputs, without a run of its own.

mod checks;
mod inspect;
mod report;
mod standalone;
mod supervise;
mod test_run;

pub use checks::{ConformanceTest, conform};
pub use inspect::Range;
pub use report::{Check, Report, Verdict};
pub use supervise::supervise;
