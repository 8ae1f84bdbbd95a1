//! Controllers: the input of one agent. One file each.

mod attitude_reference;
mod hierarchical_neural;
mod hierarchical_uav;
mod limited_information;
mod local_error;

pub use attitude_reference::{Differentiation, DifferentiatorSettings, HeldSlope, SlopePair};
pub use hierarchical_neural::{HierarchicalNeural, NeuralTracking, VirtualAgent};
pub use hierarchical_uav::{HierarchicalUav, HierarchicalUavController};
pub use limited_information::{LimitedInformation, LimitedInformationController, Motion};

pub use local_error::LocalError;

use formation::wiring::Kind;

/// Every controller that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<LimitedInformation>(
        "limited_information",
        "sliding mode formation control from estimated velocities, with repulsion between robots (4.28), (4.31)",
    ),
    Kind::of::<HierarchicalNeural>(
        "hierarchical_neural",
        "a robot of order 1 or 2 tracks its reference; a network cancels the disturbance (7.59) to (7.65)",
    ),
    Kind::of::<HierarchicalUav>(
        "hierarchical_uav",
        "position loop, guidance and attitude loop of a quadcopter that tracks its reference (7.31) to (7.43)",
    ),
];
