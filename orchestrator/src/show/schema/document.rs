//! From what the types say of themselves to what a scenario file may contain.

use serde_json::{Map, Value, json};

/// What types say, in terms of scenario files: a number may be a formula of constants, nothing is null, and an enum with data
/// is a table with a `kind`.
pub(super) fn tidy(schema: Value) -> Value {
    match schema {
        Value::Array(items) => items.into_iter().map(tidy).collect(),
        Value::Object(object) => tidy_object(object),
        other => other,
    }
}

fn tidy_object(object: Map<String, Value>) -> Value {
    let floating = matches!(object.get("format").and_then(Value::as_str), Some("double" | "float"));
    let mut tidied: Map<String, Value> = Map::new();
    for (key, value) in object {
        match key.as_str() {
            "format" => {}
            "title" if !value.is_string() => {}
            "type" => _ = tidied.insert(key, kinds(value, floating)),
            "default" if value.is_null() => {}
            // Doc comments are wrapped; an editor and a table do that themselves.
            "description" if value.is_string() => {
                let text = value.as_str().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
                tidied.insert(key, text.into());
            }
            "anyOf" => {
                let mut options: Vec<Value> = value.as_array().cloned().unwrap_or_default();
                options.retain(|option| option["type"] != "null");
                match <[Value; 1]>::try_from(options) {
                    Ok([only]) => {
                        if let Value::Object(only) = tidy(only) {
                            for (key, value) in only {
                                tidied.entry(key).or_insert(value);
                            }
                        }
                    }
                    Err(options) => _ = tidied.insert(key, options.into_iter().map(tidy).collect()),
                }
            }
            "oneOf" => {
                let options = value.as_array().cloned().unwrap_or_default();
                tidied.insert(key, options.into_iter().map(|option| tidy(tagged(option))).collect());
            }
            _ => _ = tidied.insert(key, tidy(value)),
        }
    }
    Value::Object(tidied)
}

/// The types that a value may have: no null, and a formula in the place of a number.
fn kinds(kinds: Value, floating: bool) -> Value {
    let mut kinds: Vec<Value> = match kinds {
        Value::Array(kinds) => kinds,
        // A property that is called `type` belongs to a component, not to the schema.
        Value::String(kind) => vec![kind.into()],
        other => return other,
    };
    kinds.retain(|kind| kind != "null");
    if floating {
        kinds.push(json!("string"));
    }
    match <[Value; 1]>::try_from(kinds) {
        Ok([only]) => only,
        Err(kinds) => kinds.into(),
    }
}

/// `{ variant = { field = 1 } }`, as serde has it, becomes `{ kind = "variant", field = 1 }`.
fn tagged(option: Value) -> Value {
    let only = option["properties"].as_object().filter(|properties| properties.len() == 1);
    let Some((name, inner)) = only.and_then(|properties| properties.iter().next()) else { return option };
    if option["required"] != json!([name]) || inner["type"] != "object" {
        return option;
    }
    let mut properties = Map::from_iter([("kind".to_string(), json!({ "const": name }))]);
    properties.extend(inner["properties"].as_object().cloned().unwrap_or_default());
    let mut required = vec![json!("kind")];
    required.extend(inner["required"].as_array().cloned().unwrap_or_default());
    let description = option.get("description").or_else(|| inner.get("description")).and_then(Value::as_str);
    json!({
        "type": "object",
        "title": name,
        "description": description.unwrap_or_default(),
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}
