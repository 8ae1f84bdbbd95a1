//! Metrics that a scenario defines by formulas, and the default set.
//!
//! ```toml
//! [metrics]
//! worst = "max(norm(state.position[0:2] - reference.position[0:2]), from = 20)"
//! energy = { value = "integral(norm(command.input)^2, across = sum)", unit = "N^2 s", description = "Control effort." }
//! ```
//!
//! The value of a metric is a formula of reducers. A reducer makes one number of a signal over time, for each agent, and then one of
//! the agents' numbers. Signals are those of [assertions](super::assertions).

mod default;
mod evaluate;
mod formula;
mod read;
mod reducer;

#[cfg(test)]
mod tests;

pub use evaluate::{of_log, stream};
pub use read::read;
pub(crate) use read::schema;

use formation::formula::Formula;

use super::metrics::Definition;
use reducer::Reduction;

/// A metric that is computed from a log, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct OwnMetric {
    /// Its name.
    pub id: String,
    /// What it means.
    pub definition: Definition,
    /// Its value, over the results of the reductions.
    value: Formula,
    reductions: Vec<Reduction>,
}
