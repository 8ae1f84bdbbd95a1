//! Controllers: the input of one agent. One file each.

mod attitude_reference;
mod compensated_formation;
mod consensus;
mod dynamic_sliding;
mod dynamic_sliding_chebyshev;
mod dynamic_sliding_observer;
mod dynamic_sliding_switching;
mod formulas;
mod hierarchical_neural;
mod hierarchical_uav;
mod input_distribution;
mod limited_information;
mod local_error;
mod neural_formation;
mod observer_formation;
mod saturated_compensated;
mod saturated_neural;
mod saturated_nominal;
mod sliding_avoidance;
mod sliding_feedback;
mod speed_vehicle;

pub use attitude_reference::{Differentiation, DifferentiatorSettings, HeldSlope, SlopePair};
pub use compensated_formation::{CompensatedFormation, CompensatedFormationController, CompensatedGains};
pub use consensus::Consensus;
pub use dynamic_sliding::{AccelerationSource, DynamicSlidingVariable, SlidingErrors};
pub use dynamic_sliding_chebyshev::{
    ChebyshevSignals, CompensatedInput, DynamicSlidingChebyshev, DynamicSlidingChebyshevController,
};
pub use dynamic_sliding_observer::{DynamicSlidingObserver, DynamicSlidingObserverController, DynamicSlidingSignals};
pub use dynamic_sliding_switching::{DynamicSlidingSwitching, DynamicSlidingSwitchingController};
pub use formulas::{ControllerState, Formulas};
pub use hierarchical_neural::{HierarchicalNeural, NeuralTracking, VirtualAgent};
pub use hierarchical_uav::{HierarchicalUav, HierarchicalUavController};
pub use input_distribution::consensus_share;
pub use limited_information::{LimitedInformation, LimitedInformationController, Motion};
pub use local_error::LocalError;
pub use neural_formation::{NeuralFormation, NeuralFormationController, NeuralFormationSettings};
pub use observer_formation::{
    Distribution, ObserverFormation, ObserverFormationController, ObserverFormationLimits, WholeLimit,
};
pub use saturated_compensated::{Regulation, SaturatedCompensated, SaturatedCompensatedController};
pub use saturated_neural::{SaturatedNeural, SaturatedNeuralController};
pub use saturated_nominal::{SaturatedNominal, SaturatedNominalController};
pub use sliding_avoidance::{AvoidanceSignals, SlidingAvoidance, SlidingAvoidanceController, SlidingAvoidanceGains};
pub use sliding_feedback::{Command, FormationErrors, SlidingFeedback};

use formation::wiring::Kind;

/// Every controller that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<Consensus>("consensus", "linear consensus tracking of planar robots, the example of the documentation"),
    Kind::of::<Formulas>("formulas", "the law as formulas in the scenario file, for any vehicle"),
    Kind::of::<DynamicSlidingObserver>(
        "dynamic_sliding_observer",
        "dynamic sliding mode that feeds back the estimates of a disturbance observer (2.15)",
    ),
    Kind::of::<DynamicSlidingSwitching>(
        "dynamic_sliding_switching",
        "nominal dynamic sliding mode that switches between bounds of the uncertainty (2.10)",
    ),
    Kind::of::<DynamicSlidingChebyshev>(
        "dynamic_sliding_chebyshev",
        "dynamic sliding mode with a Chebyshev network and an inverse model of the actuators (2.22), (2.23)",
    ),
    Kind::of::<SlidingAvoidance>(
        "sliding_avoidance",
        "sliding mode formation control with disturbance estimates and potential fields around obstacles (3.13)",
    ),
    Kind::of::<LimitedInformation>(
        "limited_information",
        "sliding mode formation control from estimated velocities, with repulsion between robots (4.28), (4.31)",
    ),
    Kind::of::<NeuralFormation>(
        "neural_formation",
        "formation control with a network tuned by the local error, for wheel speeds (5.6), (5.12), (5.14)",
    ),
    Kind::of::<ObserverFormation>(
        "observer_formation",
        "formation control with an observer, saturated or with input distribution, for wheel speeds (5.28)",
    ),
    Kind::of::<CompensatedFormation>(
        "compensated_formation",
        "observer feedback with a compensator of the saturation, for wheel speeds (section 5.4)",
    ),
    Kind::of::<SaturatedNeural>(
        "saturated_neural",
        "sliding mode formation control whose own network learns from the formation error (section 6.6)",
    ),
    Kind::of::<SaturatedNominal>("saturated_nominal", "sliding mode formation control, inputs clipped (6.21), (6.22)"),
    Kind::of::<SaturatedCompensated>(
        "saturated_compensated",
        "sliding mode formation control with anti-windup, inputs clipped or regulated by a linear program (6.23), (6.24)",
    ),
    Kind::of::<HierarchicalUav>(
        "hierarchical_uav",
        "position loop, guidance and attitude loop of a quadcopter that tracks its reference (7.31) to (7.43)",
    ),
    Kind::of::<HierarchicalNeural>(
        "hierarchical_neural",
        "a robot of order 1 or 2 tracks its reference; a network cancels the disturbance (7.59) to (7.65)",
    ),
];
