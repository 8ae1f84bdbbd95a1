//! The schema of what is laid over a section: any part of it.

use serde_json::{Map, Value, json};

/// A schema for any part of what `schema` describes: nothing is required, elements of lists are found by their number, and
/// where one of several components is described, the parameters of all of them are known.
pub(super) fn relax(schema: &Value) -> Value {
    let Value::Object(object) = schema else { return schema.clone() };
    if let Some(options) = object.get("oneOf").and_then(Value::as_array)
        && options.iter().all(|option| option["properties"]["kind"]["const"].is_string())
    {
        return merged(options);
    }
    let mut relaxed: Map<String, Value> = Map::new();
    for (key, value) in object {
        match (key.as_str(), value) {
            ("required" | "minItems", _) => {}
            ("properties", Value::Object(properties)) => {
                let properties = properties.iter().map(|(name, schema)| (name.clone(), relax(schema)));
                relaxed.insert(key.clone(), Value::Object(properties.collect()));
            }
            ("additionalProperties" | "items", _) => _ = relaxed.insert(key.clone(), relax(value)),
            ("anyOf", Value::Array(options)) => _ = relaxed.insert(key.clone(), options.iter().map(relax).collect()),
            _ => _ = relaxed.insert(key.clone(), value.clone()),
        }
    }
    match object.get("items") {
        Some(items) if object.get("type") == Some(&json!("array")) => {
            let element = json!({
                "type": "object",
                "patternProperties": { "^[0-9]+$": relax(items) },
                "additionalProperties": false,
                "description": "Elements by their number, from 1.",
            });
            let description = relaxed.remove("description").map(|text| ("description".to_string(), text));
            let options = ("anyOf".to_string(), json!([schema, element]));
            Value::Object(Map::from_iter([options].into_iter().chain(description)))
        }
        _ => Value::Object(relaxed),
    }
}

/// One table with the keys of all options.
fn merged(options: &[Value]) -> Value {
    let kinds: Vec<&Value> = options.iter().map(|option| &option["properties"]["kind"]["const"]).collect();
    let mut found: Vec<(&String, Vec<Value>)> = Vec::new();
    for (name, schema) in options.iter().filter_map(|option| option["properties"].as_object()).flatten() {
        let schema = relax(schema);
        match found.iter_mut().find(|(known, _)| *known == name) {
            _ if name == "kind" => {}
            None => found.push((name, vec![schema])),
            Some((_, several)) if several.iter().any(|known| same(known, &schema)) => {}
            Some((_, several)) => several.push(schema),
        }
    }
    let mut properties: Map<String, Value> = Map::from_iter([("kind".to_string(), json!({ "enum": kinds }))]);
    properties.extend(found.into_iter().map(|(name, several)| match <[Value; 1]>::try_from(several) {
        Ok([only]) => (name.clone(), only),
        Err(several) => (name.clone(), json!({ "anyOf": several })),
    }));
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

/// Whether two schemas differ in words only.
fn same(a: &Value, b: &Value) -> bool {
    let bare = |schema: &Value| {
        let mut schema = schema.clone();
        if let Some(object) = schema.as_object_mut() {
            object.remove("description");
            object.remove("default");
        }
        schema
    };
    bare(a) == bare(b)
}
