//! The fields of a link as they are written.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use crate::config::FormulaText;
use crate::scenario::elsewhere::Elsewhere;

/// A link between two agents.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "fields that are read elsewhere are named here for the schema and for unknown fields")]
pub(super) struct LinkTable {
    /// Time on the way, s: a number, a formula of t, distance, i (receiver) and j (sender), or a distribution.
    #[serde(default)]
    #[schemars(schema_with = "delay")]
    delay: Option<Elsewhere>,
    /// Whether a message may overtake an earlier one; the one that comes behind a newer one is not taken.
    #[serde(default)]
    pub(super) reordering: bool,
    /// Probability that a message is lost: a number, a formula of t, distance, i and j, or a model.
    #[serde(default)]
    #[schemars(schema_with = "loss")]
    loss: Option<Elsewhere>,
    /// Whether both directions between two agents have the same random numbers: messages that are sent in the same step are lost
    /// together.
    #[serde(default)]
    pub(super) symmetric: bool,
    /// What is seen when a message does not arrive: `hold` (the last one), `zero`, or `linear` (prediction through the last two).
    #[serde(default)]
    pub(super) missing: MissingName,
    /// Messages per second; by default one in every step.
    pub(super) rate_hz: Option<f64>,
    /// Time of the first message, s.
    #[serde(default)]
    pub(super) phase: f64,
    /// Sends only if this condition holds, and the first message: `norm(position - sent.position) > 0.02`.
    pub(super) trigger: Option<FormulaText>,
    /// Time until the next message, s, computed when one is sent.
    pub(super) interval: Option<FormulaText>,
    /// Standard deviation of noise on the numbers: one for all, or by signal.
    #[serde(default)]
    #[schemars(schema_with = "by_signal")]
    noise: Option<Elsewhere>,
    /// Step of the quantiser: one for all, or by signal.
    #[serde(default)]
    #[schemars(schema_with = "by_signal")]
    quantum: Option<Elsewhere>,
    /// Distance beyond which all messages are lost, m.
    pub(super) range: Option<f64>,
    /// Bits per second of the sender; its messages wait for each other.
    pub(super) bandwidth: Option<f64>,
    /// Bits of a number.
    #[serde(default = "bits")]
    pub(super) bits: f64,
    /// Most messages on their way; further ones are lost. By default as many as the delay needs, or 1000 if it has no bound.
    pub(super) limit: Option<usize>,
}

fn bits() -> f64 {
    64.0
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum MissingName {
    #[default]
    Hold,
    Zero,
    Linear,
}

/// A distribution of delays.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub(super) enum DelayTable {
    /// Equally likely between both, s.
    Uniform { low: f64, high: f64 },
    /// Normal, between `low` and `high`, s.
    Normal {
        mean: f64,
        standard_deviation: f64,
        #[serde(default)]
        low: f64,
        high: Option<f64>,
    },
    /// `shift` and a number of the gamma distribution.
    Gamma {
        shape: f64,
        scale: f64,
        #[serde(default)]
        shift: f64,
    },
    /// The column of a data file, s; `factor` multiplies it, such as 1e-3 for ms.
    Trace {
        file: String,
        column: String,
        #[serde(default = "one")]
        factor: f64,
    },
}

/// A model of losses.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub(super) enum LossTable {
    /// Bursts: probabilities of the change to the bad state (`p`) and back (`r`), and of a loss in either.
    GilbertElliott {
        p: f64,
        r: f64,
        #[serde(default)]
        good: f64,
        #[serde(default = "one")]
        bad: f64,
    },
    /// The column of a data file: 1 for a message that is lost, 0 for one that arrives.
    Trace { file: String, column: String },
}

fn one() -> f64 {
    1.0
}

/// One of `models`, with its name in the field `kind`.
fn with_kind(models: &Schema) -> Schema {
    let variants = models.get("oneOf").and_then(|all| all.as_array().cloned()).unwrap_or_default();
    let variants = variants.into_iter().filter_map(|variant| {
        let (name, inner) = variant.get("properties")?.as_object()?.iter().next()?;
        let mut inner = inner.clone();
        let table = inner.as_object_mut()?;
        table.get_mut("properties")?.as_object_mut()?.insert("kind".into(), serde_json::json!({ "const": name }));
        let required = table.entry("required").or_insert_with(|| serde_json::json!([]));
        required.as_array_mut()?.push("kind".into());
        Some(inner)
    });
    json_schema!({ "oneOf": variants.collect::<Vec<_>>() })
}

fn delay(generator: &mut SchemaGenerator) -> Schema {
    let models = with_kind(&DelayTable::json_schema(generator));
    json_schema!({
        "anyOf": [{ "type": ["number", "string"] }, models],
        "description": "Time on the way, s: a number, a formula of t, distance, i (receiver) and j (sender), or a distribution.",
    })
}

fn loss(generator: &mut SchemaGenerator) -> Schema {
    let models = with_kind(&LossTable::json_schema(generator));
    json_schema!({
        "anyOf": [{ "type": ["number", "string"] }, models],
        "description": "Probability that a message is lost: a number, a formula of t, distance, i and j, or a model.",
    })
}

fn by_signal(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": ["number", "object"], "additionalProperties": { "type": "number" } })
}
