//! What a scenario says about single participants by name: `[edges]`, `[placement]`, `[on_failure]` and `[swap]`.

use std::collections::{BTreeMap, BTreeSet};

use lockstep::Network;

use super::node_role::NodeRole;
use super::swapped::resolve;
use crate::config::{Problem, did_you_mean};
use crate::scenario::Scenario;

/// Sets the timing of the edges that `[edges]` names, such as `"observer_1 <- plant" = "delayed"`. A name without a number
/// stands for all participants of its role.
pub(super) fn apply_edges(scenario: &Scenario, network: &mut Network) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    let writers = network.writers();
    let names = Names::of(network);
    for (edge, timing) in &scenario.edges {
        let mut report = |message: String| problems.push(scenario.problem("edges", format!("{edge}: {message}")));
        let Some((reader, writer)) = edge.split_once("<-") else {
            report("expected READER <- WRITER, such as \"observer_1 <- plant\"".into());
            continue;
        };
        let ends = [reader, writer].map(|name| names.matching(name.trim()));
        let [Ok(readers), Ok(sources)] = ends else {
            ends.into_iter().filter_map(Result::err).for_each(report);
            continue;
        };
        let mut is_source = vec![false; network.nodes.len()];
        sources.iter().for_each(|&source| is_source[source] = true);
        let mut found = false;
        for &reader in &readers {
            for input in &mut network.nodes[reader].inputs {
                if writers[input.channel.0].is_some_and(|writer| is_source[writer]) {
                    input.timing = *timing;
                    found = true;
                }
            }
        }
        if !found {
            report(format!("{} reads nothing of {}; `phalanx graph` shows all edges", reader.trim(), writer.trim()));
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// The participants by name.
struct Names {
    /// In the order of the network.
    ordered: Vec<String>,
    /// The number of each.
    numbers: BTreeMap<String, usize>,
}

impl Names {
    fn of(network: &Network) -> Self {
        let ordered: Vec<String> = network.nodes.iter().map(|node| node.name.clone()).collect();
        let numbers = ordered.iter().cloned().zip(0..).collect();
        Self { ordered, numbers }
    }

    fn contains(&self, name: &str) -> bool {
        self.numbers.contains_key(name)
    }

    /// The nodes that a name means: the one that is called so, and those called so with a number behind.
    fn matching(&self, name: &str) -> Result<Vec<usize>, String> {
        let stem = format!("{name}_");
        let numbered = self.numbers.range(stem.clone()..).take_while(|(node, _)| node.starts_with(&stem));
        let mut found: Vec<usize> =
            self.numbers.get(name).into_iter().chain(numbered.map(|(_, n)| n)).copied().collect();
        found.sort_unstable();
        if found.is_empty() { Err(self.unknown(name)) } else { Ok(found) }
    }

    fn unknown(&self, name: &str) -> String {
        let hint = did_you_mean(name, self.ordered.iter().map(String::as_str));
        format!("no participant is called `{name}`, expected one of {}{hint}", self.ordered.join(", "))
    }
}

/// Whether every participant that `[placement] groups` names is there, and in one group only.
pub(super) fn check_groups(scenario: &Scenario, network: &Network) -> Result<(), Vec<Problem>> {
    let names = Names::of(network);
    let mut problems = Vec::new();
    let mut seen = BTreeSet::new();
    for name in scenario.groups.iter().flatten() {
        let mut report = |message| problems.push(scenario.problem("placement.groups", message));
        if !names.contains(name) {
            report(names.unknown(name));
        } else if !seen.insert(name) {
            report(format!("`{name}` is in two groups"));
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// Whether the participants that `[swap]` names are there, and none is named twice.
pub(super) fn check_swaps(scenario: &Scenario, network: &Network, nodes: &[NodeRole]) -> Result<(), Vec<Problem>> {
    let names: Vec<&str> = scenario.swaps.iter().map(|(name, _)| name.as_str()).collect();
    match resolve(network, nodes, &names) {
        Ok(_) => Ok(()),
        Err((number, reason)) => Err(vec![scenario.problem("swap", format!("{}: {reason}", names[number]))]),
    }
}

/// Whether every participant or role that `[on_failure]` names is there.
pub(super) fn check_failure_policy(scenario: &Scenario, network: &Network) -> Result<(), Vec<Problem>> {
    let names = Names::of(network);
    let unmatched = scenario.on_failure.participants.iter().filter_map(|(name, _)| names.matching(name).err());
    let problems: Vec<Problem> = unmatched.map(|message| scenario.problem("on_failure", message)).collect();
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}
