//! From `[metrics]` to metrics that can be evaluated.

use formation::config::{Node, Problem, Problems, read as read_node};
use formation::wiring::Assembly;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use super::OwnMetric;
use super::default::default_set;
use super::formula::compile;
use crate::judge::assertions::Geometry;
use crate::judge::metrics::Definition;

/// More than these are taken for a mistake.
const MOST_METRICS: usize = 64;
/// The key of the table that names a set of metrics.
const SET: &str = "set";

/// A metric with its unit and meaning.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "OwnMetric")]
struct Row {
    /// A formula of reducers, such as "max(norm(state.velocity), from = 20)".
    value: String,
    /// Its unit.
    #[serde(default)]
    unit: String,
    /// What it means, in one sentence.
    #[serde(default)]
    description: String,
    /// Only these agents.
    agents: Option<Vec<u32>>,
}

/// What `[metrics]` looks like to an editor. (JSON Schema)
pub(crate) fn schema(generator: &mut SchemaGenerator, sets: &[&str]) -> Schema {
    let row = generator.subschema_for::<Row>();
    // No set at all.
    let sets: Vec<&str> = sets.iter().copied().chain([""]).collect();
    json_schema!({ "anyOf": [
        { "enum": sets, "description": "A set of metrics by its name; none if it is empty." },
        {
            "type": "object",
            "description": "Metrics of one's own: name and formula, or a table with `value`, `unit`, `description` and `agents`. `set` names a set besides.",
            "properties": { "set": { "enum": sets } },
            "additionalProperties": { "anyOf": [{ "type": "string" }, row] },
        },
    ] })
}

/// The metrics that the scenario defines, in the order of the file; before them the default set, if it names no set of metrics.
///
/// # Errors
/// Everything that is wrong with them, each with its place.
pub fn read(assembly: &Assembly) -> Result<Vec<OwnMetric>, Vec<Problem>> {
    let scenario = &assembly.scenario;
    let section = scenario.section("metrics");
    let table = section.and_then(Node::as_table);
    let names_set = match table {
        Some(table) => table.get(SET).is_some(),
        None => section.is_some(),
    };
    let geometry = Geometry::new(assembly);
    let mut metrics = if names_set { Vec::new() } else { default_set(assembly, &geometry) };
    let Some(table) = table else { return Ok(metrics) };
    let mut problems = Problems::default();
    let own: Vec<(&str, &Node)> = table.iter().filter(|(name, _)| *name != SET).collect();
    if own.len() > MOST_METRICS {
        return Err(vec![
            scenario.problem("metrics", format!("expected at most {MOST_METRICS} metrics, found {}", own.len())),
        ]);
    }
    for (name, node) in own {
        let path = format!("metrics.{name}");
        let row = match node.as_str() {
            Some(value) => {
                Some(Row { value: value.into(), unit: String::new(), description: String::new(), agents: None })
            }
            None if node.as_table().is_some() => read_node::<Row>(node, &path, &mut problems),
            None => {
                let message = format!("expected a formula, or a table with `value`, found {}", node.describe());
                problems.push(Problem::new(Some(node.origin.clone()), path, message));
                continue;
            }
        };
        let Some(row) = row else { continue };
        let place = |field: &str| match node.at(field).filter(|_| node.as_table().is_some()) {
            Some(inner) => (inner.origin.clone(), format!("{path}.{field}")),
            None => (node.origin.clone(), path.clone()),
        };
        let mut refuse = |field: &str, message: String| {
            let (origin, path) = place(field);
            problems.push(Problem::new(Some(origin), path, message));
        };
        if name.is_empty() || !name.chars().all(|c| c.is_alphanumeric() || "_-.()".contains(c)) {
            refuse("", "expected a name of letters, digits, `_`, `-` and `.`".into());
        }
        match agents(row.agents.as_deref(), scenario.context.agents.len()) {
            Err(message) => refuse("agents", message),
            Ok(agents) => match metric(name, &row, assembly, &geometry, &agents) {
                Err(message) => refuse("value", message),
                Ok(metric) => {
                    metrics.retain(|known| known.id != metric.id);
                    metrics.push(metric);
                }
            },
        }
    }
    if problems.is_empty() { Ok(metrics) } else { Err(problems.into_vec()) }
}

fn metric(
    name: &str,
    row: &Row,
    assembly: &Assembly,
    geometry: &Geometry,
    agents: &[usize],
) -> Result<OwnMetric, String> {
    let (value, reductions) = compile(&row.value, assembly, geometry, agents)?;
    let text = if row.description.is_empty() {
        format!("Defined by the scenario: {}.", row.value)
    } else {
        row.description.clone()
    };
    let definition = Definition::own(name, &row.value, &row.unit, text);
    Ok(OwnMetric { id: name.into(), definition, value, reductions })
}

/// Places of the agents with these numbers; of all if there are none.
fn agents(numbers: Option<&[u32]>, count: usize) -> Result<Vec<usize>, String> {
    let Some(numbers) = numbers else { return Ok((0..count).collect()) };
    let place = |&number: &u32| (number as usize).checked_sub(1).filter(|place| *place < count);
    let places: Option<Vec<usize>> = numbers.iter().map(place).collect();
    let expected = || format!("expected numbers of agents from 1 to {count}");
    places.filter(|places| !places.is_empty()).ok_or_else(expected)
}
