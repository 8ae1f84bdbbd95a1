//! What a run is worth: its metrics and their bands, its assertions, and the claims that compare runs.

pub mod assertions;
pub mod claims;
pub mod metrics;
pub mod verdict;
