//! The contract of a component: a section of a scenario file that can become participants.

use lockstep::{Field, Participant};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::DeserializeOwned;

use super::{Bind, Refusal};
use crate::config::{Node, PerAgent, Problems, Value, read};
use crate::scenario::Context;

/// The parameters of a component, read from its section of the scenario.
pub trait Component: Send + Sync {
    /// Parameters out of their admissible range, or demands on the scenario that it does not meet.
    fn check(&self, context: &Context) -> Checks {
        let _ = context;
        Checks::default()
    }

    /// What is published for `agent` (from 0), in order.
    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field>;

    /// The participant that serves `agents` (from 0): one for an observer or a controller, all for a planner.
    ///
    /// # Errors
    /// [`Refusal`] if a signal that it needs is missing, or if it cannot serve this vehicle.
    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal>;

    /// Whether it has no law of its own, so that a program must take its place.
    fn is_external(&self) -> bool {
        false
    }
}

/// A component by the name that scenario files use.
#[derive(Clone, Copy)]
pub struct Kind {
    /// Its `kind` in a scenario file.
    pub name: &'static str,
    /// One line for `phalanx list --components` and for the documentation.
    pub summary: &'static str,
    /// Reads its parameters.
    pub read: fn(&Node, &str, &mut Problems) -> Option<Box<dyn Component>>,
    /// What its parameters look like to an editor.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
}

impl Kind {
    /// The registry entry of the component whose parameters are `C`.
    pub const fn of<C: Component + DeserializeOwned + JsonSchema + 'static>(
        name: &'static str,
        summary: &'static str,
    ) -> Self {
        Self {
            name,
            summary,
            read: |node, path, problems| {
                read::<C>(node, path, problems).map(|parameters| Box::new(parameters) as Box<dyn Component>)
            },
            schema: SchemaGenerator::subschema_for::<C>,
        }
    }
}

impl Kind {
    /// The defaults of its parameters that are numbers, texts or booleans, by name.
    pub fn defaults(&self) -> Vec<(String, Value)> {
        let mut generator = SchemaGenerator::default();
        let schema = (self.schema)(&mut generator);
        let definition = schema.get("$ref").and_then(|place| place.as_str()?.rsplit('/').next().map(str::to_string));
        let definition = definition.and_then(|name| generator.definitions().get(&name).cloned());
        let whole = definition.unwrap_or_else(|| schema.to_value());
        let fields = whole.get("properties").and_then(|fields| fields.as_object()).into_iter().flatten();
        fields.filter_map(|(name, field)| Some((name.clone(), plain(field.get("default")?)?))).collect()
    }
}

/// A number, text or boolean as scenario files have it.
fn plain(value: &serde_json::Value) -> Option<Value> {
    match value {
        serde_json::Value::Bool(value) => Some(Value::Bool(*value)),
        serde_json::Value::String(text) => Some(Value::String(text.clone())),
        serde_json::Value::Number(number) => number.as_i64().map(Value::Integer).or(number.as_f64().map(Value::Float)),
        _ => None,
    }
}

/// Collects what [`Component::check`] finds: pairs of field (relative to the section) and message.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Checks {
    /// Field and message.
    pub findings: Vec<(String, String)>,
}

impl Checks {
    /// Reports `message` at `field` unless `admissible`.
    pub fn require(mut self, admissible: bool, field: &str, message: impl Into<String>) -> Self {
        if !admissible {
            self.findings.push((field.into(), message.into()));
        }
        self
    }

    /// `value` must be a positive number.
    pub fn positive(self, field: &str, value: f64) -> Self {
        let admissible = value.is_finite() && value > 0.0;
        self.require(admissible, field, format!("expected a number > 0, found {value}"))
    }

    /// `rule` must give every agent a positive number.
    pub fn positive_each(self, field: &str, rule: &PerAgent, context: &Context) -> Self {
        match context.resolve(rule) {
            Ok(values) => match values.into_iter().find(|value| !(value.is_finite() && *value > 0.0)) {
                Some(value) => self.positive(field, value),
                None => self,
            },
            Err(message) => self.require(false, field, message),
        }
    }

    /// `value` must be a number >= 0.
    pub fn not_negative(self, field: &str, value: f64) -> Self {
        let admissible = value.is_finite() && value >= 0.0;
        self.require(admissible, field, format!("expected a number >= 0, found {value}"))
    }

    /// `value` must be a finite number.
    pub fn finite(self, field: &str, value: f64) -> Self {
        self.require(value.is_finite(), field, format!("expected a finite number, found {value}"))
    }

    /// `low < value < high`.
    pub fn between(self, field: &str, value: f64, low: f64, high: f64) -> Self {
        let admissible = low < value && value < high;
        self.require(admissible, field, format!("expected a number between {low} and {high}, found {value}"))
    }

    /// Every agent must know the reference or hear of it from others; where the graph switches, over links that exist at any time.
    pub fn led(mut self, context: &Context) -> Self {
        if let Some(agent) = context.topology.union().unled_agent() {
            let message =
                format!("agent {} neither has b > 0 nor hears, over any links, of an agent that has", agent + 1);
            self.findings.push(("/topology.b".into(), message));
        }
        self
    }

    /// The communication graph must be strongly connected (where it switches, the union of its graphs); where the scenario allows any graph, the reference must reach every agent.
    pub fn strongly_connected(mut self, context: &Context) -> Self {
        if context.any_graph {
            return self.led(context);
        }
        if let Some((from, to)) = context.topology.union().unreachable_pair() {
            self.findings.push((
                "/topology.A".into(),
                format!(
                    "the graph is not strongly connected, as this scheme requires: nothing that agent {} sends reaches agent {}; \
                     topology.any_graph = true allows any graph in which the reference reaches every agent",
                    from + 1,
                    to + 1
                ),
            ));
        }
        self
    }
}
