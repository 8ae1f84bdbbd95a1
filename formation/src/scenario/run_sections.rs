//! The sections `[edges]`, `[placement]` and `[swap]`, as far as they can be read without knowing the participants.

use lockstep::Timing;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::config::{Node, Problems, read};

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

/// Participants and what plays them: `"controller.1" = "replay:LOG.mcap"`, or the same in a table `controller`.
pub(super) fn read_swaps(root: &Node, problems: &mut Problems) -> Vec<(String, String)> {
    let mut swaps = Vec::new();
    let Some(node) = root.at("swap") else { return swaps };
    let Some(table) = node.as_table() else {
        problems.at(root, "swap", "expected a table such as { \"controller.3\" = \"./my_controller\" }");
        return swaps;
    };
    for (name, node) in table.iter() {
        let agents = node.as_table().into_iter().flat_map(|agents| agents.iter());
        let agents = agents.map(|(agent, node)| (format!("{name}.{agent}"), node));
        let players = if node.as_table().is_some() { agents.collect() } else { vec![(name.to_string(), node)] };
        for (name, node) in players {
            match node.as_str() {
                Some(player) => swaps.push((name, player.to_string())),
                None => {
                    let message =
                        format!("{name}: expected a command or \"replay:LOG.mcap\", found {}", node.describe());
                    problems.at(root, "swap", message);
                }
            }
        }
    }
    swaps
}

/// What a scenario file calls a timing.
pub(crate) fn timing_of(word: &str) -> Option<Timing> {
    match word {
        "same_step" => Some(Timing::SameStep),
        "delayed" => Some(Timing::Delayed),
        _ => None,
    }
}
