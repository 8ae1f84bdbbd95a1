use std::sync::Arc;

use serde::de::DeserializeOwned;

use super::*;

mod editing;
mod messages;
mod properties;
mod reading;

fn source(text: &str) -> Arc<Source> {
    Arc::new(Source { name: "a.toml".into(), text: text.into() })
}

fn parsed(text: &str) -> Node {
    Node::parse(source(text)).unwrap_or_else(|problem| panic!("{problem}"))
}

/// Why the text does not parse.
fn refused(text: &str) -> String {
    Node::parse(source(text)).unwrap_err().to_string()
}

/// What is said about the text when it is read as a `T`.
fn problems_of<T: DeserializeOwned>(text: &str) -> Vec<Problem> {
    let mut problems = Problems::default();
    let value = read::<T>(&parsed(text), "", &mut problems);
    assert_eq!(value.is_some(), problems.is_empty());
    problems.into_vec()
}

/// The only thing that is said: its field, message and hint.
fn only<T: DeserializeOwned>(text: &str) -> String {
    let problems = problems_of::<T>(text);
    assert_eq!(problems.len(), 1, "{problems:#?}");
    let Problem { path, message, help, .. } = &problems[0];
    help.iter().fold(format!("{path}: {message}"), |text, help| format!("{text} | {help}"))
}

fn value_of<T: DeserializeOwned>(text: &str) -> T {
    let mut problems = Problems::default();
    read(&parsed(text), "", &mut problems).unwrap_or_else(|| panic!("{problems}"))
}
