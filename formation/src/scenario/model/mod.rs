//! Vehicles by equations: `[vehicle]` with `kind = "equations"`, or with the name of a vehicle of the library.

mod compile;
mod description;
mod library;
mod section;
mod vehicles;

pub(super) use compile::Surroundings;
pub(super) use library::resolve;
pub use library::{LIBRARY, LibraryVehicle, VehicleParts};
pub(super) use section::{NamedVehicles, vehicle as vehicle_schema};
pub(super) use vehicles::{VehicleOf, Vehicles};
