//! The mathematics that several schemes share, each piece in one place.

mod angle;
mod bouc_wen;
mod differentiator;
mod graph;
mod integrate;
mod lp;
mod philox;
mod potential;
mod power;
mod projection;
mod random;

pub use angle::wrap;
pub use bouc_wen::BoucWen;
pub use differentiator::{Differentiator, DifferentiatorGains};
pub use graph::{
    Family, Link, LinkError, Neighbourhood, NeighbourhoodSchedule, Orientation, Spectrum, Topology, TopologySchedule,
};
pub use integrate::{Integrator, Method, Rk4};
pub use lp::regulate;
pub use philox::{RandomStream, philox};
pub use potential::PotentialField;
pub use power::{sig, sig_vector, sign, sign_vector};
pub use projection::{Projection, clip, clip_vector};
pub use random::SplitMix64;
