//! How components become participants: what they publish, what they read, and the network that follows.
//!
//! A scenario names one component per role ([`Kind`]). A component says what it publishes ([`Component::outputs`]) and,
//! while it is built, asks for the signals it needs by name ([`Bind`]). Whatever fits together by its signals works together;
//! what does not is refused with the signal that is missing.

mod assembly;
mod bind;
mod component;
mod components;
mod external;
mod instruments;
mod interface;
mod links;
mod named_participants;
mod node_role;
mod outputs;
mod present;
mod ranges;
mod station;
mod swapped;
pub mod testing;
mod unbound;

pub use crate::role::Role;
pub use assembly::{Assembly, Roles};
pub use bind::{Bind, Refusal, Signals};
pub use component::{Checks, Component, Kind};
pub use external::EXTERNAL;
pub use interface::Interface;
pub use links::AskedLink;
pub use node_role::NodeRole;
pub use outputs::{BoundOutputs, Outputs};
pub use present::present;
pub use station::{
    Built, SCENARIO_FILE, SCENARIO_FOLDER, Station, kinds, load_scenario, pair, participant, run_selection,
    scenario_text,
};
pub use swapped::Swapped;
