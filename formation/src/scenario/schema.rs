//! What the sections of a scenario look like to an editor, apart from those of components and claims. (JSON Schema)

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::adjacency::{Adjacency, RING, TWO_WAY_RING};
use super::agents::{Row, VehicleSection};
use super::context::TopologySection;
use super::coordinates::Coordinates;
use super::realtime::RealtimeSection;
use super::run_sections::PlacementSection;
use super::{Expectation, MOST_RESTARTS, Obstacles, OnFailure, Timing};

impl JsonSchema for Adjacency {
    fn schema_name() -> Cow<'static, str> {
        "Adjacency".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let row = json_schema!({ "type": "array", "items": crate::config::number() });
        json_schema!({ "anyOf": [
            { "type": "array", "items": row, "description": "The matrix, row by row." },
            { "enum": [RING, TWO_WAY_RING], "description": "A ring 1, 2, ..., N, 1 with unit weights: one way or both." },
        ] })
    }
}

impl JsonSchema for Coordinates {
    fn schema_name() -> Cow<'static, str> {
        "Coordinates".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [
            { "type": "array", "items": { "type": ["number", "string"] }, "description": "One value each." },
            { "type": ["number", "string"], "description": "The same for all coordinates." },
        ] })
    }
}

/// The schema of every section that is no component's, by its name.
pub fn sections(generator: &mut SchemaGenerator) -> BTreeMap<&'static str, Schema> {
    let formula = || json_schema!({ "type": ["string", "number"] });
    let formulas = |what: &str| json_schema!({ "type": "array", "items": formula(), "description": what });
    let define = || {
        json_schema!({
            "type": "object", "additionalProperties": formula(),
            "description": "Names for parts of formulas; a later one may use those before it.",
        })
    };
    let text = |what: &str| json_schema!({ "type": "string", "description": what });
    BTreeMap::from([
        (
            "name",
            json_schema!({
                "type": "string", "pattern": "^[A-Za-z0-9_-]+$", "description": "Name of the scenario; its logs are called so.",
            }),
        ),
        ("title", text("What the scenario is about, in one line.")),
        ("thesis", text("Section of the thesis.")),
        ("variant", text("The variant that the file itself is.")),
        (
            "seed",
            json_schema!({
                "type": "integer", "minimum": 0, "default": 0, "description": "Seed of all random numbers.",
            }),
        ),
        (
            "agents",
            json_schema!({
                "type": "array", "minItems": 1, "items": generator.subschema_for::<Row>(),
                "description": "The agents, numbered from 1 in this order.",
            }),
        ),
        ("timing", generator.subschema_for::<Timing>()),
        (
            "parameters",
            json_schema!({
                "type": "object", "additionalProperties": crate::config::number(),
                "description": "Named numbers that formulas may use.",
            }),
        ),
        ("vehicle", generator.subschema_for::<VehicleSection>()),
        ("topology", generator.subschema_for::<TopologySection>()),
        (
            "reference",
            json_schema!({
                "type": "object", "required": ["position"], "additionalProperties": false,
                "description": "Where the formation is to be.",
                "properties": {
                    "position": formulas("Formulas of t and i, one per coordinate, m and rad; their derivatives are taken exactly."),
                    "define": define(),
                },
            }),
        ),
        (
            "disturbance",
            json_schema!({
                "type": "object", "additionalProperties": false, "description": "What acts on the agents besides their inputs.",
                "properties": {
                    "matched": formulas("Added where the input acts: to the accelerations, or to the velocities of agents of order 1."),
                    "matched_first_order": formulas("The same for agents of order 1, if they have their own."),
                    "mismatched": formulas("Added to the velocities of agents of order 2."),
                    "define": define(),
                },
            }),
        ),
        ("obstacles", generator.subschema_for::<Obstacles>()),
        (
            "edges",
            json_schema!({
                "type": "object", "additionalProperties": { "enum": ["same_step", "delayed"] },
                "description": "Which sample a reader gets, by `reader <- writer`, where that is not what its component asks for.",
            }),
        ),
        ("on_failure", on_failure()),
        ("realtime", generator.subschema_for::<RealtimeSection>()),
        (
            "swap",
            json_schema!({
                "type": "object", "additionalProperties": { "type": ["string", "object"] },
                "description": "What plays a participant instead of ours, by participant: a command, `replay:LOG.mcap`, \
                                `hardware:FILE`, `emulator` or `emulator:free`.",
            }),
        ),
        ("ranges", ranges()),
        ("assert", assertions()),
        ("placement", generator.subschema_for::<PlacementSection>()),
        ("metrics", text("The set of metrics that is computed at the end.")),
        (
            "expect",
            json_schema!({
                "type": "object", "additionalProperties": generator.subschema_for::<Expectation>(),
                "description": "What should come out, by metric.",
            }),
        ),
    ])
}

/// A policy for all participants, or a table of policies by participant or role.
fn on_failure() -> Schema {
    let policy = || json_schema!({ "enum": OnFailure::NAMES.map(|(name, _)| name) });
    let table = json_schema!({
        "type": "object", "additionalProperties": policy(),
        "properties": {
            "others": policy(),
            "restarts": { "type": "integer", "minimum": 0, "maximum": MOST_RESTARTS },
            "deadline": { "type": ["number", "string"], "exclusiveMinimum": 0, "maximum": 86400 },
        },
    });
    json_schema!({
        "anyOf": [policy(), table],
        "description": "What is to be done when a participant fails; by participant or role if it is a table, which may also \
                        have `others`, how many `restarts` a process is allowed, and the `deadline` of a phase, s.",
    })
}

/// Ranges of fields.
fn ranges() -> Schema {
    let bound = |what: &str| json_schema!({ "type": ["number", "string"], "description": what });
    json_schema!({
        "type": "object",
        "additionalProperties": {
            "type": "object", "additionalProperties": false,
            "properties": { "min": bound("The least value."), "max": bound("The greatest value.") },
        },
        "description": "Ranges of fields, by `TOPIC.FIELD` such as `command.input`; a value outside stops the run.",
    })
}

/// Bounds of signals that are checked while a run goes on.
fn assertions() -> Schema {
    let number = |what: &str| json_schema!({ "type": ["number", "string"], "description": what });
    let bound = |what: &str| json_schema!({ "type": ["number", "string", "array"], "description": what });
    let text = |what: &str| json_schema!({ "type": "string", "description": what });
    json_schema!({
        "type": "array",
        "items": {
            "type": "object", "required": ["name"], "additionalProperties": false,
            "properties": {
                "name": text("What it says, in words."),
                "signal": text("A formula of the fields of an agent."),
                "metric": text("A named quantity of the formation instead of a signal."),
                "min": bound("The least value that is allowed."),
                "max": bound("The greatest value that is allowed."),
                "from": number("From this time on, s."),
                "to": number("Up to this time, s."),
                "agents": { "type": "array", "items": { "type": "integer" }, "description": "Only these agents." },
                "variants": { "type": "array", "items": { "type": "string" }, "description": "Only in these variants." },
                "across": { "enum": ["each", "norm", "sum"], "description": "How the agents are taken together." },
                "severity": { "enum": ["fail", "warn"], "description": "What a violation does to the run." },
                "stop": { "type": "boolean", "description": "Whether a violation ends the run." },
            },
        },
        "description": "Bounds of signals that are checked while a run goes on.",
    })
}
