//! The vehicles of a run: integrates their dynamics under the commands of the controllers and publishes their states.

mod actuators;
pub mod laboratory;
mod model_body;
mod vehicles;

pub use actuators::Actuators;
pub use laboratory::Laboratory;
pub use vehicles::{Vehicles, VehiclesParticipant};

use formation::wiring::Kind;

/// Every plant that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<Vehicles>("vehicles", "the vehicles of the scenario, integrated with fixed steps"),
    Kind::of::<Laboratory>(
        laboratory::KIND,
        "robots whose motors and links lag, seen by cameras that are late and sometimes blind",
    ),
];
