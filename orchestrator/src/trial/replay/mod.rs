//! Recorded runs played again: a log in the place of participants, and one participant against the recording of the others.

mod departure;
mod duet;
mod error;
mod played;
mod rerun;
mod tape;

pub use departure::{Departures, FieldDeparture, FirstDeparture};
pub use duet::{Duet, Setup};
pub use error::ReplayError;
pub use played::played;
pub use rerun::{Outcome, rerun};
pub use tape::Tape;
