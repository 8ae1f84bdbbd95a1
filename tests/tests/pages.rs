//! Pages of the documentation that the program makes are those of this program.

use std::path::Path;

use formation::scenario::SECTIONS;
use orchestrator::cli::reference;
use orchestrator::show::glossary::glossary;
use orchestrator::show::schema::{page, schema};
use serde_json::Value;

/// Compares a page with what the program makes now. With `PHALANX_WRITE_PAGES` set, writes it instead.
fn compare_page(name: &str, made: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name);
    if std::env::var_os("PHALANX_WRITE_PAGES").is_some() {
        std::fs::write(&path, made).expect("a page");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = made.lines().zip(found.lines()).find(|(made, found)| made != found);
    assert!(
        found == made,
        "docs/{name} is out of date, first here: {differs:?}; PHALANX_WRITE_PAGES=1 cargo test --release -p tests --test pages"
    );
}

#[test]
fn the_page_of_commands_is_up_to_date() {
    compare_page("commands.md", &reference());
}

#[test]
fn the_page_of_fields_is_up_to_date() {
    compare_page("scenario-fields.md", &page(&thesis::catalog(schemes::ROLES, schemes::SCENARIOS)));
}

#[test]
fn the_page_of_metrics_is_up_to_date() {
    compare_page("metrics.md", &glossary(&thesis::catalog(schemes::ROLES, schemes::SCENARIOS)));
}

#[test]
fn every_key_of_a_file_is_described() {
    let schema = schema(&thesis::catalog(schemes::ROLES, schemes::SCENARIOS));
    for name in SECTIONS.iter() {
        assert!(schema["properties"][name].is_object(), "{name}");
    }
    let lacking: Vec<String> = undescribed(&schema["properties"], "");
    assert!(lacking.is_empty(), "fields without a description: {lacking:?}");
}

/// Fields of sections and components without a description.
fn undescribed(properties: &Value, path: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (name, schema) in properties.as_object().into_iter().flatten() {
        let path = format!("{path}.{name}");
        if name == "variants" {
            continue;
        }
        if schema.get("description").is_none() && schema.get("oneOf").is_none() && name != "kind" {
            found.push(path.clone());
        }
        for inner in [&schema["properties"], &schema["items"]["properties"]] {
            found.extend(undescribed(inner, &path));
        }
        for option in schema["oneOf"].as_array().into_iter().flatten() {
            found.extend(undescribed(
                &option["properties"],
                &format!("{path}({})", option["title"].as_str().unwrap_or("")),
            ));
        }
    }
    found
}
