//! What a scenario file may contain, for editors and for the documentation: both come from the types that read the file.

mod document;
mod page;
mod relax;

use formation::scenario::{SECTIONS, sections};
use formation::wiring::{Kind, Role};
use schemars::SchemaGenerator;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

use crate::catalog::Catalog;
use crate::judge::assertions;
use crate::judge::claims::Claims;
use crate::judge::own;
use document::tidy;
pub use page::page;
use relax::relax;

/// The JSON Schema (draft 7, which all editors read) of scenario files.
pub fn schema(catalog: &Catalog) -> Value {
    let mut properties = properties(catalog);
    let relaxed: Map<String, Value> = properties.iter().map(|(name, schema)| (name.clone(), relax(schema))).collect();
    properties.insert(
        "variants".into(),
        json!({
            "type": "object",
            "description": "Tables that are laid over the file, by the name of the variant.",
            "additionalProperties": { "type": "object", "properties": relaxed, "additionalProperties": false },
        }),
    );
    let fields = properties.get("agents").and_then(|agents| agents["items"]["properties"].as_object());
    let fields: Vec<&String> = fields.into_iter().flat_map(Map::keys).collect();
    // Rows of agents by equations have the names of states and parameters; all others have these fields only.
    let standard = json!({ "properties": { "vehicle": {
        "required": ["kind"], "properties": { "kind": { "enum": ["omni", "integrator", "quadcopter"] } },
    } }, "required": ["vehicle"] });
    let rows = json!({ "propertyNames": { "enum": fields }, "required": ["position"] });
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "if": standard,
        "then": { "properties": { "agents": { "items": rows } } },
        "title": "Phalanx scenario",
        "type": "object",
        "required": ["name", "agents", "timing"],
        "properties": properties,
        "additionalProperties": false,
    })
}

/// Every key of a scenario file but `variants`, in their order.
fn properties(catalog: &Catalog) -> Map<String, Value> {
    let mut generator = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true).into_generator();
    let mut known = sections(&mut generator);
    let mut properties = Map::new();
    for name in SECTIONS.iter().filter(|name| **name != "variants") {
        let schema = match (Role::ALL.into_iter().find(|role| role.name() == *name), *name) {
            (Some(role), _) => section(catalog, role, &mut generator),
            (None, "claims") => json!({
                "type": "array",
                "items": Claims::schema(&mut generator),
                "description": "What must hold between the variants.",
            }),
            (None, "assert") => json!({
                "type": "array",
                "items": assertions::schema(&mut generator),
                "description": "Bounds of signals that are checked while a run goes on.",
            }),
            (None, "metrics") => {
                let names: Vec<&str> = catalog.metrics.iter().map(|set| set.name).collect();
                let mut schema = Value::from(own::schema(&mut generator, &names));
                schema["description"] =
                    json!("The metrics that are computed at the end: a set, or formulas of one's own.");
                schema
            }
            _ => known.remove(*name).map(Value::from).unwrap_or_default(),
        };
        properties.insert((*name).into(), tidy(schema));
    }
    properties
}

/// The section of a role: the parameters of one of its components, and how often it runs.
fn section(catalog: &Catalog, role: Role, generator: &mut SchemaGenerator) -> Value {
    let mut kinds: Vec<Value> = catalog.roles.of(role).map(|kind| component(role, kind, generator)).collect();
    if role == Role::Observer {
        kinds.push(json!({
            "type": "object",
            "title": "none",
            "description": "No observer: so a variant drops the one of its file.",
            "properties": { "kind": { "const": "none" } },
            "required": ["kind"],
        }));
    }
    json!({ "type": "object", "oneOf": kinds })
}

/// A component: its parameters, its name, and the keys that every section of a role may have.
fn component(role: Role, kind: &Kind, generator: &mut SchemaGenerator) -> Value {
    let parameters = Value::from((kind.schema)(generator));
    let mut properties = Map::from_iter([("kind".to_string(), json!({ "const": kind.name }))]);
    properties.extend(parameters["properties"].as_object().cloned().unwrap_or_default());
    let steps = |least: u64, what: &str| json!({ "type": "integer", "minimum": least, "maximum": 1_000_000, "default": least, "description": what });
    properties
        .insert("every".into(), steps(1, "The role runs at every so many steps; in between, its last sample stands."));
    properties.insert("offset".into(), steps(0, "The first step at which the role runs."));
    let what = format!(
        "Parameters for a program that takes the place of the {role}: any names, with numbers, texts, paths or lists; `with` of an \
         agent overrides them."
    );
    properties.insert("with".into(), json!({ "type": "object", "description": what }));
    if role == Role::Plant {
        let what = "Makes the plant of every agent a process of its own.";
        let groups = json!({
            "type": "array",
            "items": { "type": "array", "items": { "type": "integer", "minimum": 1 } },
            "description": "Lists of agents whose plants are one participant; that of any other agent is one by itself.",
        });
        properties.insert("groups".into(), groups);
        properties.insert("per_agent".into(), json!({ "type": "boolean", "default": false, "description": what }));
    }
    let mut required = vec![json!("kind")];
    required.extend(parameters["required"].as_array().cloned().unwrap_or_default());
    json!({
        "type": "object",
        "title": kind.name,
        "description": kind.summary,
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}
