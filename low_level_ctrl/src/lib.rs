//! Controllers: the input of one agent. One file each.

mod attitude_reference;
mod consensus;
mod hierarchical_neural;
mod hierarchical_uav;
mod local_error;
mod saturated_compensated;
mod saturated_neural;
mod saturated_nominal;
mod sliding_feedback;

pub use attitude_reference::{Differentiation, DifferentiatorSettings, HeldSlope, SlopePair};
pub use consensus::Consensus;
pub use hierarchical_neural::{HierarchicalNeural, NeuralTracking, VirtualAgent};
pub use hierarchical_uav::{HierarchicalUav, HierarchicalUavController};
pub use saturated_compensated::{Regulation, SaturatedCompensated, SaturatedCompensatedController};
pub use saturated_neural::{SaturatedNeural, SaturatedNeuralController};
pub use saturated_nominal::{SaturatedNominal, SaturatedNominalController};
pub use sliding_feedback::{Command, FormationErrors, SlidingFeedback};

pub use local_error::LocalError;

use formation::wiring::Kind;

/// Every controller that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<Consensus>("consensus", "linear consensus tracking of planar robots, the example of the documentation"),
    Kind::of::<HierarchicalNeural>(
        "hierarchical_neural",
        "a robot of order 1 or 2 tracks its reference; a network cancels the disturbance (7.59) to (7.65)",
    ),
    Kind::of::<HierarchicalUav>(
        "hierarchical_uav",
        "position loop, guidance and attitude loop of a quadcopter that tracks its reference (7.31) to (7.43)",
    ),
    Kind::of::<SaturatedCompensated>(
        "saturated_compensated",
        "sliding mode formation control with anti-windup, inputs clipped or regulated by a linear program (6.23), (6.24)",
    ),
    Kind::of::<SaturatedNeural>(
        "saturated_neural",
        "sliding mode formation control whose own network learns from the formation error (section 6.6)",
    ),
    Kind::of::<SaturatedNominal>("saturated_nominal", "sliding mode formation control, inputs clipped (6.21), (6.22)"),
];
