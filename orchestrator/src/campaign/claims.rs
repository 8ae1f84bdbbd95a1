//! The claims of a scenario, evaluated on the runs of a campaign.

use super::{Job, JobResult, Selected};

/// A claim and whether it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimRow {
    /// The scenario.
    pub scenario: String,
    /// The claim in words.
    pub text: String,
    /// The claim as inequality.
    pub condition: String,
    /// Overrides under which it is made.
    pub with: Vec<String>,
    /// Both sides of every comparison, with the relation between them; the right side is missing in `is not finite`.
    pub sides: Vec<(f64, &'static str, Option<f64>)>,
    /// Whether it holds.
    pub holds: bool,
    /// Why that cannot be said, if it cannot.
    pub problem: Option<String>,
}

impl ClaimRow {
    /// All claims of one scenario.
    pub(super) fn all(selected: &Selected, results: &[(Job, JobResult)]) -> Vec<Self> {
        let scenario = &selected.scenario.name;
        let rows = selected.claims.iter().map(|claim| {
            let value = |variant: &str, metric: &str| {
                let (_, result) = results.iter().find(|(job, _)| {
                    job.shipped.name == scenario && job.variant == variant && job.with == claim.with
                })?;
                let Some(verdict) = &result.verdict else { return Some(f64::NAN) };
                let row = verdict.rows.iter().find(|row| row.id == metric);
                row.map(|row| row.value)
            };
            let result = claim.evaluate(&value);
            let sides = result.comparisons.iter().map(|comparison| {
                (comparison.left.value, comparison.relation, comparison.right.as_ref().map(|right| right.value))
            });
            Self {
                scenario: scenario.clone(),
                text: claim.text.clone(),
                condition: claim.holds.clone(),
                with: claim.with.clone(),
                sides: sides.collect(),
                holds: result.holds(),
                problem: result.verdict.err().map(|problem| problem.to_string()),
            }
        });
        rows.collect()
    }
}
