//! Scenario files and the schema that `phalanx schema` prints for editors.

use std::path::PathBuf;
use std::process::Command;

use serde_json::{Value, json};

use crate::repository;

/// The program: the one that the variable PHALANX names, or the one in target/release.
pub fn program() -> PathBuf {
    std::env::var_os("PHALANX").map_or_else(|| repository("target/release/phalanx"), PathBuf::from)
}

/// The schema that the program prints.
pub fn schema() -> Value {
    let program = program();
    let output = Command::new(&program).arg("schema").output();
    let output = output.unwrap_or_else(|error| panic!("{}: {error}; build it first", program.display()));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// What the schema says about a scenario, or about a part of one.
pub fn complaint(schema: &Value, scenario: &toml::Table) -> Option<String> {
    let schema = if scenario.contains_key("name") {
        schema.clone()
    } else {
        json!({ "$schema": schema["$schema"], "allOf": [schema["properties"]["variants"]["additionalProperties"]] })
    };
    let mut compiler = boon::Compiler::new();
    compiler.add_resource("schema.json", schema).expect("a schema");
    let mut schemas = boon::Schemas::new();
    let index = compiler.compile("schema.json", &mut schemas).unwrap_or_else(|error| panic!("{error:#}"));
    let scenario: Value = serde_json::to_value(scenario).expect("JSON");
    schemas.validate(&scenario, index).err().map(|error| format!("{error:#}"))
}
