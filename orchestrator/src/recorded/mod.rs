//! A recorded run as an input of another one: its scenario, its samples step by step, its participants played again.

mod error;
mod played;
mod samples;
mod scenario;

pub use error::ReplayError;
pub use played::played;
pub use samples::RecordedSamples;
pub(crate) use scenario::{scenario_in, scenario_of};
