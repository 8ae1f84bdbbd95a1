//! From `[[assert]]` to assertions that can be evaluated.

use formation::config::{Node, Problem, Problems, brief, did_you_mean, read as read_node};
use formation::formula::{Expression, FormulaError, Operand};
use formation::wiring::Assembly;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;

use super::bound::Bound;
use super::geometry::{Geometry, METRICS};
use super::signal::{condition, constant, number};
use super::slot::Slot;
use super::{Across, Assertion, Severity, Signal, Subject};

/// More than these are taken for a mistake; they are compiled for every agent.
const MOST_ASSERTIONS: usize = 64;

/// A bound of a signal that is checked while a run goes on.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Assertion")]
struct Row {
    /// What it says, in words.
    name: String,
    /// A formula of the fields of an agent.
    signal: Option<String>,
    /// A named quantity of the formation instead of a signal.
    metric: Option<String>,
    /// The least value that is allowed.
    min: Option<Bound>,
    /// The greatest value that is allowed.
    max: Option<Bound>,
    /// From this time on, s.
    from: Option<f64>,
    /// Up to this time, s.
    to: Option<f64>,
    /// Only these agents.
    agents: Option<Vec<u32>>,
    /// Only in these variants.
    variants: Option<Vec<String>>,
    /// How the agents are taken together.
    #[serde(default)]
    across: Across,
    /// What a violation does to the run.
    #[serde(default)]
    severity: Severity,
    /// Whether a violation ends the run.
    #[serde(default)]
    stop: bool,
}

/// What an assertion looks like to an editor. (JSON Schema)
pub(crate) fn schema(generator: &mut SchemaGenerator) -> Schema {
    generator.subschema_for::<Row>()
}

/// The assertions of a scenario that apply to its variant, in the order of the file.
///
/// # Errors
/// Everything that is wrong with them, each with its place.
pub fn read(assembly: &Assembly) -> Result<Vec<Assertion>, Vec<Problem>> {
    let Some(section) = assembly.scenario.section("assert") else { return Ok(Vec::new()) };
    let mut problems = Problems::default();
    let mut assertions: Vec<Assertion> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    let Some(nodes) = section.as_array() else {
        return Err(vec![assembly.scenario.problem("assert", "expected a list of tables: write [[assert]]")]);
    };
    if nodes.len() > MOST_ASSERTIONS {
        let message = format!("expected at most {MOST_ASSERTIONS} assertions, found {}", nodes.len());
        return Err(vec![assembly.scenario.problem("assert", message)]);
    }
    let geometry = Geometry::new(assembly);
    for (index, node) in nodes.iter().enumerate() {
        let path = format!("assert.{}", index + 1);
        let Some(row) = read_node::<Row>(node, &path, &mut problems) else { continue };
        let reader = RowReader { node, path, row: &row, assembly, geometry: &geometry };
        if names.contains(&row.name) {
            problems.push(reader.problem("name", "another assertion has this name; each needs its own"));
        }
        names.push(row.name.clone());
        match reader.assertion() {
            Ok(assertion) => assertions.extend(assertion),
            Err(found) => problems.extend(found),
        }
    }
    if problems.is_empty() { Ok(assertions) } else { Err(problems.into_vec()) }
}

struct RowReader<'a> {
    node: &'a Node,
    path: String,
    row: &'a Row,
    assembly: &'a Assembly,
    geometry: &'a Geometry,
}

impl RowReader<'_> {
    /// The assertion; `None` if it is not about this variant.
    fn assertion(&self) -> Result<Option<Assertion>, Vec<Problem>> {
        let mut problems = Vec::new();
        let row = self.row;
        if row.name.trim().is_empty() || row.name.contains(['\n', '\r']) {
            problems.push(self.problem("name", "expected what the assertion says, in one line"));
        }
        let signal = self.signal().map_err(|problem| problems.push(problem)).unwrap_or_default();
        if self.is_condition() {
            problems.extend(self.condition_mistake(&signal));
        }
        let steps = self.steps().map_err(|problem| problems.push(problem)).unwrap_or_default();
        let agents = self.agents().map_err(|problem| problems.push(problem)).unwrap_or_default();
        problems.extend(self.unknown_variants());
        if !problems.is_empty() {
            return Err(problems);
        }
        let subject = |&agent: &usize| self.subject(&signal, agent);
        let subjects = agents.iter().map(subject).collect::<Result<Vec<_>, _>>().map_err(|problem| vec![problem])?;
        // An only agent has no distance to others; the assertion is about formations.
        let is_alone = |slot: &Slot| matches!(slot, Slot::Nearest(nearest) if nearest.is_alone());
        if subjects.iter().flat_map(|subject: &Subject| &subject.slots).any(is_alone) {
            return Ok(None);
        }
        let scenario = &self.assembly.scenario;
        if row.variants.as_ref().is_some_and(|variants| !variants.contains(&scenario.variant)) {
            return Ok(None);
        }
        let Row { across, severity, stop, .. } = *row;
        Ok(Some(Assertion { name: row.name.clone(), signal, severity, stop, steps, across, subjects }))
    }

    fn signal(&self) -> Result<String, Problem> {
        match (&self.row.signal, &self.row.metric) {
            (Some(signal), None) => Ok(signal.clone()),
            (None, Some(metric)) if METRICS.iter().any(|(name, _)| name == metric) => Ok(metric.clone()),
            (None, Some(metric)) => {
                let names = METRICS.map(|(name, _)| name);
                let (expected, hint) = (names.join(", "), did_you_mean(metric, names));
                Err(self.problem("metric", format!("no metric is called `{metric}`, expected one of {expected}{hint}")))
            }
            (Some(_), Some(_)) => Err(self.problem("metric", "expected either `signal` or `metric`, found both")),
            (None, None) => {
                Err(self.problem("", "expected a `signal` such as \"norm(state.velocity)\", or a `metric`"))
            }
        }
    }

    /// Whether the signal says itself what is right, without bounds.
    fn is_condition(&self) -> bool {
        self.row.min.is_none() && self.row.max.is_none()
    }

    /// What a signal without bounds must not be or have.
    fn condition_mistake(&self, signal: &str) -> Option<Problem> {
        if self.row.across != Across::Each {
            return Some(
                self.problem("across", "expected bounds, `min`, `max` or both: only numbers are taken together"),
            );
        }
        let is_number = self.row.metric.is_some() || number(signal, self.assembly, self.geometry, 0).is_ok();
        let message = "expected a bound, `min`, `max` or both, or a comparison such as \"gap > 0.1\" as the signal";
        is_number.then(|| self.problem("", message))
    }

    /// First and last step of the window; none of the run if the window lies behind its end.
    fn steps(&self) -> Result<(u64, u64), Problem> {
        let timing = self.assembly.scenario.context.timing;
        let (from, to) = (self.row.from.unwrap_or(0.0), self.row.to.unwrap_or(timing.duration));
        if !(from.is_finite() && from >= 0.0) {
            return Err(self.problem("from", format!("expected a time >= 0 s, found {from}")));
        }
        if self.row.to.is_some() && !(to.is_finite() && to >= from) {
            return Err(self.problem("to", format!("expected a time >= {from} s, where the window starts, found {to}")));
        }
        // A time that is a multiple of the step but for its last digits means that step. Casts saturate.
        let first = (from / timing.dt - 1e-6).ceil().max(0.0) as u64;
        let last = (to / timing.dt + 1e-6).floor() as u64;
        Ok((first, last))
    }

    /// Places of the agents.
    fn agents(&self) -> Result<Vec<usize>, Problem> {
        let count = self.assembly.scenario.context.agents.len();
        let Some(numbers) = &self.row.agents else { return Ok((0..count).collect()) };
        let expected = || self.problem("agents", format!("expected numbers of agents from 1 to {count}, each once"));
        let mut places = Vec::new();
        for &number in numbers {
            let place = (number as usize).checked_sub(1).filter(|place| *place < count).ok_or_else(expected)?;
            if places.contains(&place) {
                return Err(expected());
            }
            places.push(place);
        }
        if places.is_empty() { Err(expected()) } else { Ok(places) }
    }

    fn unknown_variants(&self) -> Option<Problem> {
        let known = &self.assembly.scenario.variants;
        // A log holds only the variant that ran, so its other names cannot be checked there.
        if known.len() <= 1 {
            return None;
        }
        let unknown = self.row.variants.iter().flatten().find(|name| !known.contains(name))?;
        let hint = did_you_mean(unknown, known.iter().map(String::as_str));
        let expected = known.join(", ");
        Some(self.problem("variants", format!("no variant is called `{unknown}`, expected one of {expected}{hint}")))
    }

    fn subject(&self, signal: &str, agent: usize) -> Result<Subject, Problem> {
        let field = if self.row.signal.is_some() { "signal" } else { "metric" };
        let mistake = |error: FormulaError| self.problem(field, error.within(signal));
        let (signal, slots) = if self.is_condition() {
            let (condition, slots) = condition(signal, self.assembly, self.geometry, agent).map_err(mistake)?;
            (Signal::Condition(condition), slots)
        } else {
            let (formula, slots) = number(signal, self.assembly, self.geometry, agent).map_err(mistake)?;
            (Signal::Number(formula), slots)
        };
        let least = if self.is_condition() { 0.0 } else { f64::NEG_INFINITY };
        let min = self.bound("min", self.row.min.as_ref(), agent)?.unwrap_or(least);
        let max = self.bound("max", self.row.max.as_ref(), agent)?.unwrap_or(f64::INFINITY);
        if min > max {
            return Err(self.problem("max", format!("expected a bound >= {min}, which is `min`, found {max}")));
        }
        Ok(Subject { agent: agent as u32 + 1, signal, slots, min, max })
    }

    fn bound(&self, field: &str, bound: Option<&Bound>, agent: usize) -> Result<Option<f64>, Problem> {
        let Some(Bound(text)) = bound else { return Ok(None) };
        let constant = |name: &str| constant(name, self.assembly, agent).map(Operand::Constant);
        let formula = Expression::parse(text).and_then(|expression| expression.compile(constant));
        let value = formula.map(|formula| formula.evaluate(&[]));
        match value {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            Ok(value) => Err(self.problem(field, format!("expected a finite bound, {:?} is {value}", brief(text)))),
            Err(error) => {
                let limit = if text.contains("UM") && self.assembly.scenario.context.input_limit.is_none() {
                    "; this scenario sets no limit vehicle.UM"
                } else {
                    ""
                };
                Err(self.problem(field, format!("{}{limit}", error.within(text))))
            }
        }
    }

    fn problem(&self, field: &str, message: impl Into<String>) -> Problem {
        let place = self.node.at(field).unwrap_or(self.node);
        let path = if field.is_empty() { self.path.clone() } else { format!("{}.{field}", self.path) };
        Problem::new(Some(place.origin.clone()), path, message)
    }
}
