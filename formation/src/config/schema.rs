//! What the types of this module look like to an editor. (JSON Schema)

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::{Diagonal, PerAgent};

/// A number as scenario files have it: `0.5`, or a formula of constants such as `"pi/4"`.
pub fn number() -> Schema {
    json_schema!({ "type": ["number", "string"] })
}

impl JsonSchema for PerAgent {
    fn schema_name() -> Cow<'static, str> {
        "PerAgent".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [
                { "type": ["number", "string"], "description": "One number for all agents, or a formula of i and N." },
                { "type": "array", "items": number(), "description": "A number for each agent." },
            ]
        })
    }
}

impl JsonSchema for Diagonal {
    fn schema_name() -> Cow<'static, str> {
        "Diagonal".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [
                { "type": "number", "description": "One gain for all channels." },
                { "type": "array", "items": number(), "description": "A gain for each channel." },
            ]
        })
    }
}
