//! The program `phalanx`: from a scenario file to a run, its log, and what comes out of it.

pub mod assertions;
pub mod catalog;
pub mod claims;
pub mod cli;
mod commands;
pub mod control;
mod drawing;
pub mod engine;
mod export;
pub mod failure;
mod figures;
pub mod log;
pub mod logging;
pub mod metrics;
pub mod pinning;
pub mod placement;
pub mod profile;
mod progress;
mod recovery;
pub mod report;
pub mod run;
pub mod stress;
pub mod swap;
pub mod thesis;
pub mod verdict;
pub mod view;
