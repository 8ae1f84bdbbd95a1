//! The part of this repository that is about one thesis: the metrics of its schemes, and its figures.
//!
//! The schemes themselves are in the role crates and in `schemes`. Nothing else in the repository knows this crate but the program
//! `phalanx`, which is `orchestrator` with [`catalog`].

mod metrics;

use formation::scenario::Shipped;
use formation::wiring::Roles;
use orchestrator::catalog::Catalog;

pub use metrics::{SETS, SIGNALS};

/// The figures of the thesis that show results, drawn from logs.
pub const FIGURES: &str = include_str!("figures.toml");

/// These components and scenarios, with the metrics and figures of the thesis.
///
/// The components are an argument, so that a changed control law is compiled without the metrics. A program with schemes of its own
/// starts from this catalog, or from [`Catalog::empty`]:
///
/// ```
/// # use orchestrator::judge::metrics::{Definition, Metric, MetricSet};
/// const MEANING: &[Definition] = &[Definition::new("samples", "K", "", "Number of recorded samples.")];
/// let mut catalog = thesis::catalog(schemes::ROLES, schemes::SCENARIOS);
/// catalog.metrics.push(MetricSet {
///     name: "mine",
///     compute: |run| Ok(vec![Metric::new("samples", run.samples() as f64)]),
///     definitions: MEANING,
/// });
/// assert!(catalog.metric_set("mine").is_some() && catalog.metric_set("uav").is_some());
/// ```
pub fn catalog(roles: Roles, scenarios: &[Shipped]) -> Catalog {
    Catalog {
        roles,
        scenarios: scenarios.to_vec(),
        metrics: metrics::SETS.to_vec(),
        signals: metrics::SIGNALS.to_vec(),
        figures: vec![FIGURES],
    }
}
