//! Observers: estimates of what the sensors of one agent do not tell. One file each.

mod gain_levels;
mod neural_position;
mod ofto;
mod position_feedback;
mod reference_rates;
mod sliding_neural;

pub use gain_levels::{GainLevels, Gains};
pub use neural_position::{GainChoice, NeuralPosition, NeuralPositionObserver};
pub use ofto::{Ofto, OftoObserver};
pub use position_feedback::Interval;
pub use sliding_neural::{SlidingNeural, SlidingNeuralObserver};

use formation::wiring::Kind;

/// Every observer that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<NeuralPosition>(
        "neural_position",
        "finite-time observer of velocity and disturbance from positions, with a Gaussian network (4.10), (4.13), (4.22)",
    ),
    Kind::of::<Ofto>(
        "ofto",
        "finite-time observer of velocity and disturbance from positions, without a network (4.41)",
    ),
    Kind::of::<SlidingNeural>(
        "sliding_neural",
        "sliding mode observer with a linear-in-the-state network for vehicles of order 2 (7.19) to (7.23)",
    ),
];
