//! Scenario files: what they say, checked and complete.
//!
//! [`Scenario::load`] reads a file, overlays a variant and the overrides of the command line, and checks everything that does
//! not depend on a component. [`Assembly`](crate::wiring::Assembly) then reads the components and connects them.

mod agent_list;
mod agent_number;
mod agents;
mod context;
mod coordinates;
mod data;
mod disturbance;
mod elsewhere;
mod expectation;
mod failure;
mod formulas;
mod graph;
mod instruments;
mod links;
mod load;
mod lookup;
mod model;
mod obstacles;
mod overrides;
mod plant_groups;
mod program_parameters;
mod proximity;
mod ranges;
mod raw;
mod realtime;
mod renumber;
mod run_sections;
mod schema;
mod shipped;
mod standard_vehicle;
mod swap_target;
mod timing;
mod topology;

pub use agent_list::agents_in;
pub(crate) use agent_list::list_of;
pub use agent_number::AgentNumber;
pub use agents::Agent;
pub use context::Context;
pub use disturbance::Disturbance;
pub use expectation::{Expectation, Published};
pub use failure::{FailurePolicy, MOST_RESTARTS, OnFailure};
pub use graph::Graph;
pub use instruments::Instruments;
pub(crate) use instruments::{ACTUATORS, SENSORS};
pub use links::Links;
pub(crate) use links::{CompiledLink, LinkPlace};
pub use load::{Scenario, Selection};
pub use lookup::LookupError;
pub use model::{LIBRARY, LibraryVehicle, VehicleParts};
pub use obstacles::{Boundary, Obstacles};
pub(crate) use overrides::{Override, foreign};
pub use proximity::{AdjacencyRow, Proximity};
pub use ranges::FieldRange;
pub use raw::{SECTIONS, sections};
pub use realtime::Overrun;
pub use shipped::Shipped;
pub use swap_target::{Served, SwapTarget};
pub use timing::Timing;
