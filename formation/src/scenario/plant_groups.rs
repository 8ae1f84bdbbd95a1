//! Plants of some agents that are one participant: `plant.groups`, and what swaps of plants make of it.

use super::run_sections::read_swaps;
use super::{Selection, Served, SwapTarget};
use crate::config::{Node, Problems, Value, read};
use crate::role::Role;

/// Makes plants that something else plays participants by themselves.
pub(super) fn split_plant(root: &mut Node, selection: &Selection) {
    let count = root.at("agents").and_then(Node::as_array).map_or(0, <[Node]>::len);
    let of_file = read_swaps(root, &mut Problems::default());
    let names = of_file.iter().map(|(name, _)| name).chain(&selection.swapped_plants).map(String::as_str);
    let Some(groups) = plant_groups(&names.collect::<Vec<_>>(), count) else { return };
    let Some(plant) = root.at_mut("plant").and_then(Node::as_table_mut) else { return };
    let origin = "plant.groups";
    if !groups.is_empty() {
        let number = |agent: &usize| Node::from_override(Value::Integer(*agent as i64), origin);
        let list = |group: &Vec<usize>| Node::from_override(Value::Array(group.iter().map(number).collect()), origin);
        plant.insert("groups", Node::from_override(Value::Array(groups.iter().map(list).collect()), origin));
    }
    plant.insert("per_agent", Node::from_override(Value::Bool(true), "plant.per_agent"));
}

/// `plant.groups`: agents (from 0) whose plants are one participant.
pub(super) fn read_plant_groups(root: &Node, problems: &mut Problems) -> Vec<Vec<usize>> {
    let Some(node) = root.at("plant.groups") else { return Vec::new() };
    let count = root.at("agents").and_then(Node::as_array).map_or(0, <[Node]>::len);
    let mut groups = read::<Vec<Vec<usize>>>(node, "plant.groups", problems).unwrap_or_default();
    let mut seen = vec![false; count + 1];
    for agent in groups.iter_mut().flatten() {
        if *agent == 0 || *agent > count || std::mem::replace(&mut seen[*agent], true) {
            let message = format!("expected agents from 1 to {count}, each once, found {agent}");
            problems.at(root, "plant.groups", message);
            return Vec::new();
        }
        *agent -= 1;
    }
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups
}

/// The agents (from 1) whose plants are one participant because they are played so, by group of several; `None` if the plant of
/// all agents stays one participant. `names` are what is swapped, and `count` is the number of agents.
///
/// A list of agents is one group, without those that are named by themselves; the plant without a number is the group of the rest.
fn plant_groups(names: &[&str], count: usize) -> Option<Vec<Vec<usize>>> {
    let targets = names.iter().filter_map(|name| SwapTarget::parse(name)).filter(|target| target.role == Role::Plant);
    let (mut owner, mut lists) = (vec![None; count + 1], 0);
    let (mut is_split, mut is_whole) = (false, false);
    let mut singles = Vec::new();
    for target in targets {
        match target.whom {
            Served::Role => is_whole = true,
            Served::Each => is_split = true,
            Served::Agents(agents) => {
                if let [agent] = agents[..] {
                    singles.push(agent);
                } else {
                    lists += 1;
                    agents.iter().filter(|&&agent| agent <= count).for_each(|&agent| owner[agent] = Some(lists));
                }
            }
        }
    }
    if !is_split && singles.is_empty() && lists == 0 {
        return None;
    }
    singles.iter().filter(|&&agent| agent <= count).for_each(|&agent| owner[agent] = Some(0));
    if is_whole && !is_split {
        lists += 1;
        owner.iter_mut().skip(1).filter(|owner| owner.is_none()).for_each(|owner| *owner = Some(lists));
    }
    let group = |list: usize| (1..=count).filter(|&agent| owner[agent] == Some(list)).collect::<Vec<_>>();
    let groups: Vec<Vec<usize>> = (1..=lists).map(group).filter(|group| group.len() > 1).collect();
    if groups.iter().any(|group| group.len() == count) { None } else { Some(groups) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plants_are_grouped_as_they_are_played() {
        let groups = |names: &[&str]| plant_groups(names, 6);
        assert_eq!(groups(&["plant", "controller.2"]), None);
        assert_eq!(groups(&["plant.2"]), Some(vec![]));
        assert_eq!(groups(&["plant.*"]), Some(vec![]));
        assert_eq!(groups(&["plant.1,3-6", "plant.2"]), Some(vec![vec![1, 3, 4, 5, 6]]));
        assert_eq!(groups(&["plant.1-6", "plant.2"]), Some(vec![vec![1, 3, 4, 5, 6]]));
        assert_eq!(groups(&["plant.2", "plant"]), Some(vec![vec![1, 3, 4, 5, 6]]));
        assert_eq!(groups(&["plant.1,2", "plant.3,4"]), Some(vec![vec![1, 2], vec![3, 4]]));
        assert_eq!(groups(&["plant.1-6"]), None);
    }
}
