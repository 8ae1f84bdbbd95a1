//! What sections without a type of their own look like to an editor. (JSON Schema)

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::coordinates::Coordinates;
use super::{MOST_RESTARTS, OnFailure};

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

pub(super) fn formula() -> Schema {
    json_schema!({ "type": ["string", "number"] })
}

pub(super) fn formulas(what: &str) -> Schema {
    json_schema!({ "type": "array", "items": formula(), "description": what })
}

/// The table of named parts of formulas.
pub(super) fn define() -> Schema {
    json_schema!({
        "type": "object", "additionalProperties": formula(),
        "description": "Names for parts of formulas; a later one may use those before it.",
    })
}

/// `[reference]`.
pub(super) fn reference(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "object", "required": ["position"], "additionalProperties": false,
        "description": "Where the formation is to be.",
        "properties": {
            "position": formulas("Formulas of t and i, one per coordinate, m and rad; their derivatives are taken exactly."),
            "define": define(),
        },
    })
}

/// `[disturbance]`.
pub(super) fn disturbance(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "object", "additionalProperties": false, "description": "What acts on the agents besides their inputs.",
        "properties": {
            "matched": formulas("Added where the input acts: to the accelerations, or to the velocities of agents of order 1."),
            "matched_first_order": formulas("The same for agents of order 1, if they have their own."),
            "mismatched": formulas("Added to the velocities of agents of order 2."),
            "define": define(),
        },
    })
}

/// `[data]`.
pub(super) fn data(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "object", "additionalProperties": { "type": "string", "pattern": "^[0-9a-f]{64}$" },
        "description": "SHA-256 of data files that formulas read, by their paths: other files are refused. Logs have those of all \
                        files, which are attached to them.",
    })
}

/// `[edges]`.
pub(super) fn edges(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "object", "additionalProperties": { "enum": ["same_step", "delayed"] },
        "description": "Which sample a reader gets, by `reader <- writer`, where that is not what its component asks for.",
    })
}

/// `[swap]`.
pub(super) fn swap(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "object", "additionalProperties": { "type": ["string", "object"] },
        "description": "What plays a participant instead of ours, by participant: a command, `replay:LOG.mcap`, \
                        `hardware:FILE`, `emulator` or `emulator:free`.",
    })
}

/// A policy for all participants, or a table of policies by participant or role.
pub(super) fn on_failure(_: &mut SchemaGenerator) -> Schema {
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

/// `[ranges]`.
pub(super) fn ranges(_: &mut SchemaGenerator) -> Schema {
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
