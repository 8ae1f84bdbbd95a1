//! A signal that a scenario declares for a program.

use std::fmt;

use lockstep::MAX_WORDS;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::config::is_signal_name;

/// Names that the header of every sample has.
const RESERVED: [&str; 4] = ["stamp", "step", "agent", "status"];

/// A signal: how many numbers it has, their unit, and what is read of it before its first sample.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Signal {
    /// Number of values.
    pub(super) size: usize,
    /// Empty for pure numbers.
    pub(super) unit: String,
    /// What delayed readers see at step 0; zeros if it is not given.
    pub(super) initial: Option<Vec<f64>>,
}

/// The long form of a signal.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    size: usize,
    #[serde(default)]
    unit: String,
    initial: Option<Vec<f64>>,
}

impl Signal {
    /// What is wrong with a signal of this name, with the field where it is.
    pub(super) fn findings(&self, name: &str) -> Vec<(String, String)> {
        let mut findings = Vec::new();
        let mut report = |field: &str, message: String| findings.push((format!("signals.{name}{field}"), message));
        if let Some(reason) = wrong_name(name) {
            report("", reason);
        }
        if !(1..=MAX_WORDS).contains(&self.size) {
            report(".size", format!("expected a size from 1 to {MAX_WORDS}, found {}", self.size));
        }
        if self.unit.chars().any(char::is_control) {
            report(".unit", "expected a unit in one line, such as \"m/s^2, rad/s\"".into());
        }
        match &self.initial {
            Some(values) if values.len() != self.size => {
                report(".initial", format!("expected {} numbers, as `size` says, found {}", self.size, values.len()));
            }
            Some(values) if values.iter().any(|value| !value.is_finite()) => {
                report(".initial", "expected finite numbers".into());
            }
            _ => {}
        }
        findings
    }
}

/// Why a signal cannot have this name.
fn wrong_name(name: &str) -> Option<String> {
    if !is_signal_name(name) {
        return Some(
            "expected a name of lower-case letters, digits and single underscores, such as `wind_speed`".into(),
        );
    }
    RESERVED.contains(&name).then(|| {
        format!(
            "every sample has {} in its header: choose another name",
            RESERVED.map(|name| format!("`{name}`")).join(", ")
        )
    })
}

impl<'de> Deserialize<'de> for Signal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SignalVisitor)
    }
}

struct SignalVisitor;

impl<'de> Visitor<'de> for SignalVisitor {
    type Value = Signal;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a size such as 6, or a table such as { size = 6, unit = \"m/s^2, rad/s\" }")
    }

    fn visit_i64<E: Error>(self, size: i64) -> Result<Signal, E> {
        let wrong = || E::custom(format!("expected a size from 1 to {MAX_WORDS}, found {size}"));
        let size = usize::try_from(size).map_err(|_| wrong())?;
        Ok(Signal { size, unit: String::new(), initial: None })
    }

    fn visit_u64<E: Error>(self, size: u64) -> Result<Signal, E> {
        Ok(Signal { size: usize::try_from(size).unwrap_or(0), unit: String::new(), initial: None })
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Signal, A::Error> {
        let Table { size, unit, initial } = Table::deserialize(MapAccessDeserializer::new(table))?;
        Ok(Signal { size, unit, initial })
    }
}

impl JsonSchema for Signal {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Signal".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let size = json_schema!({
            "type": "integer", "minimum": 1, "maximum": MAX_WORDS, "description": "How many numbers the signal has.",
        });
        json_schema!({
            "anyOf": [
                size,
                {
                    "type": "object", "required": ["size"], "additionalProperties": false,
                    "properties": {
                        "size": size,
                        "unit": { "type": "string", "description": "Unit of the numbers." },
                        "initial": {
                            "type": "array", "items": { "type": "number" },
                            "description": "What is read before the first sample.",
                        },
                    },
                },
            ],
        })
    }
}
