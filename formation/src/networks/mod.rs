//! Neural networks that are tuned while they are used: regressors, weights, and the laws that tune them.

mod chebyshev;
mod initial_weights;
mod output_layer;
mod projected_layer;
mod rbf;
mod tanh;
mod three_layer;

pub use chebyshev::ChebyshevRegressor;
pub use initial_weights::InitialWeights;
pub use output_layer::{Leak, OutputLayer};
pub use projected_layer::ProjectedLayer;
pub use rbf::{RadialBasis, RadialNetwork};
pub use tanh::tanh_of_state;
pub use three_layer::{HiddenRate, ThreeLayer, ThreeLayerRates};
