//! The part of this repository that is about one thesis: the metrics of its schemes, and its figures.
//!
//! The schemes themselves are in the role crates and in `schemes`. Nothing else in the repository knows this crate but the program
//! `phalanx`, which is `orchestrator` with [`catalog`].

mod metrics;

use orchestrator::catalog::Catalog;

pub use metrics::{SETS, SIGNALS};

/// The figures of the thesis that show results, drawn from logs.
pub const FIGURES: &str = include_str!("figures.toml");

/// All that the thesis brings along: its components, scenarios, metrics and figures.
///
/// A program with schemes of its own starts from it, or from [`Catalog::empty`]:
///
/// ```
/// # use orchestrator::judge::metrics::{Metric, MetricSet};
/// let mut catalog = thesis::catalog();
/// catalog.metrics.push(MetricSet { name: "mine", compute: |run| Ok(vec![Metric::new("samples", run.samples() as f64)]) });
/// assert!(catalog.metric_set("mine").is_some() && catalog.metric_set("uav").is_some());
/// ```
pub fn catalog() -> Catalog {
    Catalog {
        roles: schemes::ROLES,
        scenarios: schemes::SCENARIOS.to_vec(),
        metrics: metrics::SETS.to_vec(),
        signals: metrics::SIGNALS.to_vec(),
        figures: vec![FIGURES],
    }
}
