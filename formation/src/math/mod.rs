//! The mathematics that several schemes share, each piece in one place.

mod graph;
mod integrate;
mod power;
mod projection;
mod random;

pub use graph::Topology;
pub use integrate::Rk4;
pub use power::{sig, sig_vector, sign, sign_vector};
pub use projection::{Projection, clip, clip_vector};
pub use random::SplitMix64;
