//! The sections `[edges]`, `[placement]` and `[swap]`, as far as they can be read without knowing the participants.

use lockstep::Timing;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::config::{Node, Problems, read};
use crate::wiring::timing_of;

/// `[placement]`: which participants share a process. It changes no bit of the result.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PlacementSection {
    /// Names of participants, process by process; who is in none has a process of its own.
    #[serde(default)]
    groups: Vec<Vec<String>>,
}

/// Names of participants that share a process, by process.
pub(super) fn read_groups(root: &Node, problems: &mut Problems) -> Vec<Vec<String>> {
    let section = root.at("placement").and_then(|node| read::<PlacementSection>(node, "placement", problems));
    section.map(|section| section.groups).unwrap_or_default()
}

/// Edges, `reader <- writer`, with the timing that they are to have.
pub(super) fn read_edges(root: &Node, problems: &mut Problems) -> Vec<(String, Timing)> {
    let Some(node) = root.at("edges") else { return Vec::new() };
    let Some(table) = node.as_table() else {
        problems.at(root, "edges", "expected a table such as { \"observer_1 <- plant\" = \"delayed\" }");
        return Vec::new();
    };
    let mut edges = Vec::new();
    for (edge, node) in table.iter() {
        match node.as_str().and_then(timing_of) {
            Some(timing) => edges.push((edge.to_string(), timing)),
            None => {
                let message = format!("{edge}: expected \"same_step\" or \"delayed\", found {}", node.describe());
                problems.at(root, "edges", message);
            }
        }
    }
    edges
}

/// Names of participants, and what plays them.
pub(super) fn read_swaps(root: &Node, problems: &mut Problems) -> Vec<(String, String)> {
    let Some(node) = root.at("swap") else { return Vec::new() };
    let mut swaps = Vec::new();
    for (name, player) in node.as_table().into_iter().flat_map(|table| table.iter()) {
        match player.as_str() {
            Some(player) => swaps.push((name.to_string(), player.to_string())),
            None => _ = problems.at(root, "swap", format!("{name}: expected a text, found {}", player.describe())),
        }
    }
    if node.as_table().is_none() {
        problems.at(root, "swap", "expected a table such as { \"plant.2\" = \"hardware:robot2.toml\" }");
    }
    swaps
}
