//! Claims: inequalities between the metrics of a scenario's variants, written into its file.
//!
//! ```toml
//! claims = [
//!     { text = "the network makes the tracking accurate", holds = "dx(HFC-noNN) >= 100*dx(HFC)" },
//!     { text = "also with a coarser step", holds = "`b_Ẽ`(HFC) < 0.1", with = ["dt=0.02"] },
//! ]
//! ```
//!
//! # Language
//!
//! A claim is a condition of [`formation::formula`] on metrics of variants: `id(VARIANT)`, an id or a variant with special
//! characters in backticks. A comparison with a value that is not a number does not hold.

mod metric;

#[cfg(test)]
mod tests;

pub use metric::Need;

use formation::config::{Node, Origin, Problem, Problems, read};
use formation::formula::{Comparison, Condition};
use formation::scenario::Scenario;
use metric::Metrics;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;

/// The claims of a scenario.
#[derive(Clone, Copy, Debug)]
pub struct Claims;

/// A statement about the runs of a scenario's variants.
#[derive(Clone, Debug)]
pub struct Claim {
    /// The statement in words.
    pub text: String,
    /// The statement as an inequality, as it is written in the scenario.
    pub holds: String,
    /// Overrides `PATH=VALUE` for every run that the claim is about.
    pub with: Vec<String>,
    condition: Condition,
    metrics: Vec<Need>,
    origin: Origin,
    path: String,
}

/// What became of a claim.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimResult {
    /// Whether it holds, or why that cannot be said.
    pub verdict: Result<bool, Problem>,
    /// Every comparison of the claim with both its sides, in the order of the text; empty if there is no verdict.
    pub comparisons: Vec<Comparison>,
}

impl ClaimResult {
    /// Whether the claim is known to hold.
    pub fn holds(&self) -> bool {
        self.verdict == Ok(true)
    }
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Row {
    /// The claim in words.
    text: String,
    /// The claim as an inequality between metrics of variants: `x_til(TSC) < x_til(TOC)`.
    holds: String,
    /// Overrides `PATH=VALUE` for every run that the claim is about.
    #[serde(default)]
    with: Vec<String>,
}

impl Claims {
    /// What a claim looks like to an editor.
    pub fn schema(generator: &mut SchemaGenerator) -> Schema {
        generator.subschema_for::<Row>()
    }

    /// Reads the claims of `scenario`, in their order. None if it makes none.
    ///
    /// # Errors
    /// The first claim that is malformed or is about a variant that the scenario does not have, with its place.
    pub fn read(scenario: &Scenario) -> Result<Vec<Claim>, Problem> {
        let Some(node) = scenario.section("claims") else { return Ok(Vec::new()) };
        let mut problems = Problems::default();
        let rows = read::<Vec<Row>>(node, "claims", &mut problems);
        if let Some(problem) = problems.into_vec().into_iter().next() {
            return Err(problem);
        }
        let rows = rows.unwrap_or_default().into_iter().enumerate();
        rows.map(|(index, row)| Claim::new(row, node, index + 1, &scenario.variants)).collect()
    }
}

impl Claim {
    fn new(row: Row, list: &Node, number: usize, variants: &[String]) -> Result<Self, Problem> {
        let Row { text, holds, with } = row;
        let fail = |field: &str, message: String| {
            let node = list.at(&format!("{number}.{field}")).unwrap_or(list);
            Problem::new(Some(node.origin.clone()), format!("claims.{number}.{field}"), message)
        };
        if text.trim().is_empty() {
            return Err(fail("text", "expected the claim in words, found an empty text".into()));
        }
        if let Some(other) = with.iter().find(|o| o.split_once('=').is_none_or(|(path, _)| path.trim().is_empty())) {
            return Err(fail("with", format!("expected overrides such as \"dt=0.01\", found {other:?}")));
        }
        let mut metrics = Metrics { variants, needs: Vec::new() };
        let condition = Condition::parse(&holds, &mut metrics, |_| None);
        let condition = condition.map_err(|error| fail("holds", error.within(&holds)))?;
        let place = fail("holds", String::new());
        Ok(Self {
            condition,
            metrics: metrics.needs,
            origin: place.origin.unwrap_or_else(|| list.origin.clone()),
            path: place.path,
            text,
            holds,
            with,
        })
    }

    /// The variants that have to run before the claim can be evaluated, each once, in the order of the text.
    pub fn needs(&self) -> Vec<&str> {
        let mut variants: Vec<&str> = Vec::new();
        for need in &self.metrics {
            if !variants.contains(&need.variant.as_str()) {
                variants.push(&need.variant);
            }
        }
        variants
    }

    /// The metrics that the claim is about, each once, in the order of the text.
    pub fn metrics(&self) -> &[Need] {
        &self.metrics
    }

    /// Compares what came out; `value` knows a metric of a variant, or `None` if its run has no metric of that name.
    pub fn evaluate(&self, value: &impl Fn(&str, &str) -> Option<f64>) -> ClaimResult {
        let mut values = Vec::with_capacity(self.metrics.len());
        for Need { variant, metric } in &self.metrics {
            let Some(found) = value(variant, metric) else {
                let message = format!("the variant `{variant}` has no metric called `{metric}`");
                let problem = Problem::new(Some(self.origin.clone()), &self.path, message);
                return ClaimResult { verdict: Err(problem), comparisons: Vec::new() };
            };
            values.push(found);
        }
        ClaimResult { verdict: Ok(self.condition.holds(&values)), comparisons: self.condition.comparisons(&values) }
    }
}
