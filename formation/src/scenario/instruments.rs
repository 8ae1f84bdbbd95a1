//! `[sensors]` and `[actuators]`: what agents measure of themselves, and what becomes of their commands.

use std::collections::BTreeMap;

use lockstep::Layout;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::DeserializeOwned;

use super::links::{is_choice, known};
use super::{Context, agents_in};
use crate::config::{Node, Problem, Problems, Table, Value, did_you_mean, read};
use crate::effects::{ActuatorLimits, SensorErrors};

/// Tables of parameters by signal or input, with those that differ for some agents in tables by agent, `"2"` or `"1,3-6"`.
#[derive(Clone, Debug)]
pub struct Instruments {
    section: &'static str,
    base: Node,
    /// The agents, by their numbers in the file, and what differs for them.
    overlays: Vec<(Vec<usize>, Node)>,
}

/// The sections.
pub(crate) const SENSORS: &str = "sensors";
pub(crate) const ACTUATORS: &str = "actuators";

impl Instruments {
    /// Reads one of both sections; `ids` are the numbers of the agents in the file.
    pub(super) fn read(root: &Node, section: &'static str, ids: &[u32], problems: &mut Problems) -> Option<Self> {
        let node = root.at(section)?;
        let Some(table) = node.as_table() else {
            problems.at(root, section, format!("expected a table, found {}", node.describe()));
            return None;
        };
        let (mut base, mut overlays) = (Table::default(), Vec::new());
        for (key, node) in table.iter() {
            let Some(agents) = agents_in(key) else {
                base.insert(key, node.clone());
                continue;
            };
            let unknown = agents.iter().find(|agent| !ids.iter().any(|id| *id as usize == **agent));
            if let Some(agent) = unknown.filter(|_| !is_choice(ids)) {
                let message = format!("there is no agent {agent}, only {}", known(ids));
                problems.push(Problem::new(Some(node.origin.clone()), format!("{section}.{key}"), message));
            }
            overlays.push((agents, node.clone()));
        }
        Some(Self { section, base: Node { value: Value::Table(base), origin: node.origin.clone() }, overlays })
    }

    /// The table of an agent, by its number in the file.
    fn table(&self, id: u32) -> Result<Node, Problem> {
        let mut node = self.base.clone();
        for (_, overlay) in self.overlays.iter().filter(|(agents, _)| agents.contains(&(id as usize))) {
            node.overlay(overlay.clone())?;
        }
        Ok(node)
    }

    /// The sensors of the agent at a place (from 0) whose plant publishes `layout`, by signal.
    ///
    /// # Errors
    /// Everything that is wrong with their parameters.
    pub(crate) fn sensors(
        &self,
        context: &Context,
        agent: usize,
        layout: &Layout,
    ) -> Result<BTreeMap<String, SensorErrors>, Vec<Problem>> {
        let node = self.table(context.agents[agent].id).map_err(|problem| vec![problem])?;
        let (mut sensors, mut problems) = (BTreeMap::new(), Problems::default());
        let dt = context.timing.dt;
        for (signal, node) in node.as_table().into_iter().flat_map(Table::iter) {
            if layout.find(signal).is_none() {
                let names = layout.fields().iter().map(|field| field.name.as_str());
                let hint = did_you_mean(signal, names.clone());
                let known = names.collect::<Vec<_>>().join(", ");
                let message = format!("the plant publishes no signal of this name, expected one of {known}{hint}");
                problems.push(self.problem(node, signal, message));
                continue;
            }
            let found = self.one(node, signal, &mut problems, |errors: &SensorErrors| errors.findings(dt));
            found.into_iter().for_each(|errors| _ = sensors.insert(signal.to_string(), errors));
        }
        if problems.is_empty() { Ok(sensors) } else { Err(problems.into_vec()) }
    }

    /// The actuators of the agent at a place (from 0), for each of these inputs.
    ///
    /// # Errors
    /// Everything that is wrong with their parameters.
    pub(crate) fn actuators(
        &self,
        context: &Context,
        agent: usize,
        inputs: &[String],
    ) -> Result<Vec<ActuatorLimits>, Vec<Problem>> {
        let node = self.table(context.agents[agent].id).map_err(|problem| vec![problem])?;
        let mut problems = Problems::default();
        let (mut all, mut single) = (Table::default(), Table::default());
        for (key, node) in node.as_table().into_iter().flat_map(Table::iter) {
            let is_input = node.as_table().is_some();
            if is_input && !inputs.iter().any(|input| input == key) {
                let hint = did_you_mean(key, inputs.iter().map(String::as_str));
                let message =
                    format!("the vehicle has no input of this name, expected one of {}{hint}", inputs.join(", "));
                problems.push(self.problem(node, key, message));
            }
            (if is_input { &mut single } else { &mut all }).insert(key, node.clone());
        }
        let all = Node { value: Value::Table(all), origin: self.base.origin.clone() };
        let mut actuators = Vec::new();
        for input in inputs {
            let (mut node, mut path) = (all.clone(), "");
            if let Some(own) = single.get(input) {
                path = input;
                if let Err(problem) = node.overlay(own.clone()) {
                    problems.push(problem);
                }
            }
            let findings = |limits: &ActuatorLimits| limits.findings(context.timing.dt);
            let before = problems.len();
            actuators.extend(self.one(&node, path, &mut problems, findings));
            if problems.len() > before {
                break; // the other inputs would repeat it
            }
        }
        if problems.is_empty() { Ok(actuators) } else { Err(problems.into_vec()) }
    }

    /// Reads and checks one table.
    fn one<T: DeserializeOwned>(
        &self,
        node: &Node,
        path: &str,
        problems: &mut Problems,
        findings: impl FnOnce(&T) -> Vec<(&'static str, String)>,
    ) -> Option<T> {
        let section = [self.section, path].join(".");
        let value = read::<T>(node, section.trim_end_matches('.'), problems)?;
        let wrong = findings(&value).into_iter();
        let wrong: Vec<Problem> = wrong
            .map(|(field, message)| {
                let node = node.at(field).unwrap_or(node);
                self.problem(node, [path, field].join(".").trim_start_matches('.'), message)
            })
            .collect();
        let is_right = wrong.is_empty();
        problems.extend(wrong);
        is_right.then_some(value)
    }

    fn problem(&self, node: &Node, field: &str, message: impl Into<String>) -> Problem {
        Problem::new(Some(node.origin.clone()), format!("{}.{field}", self.section), message)
    }
}

/// A table by agent or signal, whose fields are those of `T` or tables of them.
fn tables<T: JsonSchema>(generator: &mut SchemaGenerator, description: &str) -> Schema {
    let one = T::json_schema(generator);
    json_schema!({
        "type": "object", "description": description,
        "additionalProperties": { "anyOf": [one, { "type": "object", "additionalProperties": one }] },
    })
}

/// `[sensors]`.
pub(super) fn sensors_schema(generator: &mut SchemaGenerator) -> Schema {
    let what = "What observers and controllers see of the plant, by signal; for some agents, in tables by agent, `[sensors.\"2\".position]`.";
    tables::<SensorErrors>(generator, what)
}

/// `[actuators]`.
pub(super) fn actuators_schema(generator: &mut SchemaGenerator) -> Schema {
    let what =
        "What becomes of the commands: of all inputs, or by input in tables; for some agents, in tables by agent.";
    let mut schema = tables::<ActuatorLimits>(generator, what);
    let own = ActuatorLimits::json_schema(generator);
    if let Some(properties) = own.get("properties") {
        schema.insert("properties".into(), properties.clone());
    }
    schema
}
