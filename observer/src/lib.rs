//! Observers: estimates of what the sensors of one agent do not tell. One file each.

mod dual_disturbance;
mod sliding_neural;

pub use dual_disturbance::{DualDisturbance, DualDisturbanceObserver};
pub use sliding_neural::{SlidingNeural, SlidingNeuralObserver};

use formation::wiring::Kind;

/// Every observer that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<DualDisturbance>(
        "dual_disturbance",
        "finite-time observers of the mismatched and the matched disturbance of a vehicle of order 2 (3.7)",
    ),
    Kind::of::<SlidingNeural>(
        "sliding_neural",
        "sliding mode observer with a linear-in-the-state network for vehicles of order 2 (7.19) to (7.23)",
    ),
];
