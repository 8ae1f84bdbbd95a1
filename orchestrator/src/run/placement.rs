//! How participants are spread over processes.

use std::collections::BTreeMap;

use formation::wiring::Assembly;
use lockstep::WorkerPlan;

use crate::run::swap::Swap;

/// How the participants are spread over processes. It changes no bit of what comes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Placement {
    /// Every participant is a process of its own
    Processes,
    /// Observer and controller of an agent share a process
    Agents,
    /// As the scenario's `[placement] groups` say; a participant in no group runs in its own process
    Groups,
    /// All participants run in this process, without a system call in a step; those that are swapped are processes beside one
    /// that runs all others
    Single,
}

impl Placement {
    /// The default placement of a scenario: its groups, or a process per participant.
    pub fn default_of(assembly: &Assembly) -> Self {
        if assembly.scenario.groups.is_empty() { Self::Processes } else { Self::Groups }
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Processes => "processes",
            Self::Agents => "agents",
            Self::Groups => "groups",
            Self::Single => "single",
        }
    }

    /// The processes, and the nodes that each hosts.
    pub fn workers(self, assembly: &Assembly, swaps: &[Swap]) -> Vec<WorkerPlan> {
        let groups = assembly.scenario.groups.iter().enumerate();
        // Backwards, so that the first group that names a participant counts.
        let group_of: BTreeMap<&String, usize> =
            groups.rev().flat_map(|(group, names)| names.iter().map(move |name| (name, group))).collect();
        let mut workers: Vec<WorkerPlan> = Vec::new();
        let mut places: BTreeMap<String, usize> = BTreeMap::new();
        for (index, node) in assembly.network.nodes.iter().enumerate() {
            // Sensors, actuators and links have no agents, and are one process together.
            let agents = assembly.nodes.get(index).map(|place| place.agents.as_slice());
            let swapped = swaps.iter().find(|swap| swap.node == node.name);
            // The process of several is called like the first of them.
            let first = swapped.and_then(|swap| swap.shared).and_then(|shared| {
                let name = |node: &&lockstep::Node| {
                    swaps.iter().any(|swap| swap.node == node.name && swap.shared == Some(shared))
                };
                assembly.network.nodes.iter().find(name)
            });
            let group = group_of.get(&node.name);
            let name = match (self, agents.unwrap_or_default(), group) {
                _ if swapped.is_some() => first.unwrap_or(node).name.clone(),
                (Self::Single, ..) => "all".to_string(),
                (Self::Agents, [agent], _) if node.name.contains('_') => format!("agent_{}", agent + 1),
                (Self::Groups, _, Some(group)) => format!("group_{}", group + 1),
                _ if agents.is_none() => "effects".to_string(),
                _ => node.name.clone(),
            };
            let place = *places.entry(name).or_insert_with_key(|name| {
                workers.push(WorkerPlan { name: name.clone(), nodes: Vec::new() });
                workers.len() - 1
            });
            workers[place].nodes.push(index);
        }
        workers
    }
}
