//! The graph among some of the agents of a file.

use crate::config::{Node, Table, Value};

/// Keeps of `count` agents those of `rows` (from 1), in this order: in the matrices, the lists of links, the leaders and the weights of
/// `[topology]`. Named graphs fit any number of agents.
pub(in crate::scenario) fn choose_agents(topology: &mut Node, count: usize, rows: &[usize]) {
    let mut numbers = vec![None; count];
    for (new, &row) in rows.iter().enumerate() {
        numbers[row - 1] = Some(new as i64 + 1);
    }
    let number = |node: &Node| match node.value {
        Value::Integer(old) => {
            let index = usize::try_from(old).ok().and_then(|old| old.checked_sub(1));
            // A number that the file does not have stays, so that it is found.
            index.and_then(|index| numbers.get(index)).map_or(Some(old), |new| *new)
        }
        _ => None,
    };
    let Some(table) = topology.as_table_mut() else { return };
    choose(table, count, rows, &number);
    let switches = table.get_mut("at").and_then(Node::as_array_mut);
    for switch in switches.into_iter().flatten().filter_map(Node::as_table_mut) {
        choose(switch, count, rows, &number);
    }
}

fn choose(table: &mut Table, count: usize, rows: &[usize], number: &impl Fn(&Node) -> Option<i64>) {
    let pick = |nodes: &mut Vec<Node>| {
        if nodes.len() == count {
            *nodes = rows.iter().map(|row| nodes[row - 1].clone()).collect();
        }
    };
    if let Some(adjacency) = table.get_mut("A").and_then(Node::as_array_mut) {
        pick(adjacency);
        adjacency.iter_mut().filter_map(Node::as_array_mut).for_each(pick);
    }
    if let Some(weights) = table.get_mut("b").and_then(Node::as_array_mut) {
        pick(weights);
    }
    let renumber = |node: &mut Node| match number(node) {
        Some(new) => {
            node.value = Value::Integer(new);
            true
        }
        None => node.as_i64().is_none(),
    };
    if let Some(leaders) = table.get_mut("leaders").and_then(Node::as_array_mut) {
        leaders.retain_mut(renumber);
    }
    if let Some(links) = table.get_mut("graph").and_then(|graph| graph.at_mut("links")).and_then(Node::as_array_mut) {
        links.retain_mut(|link| link.as_array_mut().is_none_or(|link| link.iter_mut().take(2).all(renumber)));
    }
}
