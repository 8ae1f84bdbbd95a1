//! What `[vehicle]` with equations looks like to an editor, and the names of its fields. (JSON Schema)

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use crate::config::PerAgent;
use crate::scenario::elsewhere::Elsewhere;
use crate::scenario::schema::{define, formula, formulas};
use crate::scenario::standard_vehicle::VehicleSection;

/// `[vehicle]` with `kind = "equations"`, or a vehicle of the library with what is changed of it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "fields that are read from the tree are named here for the schema and for unknown fields")]
pub(in crate::scenario) struct EquationsSection {
    /// `equations`, or a vehicle of the library: `phalanx list --vehicles` shows them.
    pub(super) kind: String,
    /// What messages call it.
    pub(super) name: Option<String>,
    /// A file of such a section, `[vehicle]`, which this one completes; its path starts from the folder of the scenario file.
    pub(super) file: Option<String>,
    /// What it is, in one line.
    pub(super) title: Option<String>,
    /// The book, paper or data sheet that the equations come from.
    pub(super) source: Option<String>,
    /// Unit of each state; or a table with its `unit` and its `initial` value. Rows of agents give initial values by these names.
    #[serde(default)]
    #[schemars(schema_with = "states")]
    states: Option<Elsewhere>,
    /// Unit of each input; or a table with its `unit` and the limits `low` and `high` at which it saturates.
    #[serde(default)]
    #[schemars(schema_with = "inputs")]
    inputs: Option<Elsewhere>,
    /// Numbers for the formulas: one for all, a list, or a formula of i and N. Rows of agents may have their own by these names.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, PerAgent>")]
    parameters: Option<Elsewhere>,
    #[serde(default)]
    #[schemars(schema_with = "named_parts")]
    define: Option<Elsewhere>,
    /// The time derivative of each state: formulas of t, states, inputs, parameters and definitions.
    #[serde(default)]
    #[schemars(schema_with = "by_name")]
    d: Option<Elsewhere>,
    /// The position: 1 to 3 formulas, mostly names of states.
    #[serde(default)]
    #[schemars(schema_with = "coordinates")]
    position: Option<Elsewhere>,
    /// The velocity: as many; by default the time derivative of a position that consists of states.
    #[serde(default)]
    #[schemars(schema_with = "coordinates")]
    velocity: Option<Elsewhere>,
    /// Other signals: a formula, a list of formulas, or a table with such a `value` and its `unit`.
    #[serde(default)]
    #[schemars(schema_with = "outputs")]
    outputs: Option<Elsewhere>,
    /// The states that are angles.
    #[serde(default)]
    pub(super) angles: Vec<String>,
}

/// A state with more than its unit.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StateTable {
    /// Its unit.
    #[serde(default)]
    pub(super) unit: String,
    /// Its value at t = 0 where the row of an agent does not give it.
    pub(super) initial: Option<f64>,
}

/// An input with more than its unit.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct InputTable {
    /// Its unit.
    #[serde(default)]
    pub(super) unit: String,
    /// The least value that acts.
    pub(super) low: Option<f64>,
    /// The greatest value that acts.
    pub(super) high: Option<f64>,
}

/// `[vehicles]`: vehicles by name, for agents that are not all alike.
pub(in crate::scenario) struct NamedVehicles;

impl JsonSchema for NamedVehicles {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "NamedVehicles".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let any = json_schema!({ "anyOf": [
            generator.subschema_for::<VehicleSection>(), generator.subschema_for::<EquationsSection>(),
        ] });
        json_schema!({
            "type": "object", "additionalProperties": any,
            "description": "Vehicles by name, for agents that are not all alike: `vehicle` in the row of an agent names one.",
        })
    }
}

/// `[vehicle]`: one of both.
pub(in crate::scenario) fn vehicle(generator: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "anyOf": [generator.subschema_for::<VehicleSection>(), generator.subschema_for::<EquationsSection>()],
        "description": "What all agents have in common.",
    })
}

fn unit() -> Schema {
    json_schema!({ "type": "string", "description": "Its unit; empty for a pure number." })
}

fn states(generator: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "object", "additionalProperties": { "anyOf": [unit(), generator.subschema_for::<StateTable>()] },
    })
}

fn inputs(generator: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "object", "additionalProperties": { "anyOf": [unit(), generator.subschema_for::<InputTable>()] },
    })
}

fn outputs(_: &mut SchemaGenerator) -> Schema {
    let value = || json_schema!({ "anyOf": [formula(), formulas("One each.")] });
    let table = json_schema!({
        "type": "object", "required": ["value"], "additionalProperties": false,
        "properties": { "value": value(), "unit": unit() },
    });
    json_schema!({ "type": "object", "additionalProperties": { "anyOf": [formula(), formulas("One each."), table] } })
}

fn by_name(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "object", "additionalProperties": formula() })
}

fn named_parts(_: &mut SchemaGenerator) -> Schema {
    define()
}

fn coordinates(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "items": formula(), "minItems": 1, "maxItems": 3 })
}
