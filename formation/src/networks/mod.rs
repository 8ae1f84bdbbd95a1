//! Neural networks that are tuned while they are used: regressors, weights, and the laws that tune them.

mod output_layer;
mod rbf;

pub use output_layer::{Leak, OutputLayer};
pub use rbf::{RadialBasis, RadialNetwork};
