//! Scenario files: what they say, checked and complete.
//!
//! [`Scenario::load`] reads a file, overlays a variant and the overrides of the command line, and checks everything that does
//! not depend on a component. [`Assembly`](crate::wiring::Assembly) then reads the components and connects them.

mod agents;
mod context;
mod coordinates;
mod expectation;
mod failure;
mod formulas;
mod load;
mod obstacles;
mod overrides;
mod proximity;
mod ranges;
mod schema;
mod timing;
mod wishes;

pub use agents::Agent;
pub use context::{Context, Disturbance};
pub use expectation::Expectation;
pub use failure::{FailurePolicy, MOST_RESTARTS, OnFailure};
pub use load::{SECTIONS, Scenario, Selection};
pub use obstacles::{Boundary, Obstacles};
pub use proximity::{AdjacencyRow, Proximity};
pub use ranges::FieldRange;
pub use schema::sections;
pub use timing::Timing;
