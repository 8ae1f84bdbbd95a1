//! Neural networks that are tuned while they are used: regressors, weights, and the laws that tune them.

mod output_layer;

pub use output_layer::{Leak, OutputLayer};
