//! What is computed from a log: one file per scheme, a set of metrics each.

mod cida;
mod compensated;
mod compensated_experiment;
mod dsm;
mod history;
mod limited_information;
mod lp_regulation;
mod mixed;
mod rca;
mod run;
mod speed_formation;
mod uav;

pub use history::{
    edges, first_below_for_good, maximum, maximum_from, median, norm, norm_between, one_norm_between, square_sum,
    total_variation,
};
pub use run::{MetricError, Run};

use serde::Deserialize;

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

/// A quantity that no participant publishes, but that follows from what they do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Derived {
    /// ‖E - Ê‖ of robots that are commanded by speeds: their whole uncertainty, that of the wheels' effect included.
    UncertaintyError,
    /// ‖E - Ê‖ of a network that learns `dw/dt + (k + λ) w`.
    NetworkError,
    /// ‖s‖ made of the true velocities, which the controller does not know.
    Sliding,
}

impl Derived {
    /// Its values: outer index the agent, inner one the sample.
    pub(crate) fn of(self, run: &Run) -> Result<Vec<Vec<f64>>, MetricError> {
        match self {
            Derived::UncertaintyError => speed_formation::uncertainty_error(run),
            Derived::NetworkError => dsm::network_error(run),
            Derived::Sliding => limited_information::sliding(run),
        }
    }
}

/// The metrics of a scheme.
#[derive(Clone, Copy)]
pub struct MetricSet {
    /// What scenario files call it.
    pub name: &'static str,
    /// Computes all of them, in the order of the table in which they are shown.
    pub compute: fn(&Run) -> Result<Vec<Metric>, MetricError>,
}

/// All sets of metrics.
pub const SETS: &[MetricSet] = &[
    MetricSet { name: "dsm", compute: dsm::compute },
    MetricSet { name: "rca", compute: rca::compute },
    MetricSet { name: "limited-information", compute: limited_information::compute },
    MetricSet { name: "cida", compute: cida::compute },
    MetricSet { name: "compensated", compute: compensated::compute },
    MetricSet { name: "compensated-experiment", compute: compensated_experiment::compute },
    MetricSet { name: "lp_regulation", compute: lp_regulation::compute },
    MetricSet { name: "uav", compute: uav::compute },
    MetricSet { name: "mixed", compute: mixed::compute },
];
