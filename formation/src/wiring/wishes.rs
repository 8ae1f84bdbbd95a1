//! What a scenario says about single participants by name: `[edges]`, `[placement]`, `[on_failure]` and `[swap]`.

use lockstep::{Network, Timing};

use crate::config::{Problem, nearest};
use crate::scenario::Scenario;

/// Sets the timing of the edges that `[edges]` names, such as `"observer_1 <- plant" = "delayed"`. A name without a number
/// stands for all participants of its role.
pub(super) fn apply_edges(scenario: &Scenario, network: &mut Network) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    let writers = network.writers();
    let names: Vec<String> = network.nodes.iter().map(|node| node.name.clone()).collect();
    for (edge, timing) in &scenario.edges {
        let mut report = |message: String| problems.push(scenario.problem("edges", format!("{edge}: {message}")));
        let Some((reader, writer)) = edge.split_once("<-") else {
            report("expected READER <- WRITER, such as \"observer_1 <- plant\"".into());
            continue;
        };
        let ends = [reader, writer].map(|name| matching(name.trim(), &names));
        let [Ok(readers), Ok(sources)] = ends else {
            ends.into_iter().filter_map(Result::err).for_each(report);
            continue;
        };
        let mut found = false;
        for &reader in &readers {
            for input in &mut network.nodes[reader].inputs {
                if writers[input.channel.0].is_some_and(|writer| sources.contains(&writer)) {
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

/// The nodes that a name means.
fn matching(name: &str, names: &[String]) -> Result<Vec<usize>, String> {
    let is_meant = |node: &String| *node == name || node.strip_prefix(name).is_some_and(|rest| rest.starts_with('_'));
    let found: Vec<usize> = (0..names.len()).filter(|&node| is_meant(&names[node])).collect();
    if found.is_empty() { Err(unknown(name, names)) } else { Ok(found) }
}

fn unknown(name: &str, names: &[String]) -> String {
    let hint = nearest(name, names.iter().map(String::as_str)).map(|near| format!("; did you mean `{near}`?"));
    format!("no participant is called `{name}`, expected one of {}{}", names.join(", "), hint.unwrap_or_default())
}

/// Whether every participant that `[placement] groups` names is there, and in one group only.
pub(super) fn check_groups(scenario: &Scenario, network: &Network) -> Result<(), Vec<Problem>> {
    let names: Vec<String> = network.nodes.iter().map(|node| node.name.clone()).collect();
    let mut problems = Vec::new();
    let mut seen: Vec<&String> = Vec::new();
    for name in scenario.groups.iter().flatten() {
        let mut report = |message| problems.push(scenario.problem("placement.groups", message));
        if !names.contains(name) {
            report(unknown(name, &names));
        } else if seen.contains(&name) {
            report(format!("`{name}` is in two groups"));
        }
        seen.push(name);
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// Whether every participant or role that `[on_failure]` names is there.
pub(super) fn check_failure_policy(scenario: &Scenario, network: &Network) -> Result<(), Vec<Problem>> {
    let names: Vec<String> = network.nodes.iter().map(|node| node.name.clone()).collect();
    let unmatched = scenario.on_failure.participants.iter().filter_map(|(name, _)| matching(name, &names).err());
    let problems: Vec<Problem> = unmatched.map(|message| scenario.problem("on_failure", message)).collect();
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// Whether every participant that `[swap]` names is there, and once only.
pub(super) fn check_swaps(scenario: &Scenario, network: &Network) -> Result<(), Vec<Problem>> {
    let names: Vec<String> = network.nodes.iter().map(|node| node.name.clone()).collect();
    let mut problems = Vec::new();
    for (index, (name, _)) in scenario.swaps.iter().enumerate() {
        let mut report = |message| problems.push(scenario.problem("swap", message));
        if !names.contains(name) {
            report(unknown(name, &names));
        } else if scenario.swaps[..index].iter().any(|(other, _)| other == name) {
            report(format!("`{name}` is swapped twice"));
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// What a scenario file calls a timing.
pub(crate) fn timing_of(word: &str) -> Option<Timing> {
    match word {
        "same_step" => Some(Timing::SameStep),
        "delayed" => Some(Timing::Delayed),
        _ => None,
    }
}
