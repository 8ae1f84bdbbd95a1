//! The program `phalanx`: from a scenario file to a run, its log, and what comes out of it.

pub mod catalog;
pub mod log;
pub mod metrics;
