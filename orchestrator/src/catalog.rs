//! What a program brings along: components, scenarios, metrics and figures. The framework knows none by name.

use formation::scenario::Shipped;
use formation::wiring::Roles;

use crate::judge::metrics::{DerivedSignal, MetricSet};

/// Everything that a program knows about schemes.
#[derive(Clone)]
pub struct Catalog {
    /// The components that scenarios can name, by role.
    pub roles: Roles,
    /// The scenarios that come with the program.
    pub scenarios: Vec<Shipped>,
    /// The sets of metrics that scenarios can name.
    pub metrics: Vec<MetricSet>,
    /// Quantities for figures that no participant publishes.
    pub signals: Vec<DerivedSignal>,
    /// Catalogues of published figures, as TOML.
    pub figures: Vec<&'static str>,
}

impl Catalog {
    /// Nothing at all.
    ///
    /// ```
    /// assert!(orchestrator::catalog::Catalog::empty().scenario("uav").is_none());
    /// ```
    pub fn empty() -> Self {
        let (roles, figures) = (Roles::NONE, Vec::new());
        Self { roles, scenarios: Vec::new(), metrics: Vec::new(), signals: Vec::new(), figures }
    }

    /// A scenario that comes with the program.
    pub fn scenario(&self, name: &str) -> Option<&Shipped> {
        self.scenarios.iter().find(|shipped| shipped.name == name)
    }

    /// A set of metrics.
    pub fn metric_set(&self, name: &str) -> Option<&MetricSet> {
        self.metrics.iter().find(|set| set.name == name)
    }

    /// A quantity that no participant publishes.
    pub fn signal(&self, name: &str) -> Option<&DerivedSignal> {
        self.signals.iter().find(|signal| signal.name == name)
    }
}
