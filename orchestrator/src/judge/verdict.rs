//! What a log says, held against what it should say.

use std::fmt::Write;
use std::path::Path;

use formation::scenario::{Expectation, Scenario};
use serde_json::{Map, Value, json};

use crate::judge::JudgeError;
use crate::judge::metrics::{Metric, MetricError, MetricSet, Run};
use crate::terminal::table::{Left, Right, Table};
use recording::Log;

/// A metric with its band.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the metric.
    pub id: String,
    /// Its value; NaN if it has none.
    pub value: f64,
    /// What the thesis says and what was expected.
    pub expectation: Expectation,
    /// Whether it lies in its band; `None` if there is no band.
    pub ok: Option<bool>,
}

impl Row {
    /// The band in words, `1 ... 2` or `<= 2`; empty if there is none.
    pub fn band(&self) -> String {
        match (self.expectation.low, self.expectation.high) {
            (Some(low), Some(high)) => format!("{} ... {}", short(low), short(high)),
            (Some(low), None) => format!(">= {}", short(low)),
            (None, Some(high)) => format!("<= {}", short(high)),
            (None, None) => String::new(),
        }
    }

    /// The verdict in a word; empty if there is no band.
    pub fn word(&self) -> &'static str {
        match self.ok {
            Some(true) => "ok",
            Some(false) => "MISSED",
            None => "",
        }
    }
}

/// All metrics of a run with their bands.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// In the order of the metric set; bands of metrics that were not computed at the end.
    pub rows: Vec<Row>,
    /// Why the bands are shown but not held against this run; `None` if they are. They belong to the scenario as it is in its
    /// file: a run that was overridden, swapped or cut short is another one.
    pub not_held: Option<String>,
}

impl Verdict {
    /// Computes the metrics of `scenario` from `log` and compares them with its bands.
    ///
    /// # Errors
    /// [`MetricError`] if the log does not hold what the metrics need, or the scenario names an unknown set.
    pub fn of(sets: &[MetricSet], scenario: &Scenario, log: &Log) -> Result<Self, MetricError> {
        Ok(Self::compare(scenario, compute(sets, &Run::new(scenario, log))?))
    }

    /// The same from the log `path`, of which only those signals are kept in memory that the metrics read. Returns the log with
    /// them, too; no verdict on a log that holds no complete step.
    ///
    /// # Errors
    /// As those of [`Verdict::of`], and [`JudgeError::Log`] if the log cannot be read.
    pub fn read(sets: &[MetricSet], scenario: &Scenario, path: &Path) -> Result<(Option<Self>, Log), JudgeError> {
        // What is read does not depend on how many steps there are.
        let first = Log::first_step(path)?;
        let run = Run::new(scenario, &first);
        let known = if first.steps().is_empty() { Ok(Vec::new()) } else { compute(sets, &run) };
        let asked = run.asked();
        let is_asked = |topic: &str, field: &str| asked.contains(&(topic.into(), field.into()));
        let log = Log::open_for(path, &is_asked)?;
        known?;
        if log.steps().is_empty() {
            return Ok((None, log));
        }
        let run = Run::new(scenario, &log);
        let metrics = compute(sets, &run);
        let lacks = |(topic, field): &(String, String)| !is_asked(topic, field) && log.has(topic, field);
        let metrics = match run.asked().iter().any(lacks) {
            true => compute(sets, &Run::new(scenario, &Log::open(path)?))?,
            false => metrics?,
        };
        Ok((Some(Self::compare(scenario, metrics)), log))
    }

    fn compare(scenario: &Scenario, metrics: Vec<Metric>) -> Self {
        let mut rows: Vec<Row> = metrics
            .into_iter()
            .map(|metric| {
                let expectation = scenario.expectations.get(&metric.id).cloned().unwrap_or_default();
                Row { ok: expectation.holds(metric.value), id: metric.id, value: metric.value, expectation }
            })
            .collect();
        for (id, expectation) in &scenario.expectations {
            // Bands of agents that do not fly are no failure of those that do.
            let known = rows.iter().any(|row| row.id == *id);
            if !known && scenario.overrides.is_empty() {
                rows.push(Row { id: id.clone(), value: f64::NAN, expectation: expectation.clone(), ok: Some(false) });
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

    /// Whether no metric is outside a band that is held against the run.
    pub fn ok(&self) -> bool {
        self.not_held.is_some() || self.missed() == 0
    }

    /// Number of metrics outside their bands.
    pub fn missed(&self) -> usize {
        self.rows.iter().filter(|row| row.ok == Some(false)).count()
    }

    /// The table `metric | thesis | measured | band | ok` for a terminal of so many columns, or as wide as it is; without its
    /// second column if no published value is known.
    pub fn table(&self, columns: Option<usize>) -> String {
        let held = self.not_held.is_none();
        let is_published = self.rows.iter().any(|row| !row.expectation.thesis.is_empty());
        let mut head = vec![("metric", Left), ("thesis", Right), ("measured", Right), ("band", Right), ("ok", Right)];
        head.retain(|(heading, _)| is_published || *heading != "thesis");
        let mut table = Table::new(head).ruled();
        for row in &self.rows {
            let [metric, thesis, measured, band, ok] = cells(row, held);
            match is_published {
                true => table.row([metric, thesis, measured, band, ok]),
                false => table.row([metric, measured, band, ok]),
            }
        }
        table.text(columns)
    }

    /// The metrics as JSON: `{id: {value, thesis, lo, hi, ok}}`.
    pub fn to_json(&self) -> Value {
        let mut metrics = Map::new();
        for row in &self.rows {
            let thesis = Some(&row.expectation.thesis).filter(|text| !text.is_empty());
            let entry = json!({
                "value": number(row.value),
                "thesis": thesis,
                "lo": row.expectation.low.map(number),
                "hi": row.expectation.high.map(number),
                "ok": row.ok,
            });
            metrics.insert(row.id.clone(), entry);
        }
        Value::Object(metrics)
    }
}

/// The metrics of the set that the scenario names; none if it names none.
fn compute(sets: &[MetricSet], run: &Run) -> Result<Vec<Metric>, MetricError> {
    let name = &run.scenario.metrics;
    if name.is_empty() {
        return Ok(Vec::new());
    }
    let set = sets.iter().find(|set| set.name == *name).ok_or_else(|| MetricError::NotApplicable {
        set: name.clone(),
        reason: "there is no such set of metrics".into(),
    })?;
    (set.compute)(run)
}

/// JSON has no NaN and no infinity.
fn number(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
}

fn cells(row: &Row, held: bool) -> [String; 5] {
    let word = match row.ok {
        Some(_) if !held => "not held",
        _ => row.word(),
    };
    [row.id.clone(), row.expectation.thesis.clone(), short(row.value), row.band(), word.into()]
}

/// Four significant digits, in the notation that is shorter to read.
pub fn short(value: f64) -> String {
    let mut text = String::new();
    let size = value.abs();
    let result = if value == 0.0 {
        write!(text, "0")
    } else if !value.is_finite() {
        write!(
            text,
            "{}",
            if value.is_nan() {
                "-"
            } else if value > 0.0 {
                "inf"
            } else {
                "-inf"
            }
        )
    } else if !(1e-3..1e5).contains(&size) {
        write!(text, "{value:.3e}")
    } else {
        let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        write!(text, "{value:.decimals$}")
    };
    debug_assert!(result.is_ok());
    if text.contains('.') && !text.contains('e') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 2.345678e-4, 0.00187654, 56.26, 1229.4, 123456.0, f64::NAN, -0.422, 8.0].map(short);
        assert_eq!(shown, ["0", "2.346e-4", "0.001877", "56.26", "1229", "1.235e5", "-", "-0.422", "8"]);
    }

    #[test]
    fn a_missing_value_misses_its_band() {
        let expectation = Expectation { thesis: "<= 2".into(), low: None, high: Some(2.0) };
        let row =
            |value: f64| Row { id: "x".into(), value, ok: expectation.holds(value), expectation: expectation.clone() };
        let verdict = Verdict { rows: vec![row(1.0), row(f64::NAN)], not_held: None };
        assert!(!verdict.ok());
        assert_eq!(verdict.missed(), 1);
        let table = verdict.table(None);
        assert!(table.contains("MISSED") && table.contains("thesis") && table.lines().count() == 4, "{table}");
        assert_eq!(verdict.to_json()["x"]["value"], Value::Null);
    }

    #[test]
    fn bands_of_another_run_are_not_held_against_this_one() {
        let expectation = Expectation { thesis: String::new(), low: None, high: Some(2.0) };
        let row = Row { id: "x".into(), value: 3.0, ok: expectation.holds(3.0), expectation };
        let verdict = Verdict { rows: vec![row], not_held: None };
        assert!(!verdict.ok());
        let other =
            verdict.not_held_since(Some("overridden: phase=1".into())).not_held_since(Some("interrupted".into()));
        assert_eq!(other.not_held.as_deref(), Some("overridden: phase=1; interrupted"));
        assert!(other.ok() && other.missed() == 1 && other.table(None).contains("not held"), "{}", other.table(None));
        assert!(!other.table(None).contains("thesis"), "no published value is known: {}", other.table(None));
        assert!(!other.strict().ok());
    }
}
