//! Every field of a scenario file as a page of the documentation.

use std::fmt::Write;

use serde_json::Value;

use super::{Role, properties};
use crate::catalog::Catalog;

/// The page, Markdown.
pub fn page(catalog: &Catalog) -> String {
    let mut page = String::from(
        "# Every field of a scenario\n\nMade from the types that read the file, like `phalanx schema`; a number may be a formula \
         of constants, such as `\"pi/4\"`.\nWhat the sections are for is told in [Scenario files](scenarios.md).\n\n## Top level\n",
    );
    let properties = properties(catalog);
    let role = |name: &str| Role::ALL.into_iter().any(|role| role.name() == name);
    let plain = |schema: &Value| schema.get("properties").is_none() && schema["items"].get("properties").is_none();
    let single = properties.iter().filter(|(name, schema)| !role(name) && plain(schema));
    table(&mut page, single.map(|(name, schema)| (name.as_str(), schema, None)));
    for (name, schema) in properties.iter().filter(|(name, schema)| !role(name) && !plain(schema)) {
        let (heading, fields) = match schema.get("items") {
            Some(items) => (format!("`{name}`: a list of tables"), items),
            None => (format!("`[{name}]`"), schema),
        };
        let _ = write!(page, "\n## {heading}\n\n{}\n", text(schema));
        fields_of(&mut page, fields, &[]);
    }
    for role in Role::ALL {
        let _ = write!(page, "\n## `[{role}]`\n\nBesides the parameters of its component:\n");
        let options = properties[role.name()]["oneOf"].as_array().cloned().unwrap_or_default();
        let common = ["every", "offset", "per_agent", "groups", "with"];
        if let Some(first) = options.first() {
            let shared = first["properties"].as_object().into_iter().flatten();
            let shared = shared.filter(|(name, _)| common.contains(&name.as_str()));
            table(&mut page, shared.map(|(name, schema)| (name.as_str(), schema, Some(false))));
        }
        for option in &options {
            let kind = option["title"].as_str().unwrap_or_default();
            let _ = write!(page, "\n### `kind = \"{kind}\"`\n\n{}\n", text(option));
            fields_of(&mut page, option, &["kind", "every", "offset", "per_agent", "groups", "with"]);
        }
    }
    page
}

/// The fields of a table, and below it those of the tables in it.
fn fields_of(page: &mut String, schema: &Value, without: &[&str]) {
    let fields: Vec<(&String, &Value)> = schema["properties"].as_object().into_iter().flatten().collect();
    let fields: Vec<_> = fields.into_iter().filter(|(name, _)| !without.contains(&name.as_str())).collect();
    if fields.is_empty() {
        return;
    }
    let required =
        |name: &str| schema["required"].as_array().is_some_and(|names| names.iter().any(|known| known == name));
    table(page, fields.iter().map(|(name, schema)| (name.as_str(), *schema, Some(required(name)))));
    for (name, inner) in fields.iter().filter(|(_, inner)| inner.get("properties").is_some()) {
        let _ = write!(page, "\nThe table `{name}`:\n");
        fields_of(page, inner, &[]);
    }
}

/// A table of fields; whether they must be there, if that is known.
fn table<'a>(page: &mut String, fields: impl Iterator<Item = (&'a str, &'a Value, Option<bool>)>) {
    page.push_str("\n| field | value | default | meaning |\n|---|---|---|---|\n");
    for (name, schema, required) in fields {
        let default = match (schema.get("default"), required) {
            (Some(default), _) => format!("`{default}`"),
            (None, Some(true)) => "required".into(),
            (None, _) => String::new(),
        };
        let _ = writeln!(page, "| `{name}` | {} | {default} | {} |", value(schema), text(schema).replace('|', "\\|"));
    }
}

fn text(schema: &Value) -> &str {
    schema["description"].as_str().unwrap_or_default()
}

/// What stands at the right of the equals sign, in words.
fn value(schema: &Value) -> String {
    let quoted = |value: &Value| format!("`{value}`");
    if let Some(values) = schema["enum"].as_array() {
        return values.iter().map(quoted).collect::<Vec<_>>().join(", ");
    }
    if let Some(constant) = schema.get("const") {
        return quoted(constant);
    }
    if let Some(options) = schema["oneOf"].as_array().or(schema["anyOf"].as_array()) {
        let options = options.iter().map(|option| match option["title"].as_str() {
            Some(kind) if option.get("properties").is_some() => format!("table with `kind = \"{kind}\"`"),
            _ => value(option),
        });
        let mut options: Vec<String> = options.collect();
        options.dedup();
        return options.join(", ");
    }
    let kind = match &schema["type"] {
        Value::Array(kinds) => kinds.first().and_then(Value::as_str),
        kind => kind.as_str(),
    };
    match kind.unwrap_or_default() {
        "integer" => "whole number".into(),
        "boolean" => "`true`, `false`".into(),
        "array" => format!("list of: {}", value(&schema["items"])),
        "object" => "table".into(),
        "string" => "text".into(),
        other => other.into(),
    }
}
