//! One participant against the recording of the others.

mod departure;
mod replay_run;
mod rerun;

pub use departure::{Departures, FieldDeparture, FirstDeparture};
pub use replay_run::{ReplayRun, ReplaySetup};
pub use rerun::{Outcome, rerun};
