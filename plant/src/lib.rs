//! The vehicles of a run: integrates their dynamics under the commands of the controllers and publishes their states.

mod actuators;
mod vehicles;

pub use actuators::Actuators;
pub use vehicles::{Vehicles, VehiclesParticipant};

use formation::wiring::Kind;

/// Every plant that a scenario may name.
pub const KINDS: &[Kind] = &[Kind::of::<Vehicles>("vehicles", "the vehicles of the scenario, integrated by RK4")];
