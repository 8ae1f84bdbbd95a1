use std::collections::BTreeMap;

use proptest::prelude::*;
use serde::Deserialize;

use super::*;

fn leaf() -> impl Strategy<Value = Value> {
    prop_oneof![
        any::<bool>().prop_map(Value::Bool),
        any::<i64>().prop_map(Value::Integer),
        any::<u64>().prop_map(|bits| Value::Float(f64::from_bits(bits))),
        prop::sample::select(vec![0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 1e16, 5e-324])
            .prop_map(Value::Float),
        any::<String>().prop_map(Value::String),
    ]
}

fn node(value: Value) -> Node {
    Node::from_override(value, "")
}

fn table(entries: Vec<(String, Value)>) -> Value {
    let mut table = Table::default();
    for (key, value) in entries {
        table.insert(key, node(value));
    }
    Value::Table(table)
}

fn key() -> impl Strategy<Value = String> {
    prop_oneof!["[a-z_]{1,4}", "[0-9]{1,2}", any::<String>()]
}

fn tree() -> impl Strategy<Value = Value> {
    leaf().prop_recursive(4, 64, 8, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..8)
                .prop_map(|values| Value::Array(values.into_iter().map(node).collect())),
            prop::collection::vec((key(), inner), 0..8).prop_map(table),
        ]
    })
}

fn scenario() -> impl Strategy<Value = Node> {
    prop::collection::vec((key(), tree()), 0..8).prop_map(|entries| node(table(entries)))
}

/// Text that is nearly TOML.
fn nearly_toml() -> impl Strategy<Value = String> {
    let pieces =
        ["a", "b.c", "=", "\n", "[", "]", "{", "}", ",", ".", "\"", "'", "1", "-0.5e9", "true", "#", " ", "\\u", "ä"];
    prop::collection::vec(prop::sample::select(pieces.to_vec()), 0..40).prop_map(|pieces| pieces.concat())
}

#[derive(Debug, Deserialize)]
#[allow(dead_code)]
struct Sample {
    a: f64,
    b: BTreeMap<String, [u8; 2]>,
    c: Option<PerAgent>,
    d: Choice,
}

#[derive(Debug, Deserialize)]
#[allow(dead_code)]
enum Choice {
    One,
    Two { a: Vec<String> },
    Three(Box<Choice>),
}

proptest! {
    #[test]
    fn written_scenarios_parse_to_the_same_tree(scenario in scenario()) {
        let text = scenario.to_toml();
        match Node::parse(source(&text)) {
            Ok(again) => prop_assert_eq!(scenario, again, "{}", text),
            Err(problem) => prop_assert!(false, "{}\n{}", problem, text),
        }
    }

    #[test]
    fn no_text_panics(text in prop_oneof![any::<String>(), nearly_toml()], path: String) {
        let problem = match Node::parse(source(&text)) {
            Err(problem) => problem.to_string(),
            Ok(mut node) => {
                let _ = node.set(&path, &text, &Origin::argument("--set"));
                let mut problems = Problems::default();
                read::<Sample>(&node, "", &mut problems);
                problems.at(&node, &path, "");
                problems.to_string()
            }
        };
        prop_assert!(!problem.is_empty());
    }

    #[test]
    fn no_tree_panics(mut scenario in scenario(), overlay in scenario(), path in "[a-z.0-9\\[\\]*\"]{0,9}", text: String) {
        let _ = scenario.overlay(overlay);
        let _ = scenario.set(&path, &text, &Origin::argument("--set"));
        let mut problems = Problems::default();
        let read = read::<Sample>(&scenario, "", &mut problems);
        prop_assert_eq!(read.is_none(), !problems.is_empty());
    }

    #[test]
    fn choices_are_read_or_refused(value in tree()) {
        let mut problems = Problems::default();
        let read = read::<Choice>(&node(value), "", &mut problems);
        prop_assert_eq!(read.is_none(), !problems.is_empty());
    }

    #[test]
    fn set_then_at_agree(key in key(), value: i64) {
        let path = super::super::path::join("", &key);
        let mut root = parsed("");
        root.set(&path, &value.to_string(), &Origin::argument("--set")).unwrap();
        prop_assert_eq!(root.at(&path).and_then(Node::as_i64), Some(value));
    }
}
