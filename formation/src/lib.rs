//! The words that all schemes share: scenarios and their formulas, vehicles, the communication graph, the mathematics, and
//! the way from a scenario to the network of its participants.

pub mod config;
pub mod data;
pub mod effects;
pub mod formula;
pub mod math;
pub mod networks;
mod role;
pub mod scenario;
mod text;
pub mod vehicle;
pub mod wiring;

pub use nalgebra;
