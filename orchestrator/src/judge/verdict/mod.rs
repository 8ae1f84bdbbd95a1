//! What a log says, held against what it should say.

mod row;
mod words;

use std::path::Path;

use formation::scenario::Scenario;
use recording::Log;
use serde_json::{Map, Value};

pub(crate) use row::factor;
pub use row::{Row, short};
pub(crate) use words::Counts;

use crate::judge::JudgeError;
use crate::judge::metrics::{Definition, Metric, MetricError, MetricSet, Run};

/// All metrics of a run, each against its regression range and against the thesis.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// In the order of the metric set; expectations of metrics that were not computed at the end.
    pub rows: Vec<Row>,
    /// Why ranges and statements are shown but not held against this run; `None` if they are. They belong to the scenario as it is
    /// in its file: a run that was overridden, swapped or cut short is another one.
    pub not_held: Option<String>,
}

impl Verdict {
    /// Computes the metrics of `scenario` from `log` and compares them, and those of its own, with what is expected.
    ///
    /// # Errors
    /// [`MetricError`] if the log does not hold what the metrics need, or the scenario names an unknown set.
    pub fn of(
        sets: &[MetricSet],
        scenario: &Scenario,
        log: &Log,
        own: Vec<(Metric, Definition)>,
    ) -> Result<Self, MetricError> {
        let Some(set) = chosen(sets, scenario)? else { return Ok(Self::compare(scenario, None, Vec::new(), own)) };
        Ok(Self::compare(scenario, Some(set), (set.compute)(&Run::new(scenario, log))?, own))
    }

    /// The same from the log `path`, of which only those signals are kept in memory that the metrics read. Returns the log with
    /// them, too; no verdict on a log that holds no complete step.
    ///
    /// # Errors
    /// As those of [`Verdict::of`], and [`JudgeError::Log`] if the log cannot be read.
    pub fn read(
        sets: &[MetricSet],
        scenario: &Scenario,
        path: &Path,
        own: Vec<(Metric, Definition)>,
    ) -> Result<(Option<Self>, Log), JudgeError> {
        let set = chosen(sets, scenario)?;
        let compute = |run: &Run| set.map_or(Ok(Vec::new()), |set| (set.compute)(run));
        // What is read does not depend on how many steps there are.
        let first = Log::first_step(path)?;
        let run = Run::new(scenario, &first);
        let known = if first.steps().is_empty() { Ok(Vec::new()) } else { compute(&run) };
        let asked = run.asked();
        let is_asked = |topic: &str, field: &str| asked.contains(&(topic.into(), field.into()));
        let log = Log::open_for(path, &is_asked)?;
        known?;
        if log.steps().is_empty() {
            return Ok((None, log));
        }
        let run = Run::new(scenario, &log);
        let metrics = compute(&run);
        let lacks = |(topic, field): &(String, String)| !is_asked(topic, field) && log.has(topic, field);
        let metrics = match run.asked().iter().any(lacks) {
            true => compute(&Run::new(scenario, &Log::open(path)?))?,
            false => metrics?,
        };
        Ok((Some(Self::compare(scenario, set, metrics, own)), log))
    }

    fn compare(
        scenario: &Scenario,
        set: Option<&MetricSet>,
        metrics: Vec<Metric>,
        own: Vec<(Metric, Definition)>,
    ) -> Self {
        let of_set = |id: &str| set.and_then(|set| set.definition(id)).cloned();
        let row = |id: String, value: f64, definition: Option<Definition>| Row {
            definition,
            expectation: scenario.expectations.get(&id).cloned().unwrap_or_default(),
            id,
            value,
        };
        let described = metrics.into_iter().map(|metric| {
            let definition = of_set(&metric.id);
            row(metric.id, metric.value, definition)
        });
        let own = own.into_iter().map(|(metric, definition)| row(metric.id, metric.value, Some(definition)));
        let mut rows: Vec<Row> = described.chain(own).collect();
        for id in scenario.expectations.keys() {
            // Expectations of agents that do not fly are no failure of those that do.
            let known = rows.iter().any(|row| row.id == *id);
            if !known && scenario.overrides.is_empty() {
                rows.push(row(id.clone(), f64::NAN, of_set(id)));
            }
        }
        let not_held =
            (!scenario.overrides.is_empty()).then(|| format!("overridden: {}", scenario.overrides.join(", ")));
        Self { rows, not_held }
    }

    /// The same, not held against the run for this reason, besides those that there are already.
    pub fn not_held_since(mut self, reason: Option<String>) -> Self {
        self.not_held = match (self.not_held, reason) {
            (Some(first), Some(second)) => Some(format!("{first}; {second}")),
            (first, second) => first.or(second),
        };
        self
    }

    /// The same, held against the run whatever was changed about it.
    pub fn strict(mut self) -> Self {
        self.not_held = None;
        self
    }

    /// Whether no metric is outside a regression range that is held against the run. What the thesis states does not count: a
    /// statement that the reference implementation does not meet either is no failure of the run.
    pub fn ok(&self) -> bool {
        self.not_held.is_some() || self.missed() == 0
    }

    /// Number of metrics outside their regression ranges.
    pub fn missed(&self) -> usize {
        self.counts().outside
    }

    /// The metrics as JSON: `{id: {value, unit, lo, hi, in_range, thesis, against_thesis, ratio, reason, ...}}`.
    pub fn to_json(&self) -> Value {
        let metrics: Map<String, Value> = self.rows.iter().map(|row| (row.id.clone(), row.to_json())).collect();
        Value::Object(metrics)
    }
}

/// The set of metrics that the scenario names; `None` if it names none.
fn chosen<'a>(sets: &'a [MetricSet], scenario: &Scenario) -> Result<Option<&'a MetricSet>, MetricError> {
    let name = &scenario.metrics;
    let set = sets.iter().find(|set| set.name == *name);
    match set {
        None if !name.is_empty() => {
            Err(MetricError::NotApplicable { set: name.clone(), reason: "there is no such set of metrics".into() })
        }
        set => Ok(set),
    }
}
