//! The libraries of the workspace, with links to what `cargo doc` has made of them.

use std::fmt::Write;

use crate::repository;

/// The crates with a library, in the order in which they build on each other, each with the first sentence of its documentation.
pub fn list() -> String {
    let text = std::fs::read_to_string(repository("Cargo.toml")).expect("Cargo.toml");
    let manifest: toml::Table = toml::from_str(&text).expect("TOML");
    let members = manifest["workspace"]["members"].as_array().expect("members").iter().filter_map(toml::Value::as_str);
    let mut list = String::from("| crate | what it is |\n|---|---|\n");
    let mut missing = false;
    for member in members {
        let Some(sentence) = first_sentence(member) else { continue };
        let name = member.rsplit('/').next().expect("a name");
        if repository(&format!("target/doc/{name}/index.html")).is_file() {
            writeln!(list, "| [`{name}`](api/rust/{name}/index.html) | {sentence} |").expect("a text grows");
        } else {
            missing = true;
            writeln!(list, "| `{name}` | {sentence} |").expect("a text grows");
        }
    }
    if missing {
        list.push_str(
            "\nThis copy of the book was built without `cargo doc`, so crates without a link have no pages in it.\n",
        );
    }
    list
}

/// The first sentence of the documentation of a library; `None` of what has no library, or is a test.
fn first_sentence(member: &str) -> Option<String> {
    if ["tests", "tests/golden", "benches", "capi"].contains(&member) {
        return None;
    }
    let text = std::fs::read_to_string(repository(member).join("src/lib.rs")).ok()?;
    let lines = text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim);
    let paragraph = lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    Some(paragraph)
}
