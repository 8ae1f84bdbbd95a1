//! Numbers that are computed from a log. What they mean is said by sets of metrics, which a [`crate::catalog::Catalog`] brings
//! along.

mod definition;
mod history;
mod run;

pub use definition::Definition;
pub use history::{
    edges, first_below_for_good, maximum, maximum_from, median, norm, norm_between, one_norm_between, square_sum,
    total_variation,
};
pub use run::{MetricError, Run};

use formation::scenario::{Scenario, Selection, Shipped};

/// A number that was computed from a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Its name in the specification and in `[expect]` of a scenario.
    pub id: String,
    /// Its value; NaN if it could not be computed (an instant that never came).
    pub value: f64,
}

impl Metric {
    /// A metric by its name.
    pub fn new(id: impl Into<String>, value: f64) -> Self {
        Self { id: id.into(), value }
    }
}

/// The metrics of a scheme.
#[derive(Clone, Copy)]
pub struct MetricSet {
    /// What scenario files call it.
    pub name: &'static str,
    /// Computes all of them, in the order of the table in which they are shown.
    pub compute: fn(&Run) -> Result<Vec<Metric>, MetricError>,
    /// What they mean.
    pub definitions: &'static [Definition],
}

impl MetricSet {
    /// Whether the scenario names this set.
    pub fn serves(&self, shipped: &Shipped) -> bool {
        let scenario = Scenario::load(shipped.file, shipped.text, &Selection::default());
        scenario.is_ok_and(|scenario| scenario.metrics == self.name)
    }

    /// The definition of the metric `id`, if the set has one.
    pub fn definition(&self, id: &str) -> Option<&'static Definition> {
        self.definitions.iter().find(|definition| definition.defines(id))
    }
}

/// A quantity for figures that no participant publishes, but that follows from what they do.
#[derive(Clone, Copy)]
pub struct DerivedSignal {
    /// What a catalogue of figures calls it.
    pub name: &'static str,
    /// Its values: outer index the agent, inner one the sample.
    pub compute: fn(&Run) -> Result<Vec<Vec<f64>>, MetricError>,
}
