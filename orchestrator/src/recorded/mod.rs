//! A recorded run as an input of another one: its scenario, its samples step by step, its participants played again.

mod error;
mod played;
mod scenario;
mod tape;

pub use error::ReplayError;
pub use played::played;
pub(crate) use scenario::{scenario_in, scenario_of};
pub use tape::Tape;
