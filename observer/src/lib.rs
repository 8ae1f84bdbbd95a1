//! Observers: estimates of what the sensors of one agent do not tell. One file each.

mod finite_time_disturbance;
mod sliding_neural;

pub use finite_time_disturbance::FiniteTimeDisturbance;
pub use sliding_neural::{SlidingNeural, SlidingNeuralObserver};

use formation::wiring::Kind;

/// Every observer that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<FiniteTimeDisturbance>(
        "finite_time_disturbance",
        "finite-time observer of the uncertainty of a vehicle of order 2 and of its rate (2.11)",
    ),
    Kind::of::<SlidingNeural>(
        "sliding_neural",
        "sliding mode observer with a linear-in-the-state network for vehicles of order 2 (7.19) to (7.23)",
    ),
];
