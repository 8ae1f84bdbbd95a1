//! Controllers: the input of one agent. One file each.

mod attitude_reference;
mod dynamic_sliding;
mod dynamic_sliding_chebyshev;
mod dynamic_sliding_observer;
mod dynamic_sliding_switching;
mod hierarchical_neural;
mod hierarchical_uav;
mod local_error;

pub use attitude_reference::{Differentiation, DifferentiatorSettings, HeldSlope, SlopePair};
pub use dynamic_sliding::{AccelerationSource, DynamicSlidingVariable, SlidingErrors};
pub use dynamic_sliding_chebyshev::{
    ChebyshevSignals, CompensatedInput, DynamicSlidingChebyshev, DynamicSlidingChebyshevController,
};
pub use dynamic_sliding_observer::{DynamicSlidingObserver, DynamicSlidingObserverController, DynamicSlidingSignals};
pub use dynamic_sliding_switching::{DynamicSlidingSwitching, DynamicSlidingSwitchingController};
pub use hierarchical_neural::{HierarchicalNeural, NeuralTracking, VirtualAgent};
pub use hierarchical_uav::{HierarchicalUav, HierarchicalUavController};
pub use local_error::LocalError;

use formation::wiring::Kind;

/// Every controller that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<DynamicSlidingObserver>(
        "dynamic_sliding_observer",
        "dynamic sliding mode that feeds back the estimates of a disturbance observer (2.15)",
    ),
    Kind::of::<DynamicSlidingChebyshev>(
        "dynamic_sliding_chebyshev",
        "dynamic sliding mode with a Chebyshev network and an inverse model of the actuators (2.22), (2.23)",
    ),
    Kind::of::<DynamicSlidingSwitching>(
        "dynamic_sliding_switching",
        "nominal dynamic sliding mode that switches between bounds of the uncertainty (2.10)",
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
