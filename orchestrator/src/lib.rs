//! The program `phalanx`: from a scenario file to a run, its log, and what comes out of it.

// First, so that its macros are known in all that follows.
#[macro_use]
mod printing;

pub mod assertions;
pub mod catalog;
pub mod claims;
pub mod cli;
mod commands;
pub mod conform;
pub mod control;
mod drawing;
pub mod engine;
mod export;
pub mod failure;
mod figures;
mod layouts;
mod leftovers;
pub mod log;
pub mod logging;
pub mod metrics;
pub mod pinning;
pub mod placement;
pub mod profile;
mod progress;
mod recording;
mod recovery;
pub mod replay;
pub mod report;
pub mod robots;
pub mod run;
pub mod scaffold;
pub mod scene;
pub mod schema;
pub mod stress;
pub mod swap;
mod terminal;
pub mod thesis;
pub mod urgency;
pub mod verdict;
pub mod view;
mod watch;
