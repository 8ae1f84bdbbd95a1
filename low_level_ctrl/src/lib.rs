//! Controllers: the input of one agent. One file each.

mod attitude_reference;
mod hierarchical_uav;
mod local_error;
mod sliding_avoidance;

pub use attitude_reference::{Differentiation, DifferentiatorSettings, HeldSlope, SlopePair};
pub use hierarchical_uav::{HierarchicalUav, HierarchicalUavController};

pub use local_error::LocalError;
pub use sliding_avoidance::{AvoidanceSignals, SlidingAvoidance, SlidingAvoidanceController, SlidingAvoidanceGains};

use formation::wiring::Kind;

/// Every controller that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<HierarchicalUav>(
        "hierarchical_uav",
        "position loop, guidance and attitude loop of a quadcopter that tracks its reference (7.31) to (7.43)",
    ),
    Kind::of::<SlidingAvoidance>(
        "sliding_avoidance",
        "sliding mode formation control with disturbance estimates and potential fields around obstacles (3.13)",
    ),
];
