//! One participant against the recording of the others.

mod departure;
mod duet;
mod rerun;

pub use departure::{Departures, FieldDeparture, FirstDeparture};
pub use duet::{Duet, Setup};
pub use rerun::{Outcome, rerun};
