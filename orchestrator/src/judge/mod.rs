//! What a run is worth: its metrics against regression ranges and the thesis, its assertions, and the claims that compare runs.

pub mod assertions;
pub mod claims;
mod error;
pub mod metrics;
pub mod own;
pub mod verdict;

pub use error::JudgeError;
