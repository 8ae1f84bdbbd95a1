//! Which participants the names of `[swap]` and `--swap` mean.

use lockstep::Network;

use super::node_role::NodeRole;
use crate::config::did_you_mean;
use crate::scenario::{Served, SwapTarget};

/// A participant that something else plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Swapped {
    /// Number of its node.
    pub node: usize,
    /// Number of the name that counts for it.
    pub name: usize,
    /// Whether one process plays all participants of this name.
    pub together: bool,
}

/// The participants that `names` mean, in the order of the network. Of several names for one, the most exact counts, and of several
/// patterns the last.
///
/// # Errors
/// The number of a name that means none, or that names a participant twice, with the reason.
pub(super) fn resolve(network: &Network, nodes: &[NodeRole], names: &[&str]) -> Result<Vec<Swapped>, (usize, String)> {
    let mut found: Vec<Option<(u8, Swapped)>> = vec![None; nodes.len()];
    for (number, name) in names.iter().enumerate() {
        let (target, meant) = matching(network, nodes, name).map_err(|reason| (number, reason))?;
        let is_exact = meant.len() == 1 && target.whom != Served::Each;
        let exactness = if is_exact { 2 } else { target.exactness().min(1) };
        for node in meant {
            let swapped = Swapped { node, name: number, together: target.together };
            match found[node] {
                Some((2, _)) if exactness == 2 => {
                    return Err((number, format!("`{}` is swapped twice", network.nodes[node].name)));
                }
                Some((known, _)) if known > exactness => {}
                _ => found[node] = Some((exactness, swapped)),
            }
        }
    }
    Ok(found.into_iter().flatten().map(|(_, swapped)| swapped).collect())
}

/// The nodes that a name means.
fn matching(network: &Network, nodes: &[NodeRole], name: &str) -> Result<(SwapTarget, Vec<usize>), String> {
    let unknown = || {
        let known = || network.nodes.iter().map(|node| node.name.as_str());
        let hint = did_you_mean(&name.trim().replace('.', "_"), known());
        let list = known().collect::<Vec<_>>().join(", ");
        format!(
            "there is no such participant, expected one of {list}, or several, such as controller.* or controller.1,3-6{hint}"
        )
    };
    let target = SwapTarget::parse(name).ok_or_else(unknown)?;
    let of_role = || (0..nodes.len()).filter(|&node| nodes[node].role == target.role);
    let meant: Vec<usize> = match &target.whom {
        Served::Role | Served::Each => of_role().collect(),
        Served::Agents(agents) => {
            let is_in = |agent: &usize| agents.contains(&(agent + 1));
            let meant: Vec<usize> = of_role().filter(|&node| nodes[node].agents.iter().all(is_in)).collect();
            let served = |agent: &&usize| of_role().any(|node| nodes[node].agents.contains(&(**agent - 1)));
            if let Some(agent) = agents.iter().find(|agent| !served(agent)) {
                let most =
                    of_role().flat_map(|node| nodes[node].agents.iter()).map(|agent| agent + 1).max().unwrap_or(0);
                return Err(format!("there is no {} of agent {agent}, expected agents 1 to {most}", target.role));
            }
            meant
        }
    };
    if meant.is_empty() { Err(unknown()) } else { Ok((target, meant)) }
}
