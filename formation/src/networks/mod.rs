//! Neural networks that are tuned while they are used: regressors, weights, and the laws that tune them.

mod chebyshev;
mod output_layer;
mod projected_layer;

pub use chebyshev::ChebyshevRegressor;
pub use output_layer::{Leak, OutputLayer};
pub use projected_layer::ProjectedLayer;
