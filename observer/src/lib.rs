//! Observers: estimates of what the sensors of one agent do not tell. One file each.

mod adaptive;
mod applied_input;
mod dual_disturbance;
mod finite_time_disturbance;
mod gain_levels;
mod neural_linear_surface;
mod neural_position;
mod neural_surface;
mod neural_terminal_surface;
mod ofto;
mod position_feedback;
mod reference_rates;
mod sliding_neural;
mod three_layer_neural;

pub use adaptive::{Adaptive, AdaptiveGains, AdaptiveObserver};
pub use dual_disturbance::{DualDisturbance, DualDisturbanceObserver};
pub use finite_time_disturbance::FiniteTimeDisturbance;
pub use gain_levels::{GainLevels, Gains};
pub use neural_linear_surface::{LinearSurface, NeuralLinearSurface};
pub use neural_position::{GainChoice, NeuralPosition, NeuralPositionObserver};
pub use neural_surface::{NeuralSurfaceObserver, Published, Surface, Tuning};
pub use neural_terminal_surface::{NeuralTerminalSurface, TerminalSurface};
pub use ofto::{Ofto, OftoObserver};
pub use position_feedback::Interval;
pub use sliding_neural::{SlidingNeural, SlidingNeuralObserver};
pub use three_layer_neural::{ThreeLayerNeural, ThreeLayerObserver};

use formation::wiring::Kind;

/// Every observer that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<FiniteTimeDisturbance>(
        "finite_time_disturbance",
        "finite-time observer of the uncertainty of a vehicle of order 2 and of its rate (2.11)",
    ),
    Kind::of::<DualDisturbance>(
        "dual_disturbance",
        "finite-time observers of the mismatched and the matched disturbance of a vehicle of order 2 (3.7)",
    ),
    Kind::of::<Ofto>(
        "ofto",
        "finite-time observer of velocity and disturbance from positions, without a network (4.41)",
    ),
    Kind::of::<NeuralPosition>(
        "neural_position",
        "finite-time observer of velocity and disturbance from positions, with a Gaussian network (4.10), (4.13), (4.22)",
    ),
    Kind::of::<ThreeLayerNeural>(
        "three_layer_neural",
        "observer with a three-layer network for vehicles of order 1 (5.6), (5.20), (5.21)",
    ),
    Kind::of::<Adaptive>("adaptive", "linear adaptive observer for vehicles of order 1 or 2 (5.39) to (5.41)"),
    Kind::of::<NeuralLinearSurface>(
        "neural_linear_surface",
        "neural observer with a linear sliding surface for vehicles of order 2 (6.9) to (6.13)",
    ),
    Kind::of::<NeuralTerminalSurface>(
        "neural_terminal_surface",
        "neural observer with a terminal sliding surface for vehicles of order 2 (6.9), (6.13), (6.16), (6.17)",
    ),
    Kind::of::<SlidingNeural>(
        "sliding_neural",
        "sliding mode observer with a linear-in-the-state network for vehicles of order 2 (7.19) to (7.23)",
    ),
];
