//! `[topology]`: who receives from whom, and who knows the reference.

mod adjacency;
mod choose;
mod file;
mod resolve;
mod spec;

use adjacency::Adjacency;
use schemars::JsonSchema;
use serde::Deserialize;

pub(super) use adjacency::TWO_WAY_RING;
pub(super) use choose::choose_agents;
pub(super) use resolve::resolve_files;

use super::elsewhere::Elsewhere;
use super::proximity::MISSING;
use super::{Agent, Proximity};
use crate::config::{Node, PerAgent, Problems, Sort, read};
use crate::math::{Topology, TopologySchedule};

/// `[topology]`: who receives from whom. Without it, there are no links, and every agent knows the reference.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TopologySection {
    /// Row i lists the weights of the links over which agent i receives; or the name of a graph, by default `ring`.
    #[serde(rename = "A")]
    adjacency: Option<Adjacency>,
    /// The links by the name of a graph, or as a table: a graph with options, a list of links, or a file.
    #[serde(default)]
    #[schemars(schema_with = "spec::schema")]
    graph: Option<Elsewhere>,
    /// Weights of the links to the reference; by default 1.
    b: Option<PerAgent>,
    /// The agents that know the reference: `b` is 1 for them, and 0 for the others.
    leaders: Option<Vec<u32>>,
    /// Links that appear when agents come close.
    proximity: Option<Proximity>,
    /// Allows a graph that is not strongly connected, as long as the reference reaches everybody.
    #[serde(default)]
    any_graph: bool,
    /// Other graphs from later times on, in ascending order of the times.
    #[serde(default)]
    at: Vec<SwitchTable>,
}

/// A switch to another graph. What it does not give stays as it was.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SwitchTable {
    /// The time of the switch, s: the first step at or after it has the new graph.
    t: f64,
    /// The links as a matrix or by the name of a ring.
    #[serde(rename = "A")]
    adjacency: Option<Adjacency>,
    /// The links by the name of a graph, or as a table.
    #[serde(default)]
    #[schemars(schema_with = "spec::schema")]
    graph: Option<Elsewhere>,
    /// Weights of the links to the reference.
    b: Option<PerAgent>,
    /// The agents that know the reference.
    leaders: Option<Vec<u32>>,
}

/// What `[topology]` says.
#[derive(Debug)]
pub(super) struct Links {
    /// The static links and those to the reference.
    pub(super) topology: TopologySchedule,
    /// Links by distance, if there are any.
    pub(super) proximity: Option<Proximity>,
    /// Whether the graph need not be strongly connected.
    pub(super) any_graph: bool,
}

/// Reads the section; a ring stands for what is wrong, which is reported.
pub(super) fn read_topology(root: &Node, agents: &[Agent], seed: u64, dt: f64, problems: &mut Problems) -> Links {
    let links = |topology: TopologySchedule| Links { topology, proximity: None, any_graph: false };
    let Some(node) = root.at("topology") else {
        let alone = Topology::from_links(&[], vec![1.0; agents.len()]);
        return links(alone.unwrap_or_else(|_| Topology::ring(Vec::new())).into());
    };
    let dummy = || Topology::ring(vec![1.0; agents.len()]);
    let Some(section) = read::<TopologySection>(node, "topology", problems) else { return links(dummy().into()) };
    let mut reading = Reading { root, agents, seed, problems };
    let first = reading.first(&section).unwrap_or_else(dummy);
    let switches = reading.switches(&section, &first, dt);
    for (field, message) in section.proximity.iter().flat_map(Proximity::findings) {
        if message == MISSING {
            let message = format!("missing field `{field}`, or instead `weight`, a formula of the distance");
            problems.at(root, "topology.proximity", message).sort = Sort::Missing;
        } else {
            problems.at(root, &format!("topology.proximity.{field}"), message);
        }
    }
    Links {
        topology: TopologySchedule::new(first, switches),
        proximity: section.proximity.filter(|proximity| proximity.enabled),
        any_graph: section.any_graph,
    }
}

/// What is needed to read the links of a graph.
struct Reading<'a> {
    root: &'a Node,
    agents: &'a [Agent],
    seed: u64,
    problems: &'a mut Problems,
}

impl Reading<'_> {
    /// The graph from the start on; nothing if it is wrong, which is reported.
    fn first(&mut self, section: &TopologySection) -> Option<Topology> {
        let reference = self.reference("topology", section.b.as_ref(), section.leaders.as_deref());
        let links = self.links("topology", section.adjacency.as_ref(), section.graph);
        links?.with_reference(&reference?).ok()
    }

    /// The later graphs, each with its first step; as far as they are right. The rest is reported.
    fn switches(&mut self, section: &TopologySection, first: &Topology, dt: f64) -> Vec<(u64, Topology)> {
        let mut switches: Vec<(u64, Topology)> = Vec::new();
        let mut earlier = 0.0;
        for (place, switch) in section.at.iter().enumerate() {
            let path = format!("topology.at.{}", place + 1);
            if !(switch.t.is_finite() && switch.t > earlier) {
                let message = format!("expected a time > {earlier} s, in ascending order, found {}", switch.t);
                self.problems.at(self.root, &format!("{path}.t"), message);
                continue;
            }
            earlier = switch.t;
            // A time that is a multiple of the step but for its last digits means that step. Casts saturate.
            let step = (switch.t / dt - 1e-6).ceil().max(1.0) as u64;
            if switches.last().is_some_and(|(last, _)| *last == step) {
                let message =
                    format!("expected a switch at a later step than the one before, found both at step {step}");
                self.problems.at(self.root, &format!("{path}.t"), message);
                continue;
            }
            let before = switches.last().map_or(first, |(_, graph)| graph);
            if let Some(graph) = self.switched(&path, switch, before) {
                switches.push((step, graph));
            }
        }
        switches
    }

    /// The graph after a switch; nothing if it is wrong, which is reported.
    fn switched(&mut self, path: &str, switch: &SwitchTable, before: &Topology) -> Option<Topology> {
        let has_links = switch.adjacency.is_some() || switch.graph.is_some();
        let has_reference = switch.b.is_some() || switch.leaders.is_some();
        if !has_links && !has_reference {
            self.problems.at(self.root, path, "expected another graph or other leaders: A, graph, b or leaders");
            return None;
        }
        let reference = match has_reference {
            true => self.reference(path, switch.b.as_ref(), switch.leaders.as_deref())?,
            false => (0..before.size()).map(|i| before.b(i)).collect(),
        };
        let links = match has_links {
            true => self.links(path, switch.adjacency.as_ref(), switch.graph)?,
            false => before.clone(),
        };
        links.with_reference(&reference).ok()
    }

    /// The links that the table at `path` describes, by default a ring; nothing if they are wrong, which is reported.
    fn links(&mut self, path: &str, adjacency: Option<&Adjacency>, named: Option<Elsewhere>) -> Option<Topology> {
        let (matrix, graph) = (format!("{path}.A"), format!("{path}.graph"));
        let reference = vec![0.0; self.agents.len()];
        if let Some(node) = named.and_then(|_| self.root.at(&graph)) {
            if adjacency.is_some() {
                self.problems.at(self.root, &graph, format!("expected only one of {matrix} and {graph}"));
                return None;
            }
            return spec::read_graph(node, &graph, self.agents.len(), self.seed, self.problems);
        }
        let found = adjacency.unwrap_or(&Adjacency::Ring).graph(reference);
        found.map_err(|message| _ = self.problems.at(self.root, &matrix, message)).ok()
    }

    /// The weights of the links to the reference, by default 1; nothing if they are wrong, which is reported.
    fn reference(&mut self, path: &str, b: Option<&PerAgent>, leaders: Option<&[u32]>) -> Option<Vec<f64>> {
        let count = self.agents.len();
        let field = |name: &str| format!("{path}.{name}");
        let Some(leaders) = leaders else {
            let Some(b) = b else { return Some(vec![1.0; count]) };
            let ids: Vec<u32> = self.agents.iter().map(|agent| agent.id).collect();
            let values =
                b.resolve(count, &ids).map_err(|message| _ = self.problems.at(self.root, &field("b"), message));
            let values = values.ok()?;
            if let Some(weight) = values.iter().find(|weight| !(weight.is_finite() && **weight >= 0.0)) {
                self.problems.at(self.root, &field("b"), format!("expected weights >= 0, found {weight}"));
                return None;
            }
            return Some(values);
        };
        if b.is_some() {
            let message = format!("expected only one of {} and {}", field("b"), field("leaders"));
            self.problems.at(self.root, &field("leaders"), message);
            return None;
        }
        let mut values = vec![0.0; count];
        for (place, &leader) in leaders.iter().enumerate() {
            let Some(value) = (leader as usize).checked_sub(1).and_then(|index| values.get_mut(index)) else {
                let message = format!("expected numbers of agents from 1 to {count}, found {leader}");
                self.problems.at(self.root, &field(&format!("leaders.{}", place + 1)), message);
                return None;
            };
            *value = 1.0;
        }
        Some(values)
    }
}

#[cfg(test)]
mod tests;
