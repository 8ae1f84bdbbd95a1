use super::*;

#[test]
fn the_page_of_fields_is_up_to_date() {
    compare_page("scenario-fields.md", &page());
}

#[test]
fn every_key_of_a_file_is_described() {
    for name in SECTIONS {
        assert!(schema()["properties"][name].is_object(), "{name}");
    }
    let lacking: Vec<String> = undescribed(&schema()["properties"], "");
    assert!(lacking.is_empty(), "fields without a description: {lacking:?}");
}

/// Fields of sections and components that nobody has described.
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
