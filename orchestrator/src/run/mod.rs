//! One run: its processes, how they are placed and controlled, and what observes its steps.

pub mod control;
pub mod engine;
pub(crate) mod leftovers;
mod monitor;
mod observer;
mod observers;
mod options;
mod outcome;
pub mod pinning;
pub mod placement;
pub mod players;
pub mod priority;
pub mod profile;
mod progress;
pub(crate) mod recording;
mod recovery;
pub mod robots;
pub mod scene;
mod session;
pub(crate) mod sources;
pub mod stress;
pub mod swap;

pub use options::Options;
pub use outcome::{Ending, Outcome};
pub use session::run;
