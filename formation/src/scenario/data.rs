//! `[data]`: which data files are meant.

use std::collections::BTreeMap;

use crate::config::{Node, Problem, Problems, Table, Value};
use crate::data::DataFile;

const SECTION: &str = "data";

/// The SHA-256 that the scenario gives for data files, by their paths.
pub(super) fn read_digests(root: &Node, problems: &mut Problems) -> BTreeMap<String, String> {
    let mut digests = BTreeMap::new();
    let Some(node) = root.at(SECTION) else { return digests };
    let expected = "a file in quotes and its SHA-256, 64 hexadecimal digits in lower case";
    let Some(table) = node.as_table() else {
        problems.at(root, SECTION, format!("expected a table of {expected}, found {}", node.describe()));
        return digests;
    };
    for (path, node) in table.iter() {
        let is_digit = |byte: u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
        match node.as_str().filter(|digest| digest.len() == 64 && digest.bytes().all(is_digit)) {
            Some(digest) => _ = digests.insert(path.to_string(), digest.to_string()),
            None => {
                let message = format!("expected {expected}, found {}", node.describe());
                problems.push(Problem::new(Some(node.origin.clone()), format!("{SECTION}.{path}"), message));
            }
        }
    }
    digests
}

/// The scenario with exactly the files that were read, so that its text says what is in them.
pub(super) fn with_digests(mut root: Node, files: &[DataFile]) -> Node {
    let Some(all) = root.as_table_mut() else { return root };
    all.remove(SECTION);
    if !files.is_empty() {
        let mut table = Table::default();
        for file in files {
            table.insert(file.path.as_str(), Node::from_override(Value::String(file.digest.clone()), SECTION));
        }
        all.insert(SECTION, Node::from_override(Value::Table(table), SECTION));
    }
    root
}
