//! The communication graph of a run, for programs of users.

use super::{AgentNumber, Proximity};
use crate::math::{Topology, TopologySchedule};

/// The communication graph as it is in force: the static links, the reference links, and the links by distance.
#[derive(Clone, Debug)]
pub struct Graph {
    topology: Topology,
    proximity: Option<Proximity>,
}

impl Graph {
    pub(super) fn new(topology: &Topology, proximity: Option<&Proximity>) -> Self {
        Self { topology: topology.clone(), proximity: proximity.cloned() }
    }

    /// All graphs of a run: first step and graph, in order.
    pub(super) fn over_time(topology: &TopologySchedule, proximity: Option<&Proximity>) -> Vec<(u64, Self)> {
        topology.intervals().iter().map(|(start, graph)| (*start, Self::new(graph, proximity))).collect()
    }

    /// Weight of the static link over which `i` receives from `j`; 0 if there is none.
    pub fn weight(&self, i: AgentNumber, j: AgentNumber) -> f64 {
        self.topology.a(i.index(), j.index())
    }

    /// The same if both are `distance` (m) apart: where there is no static link, that of `topology.proximity`.
    pub fn weight_at(&self, i: AgentNumber, j: AgentNumber, distance: f64) -> f64 {
        match &self.proximity {
            Some(proximity) if i != j && self.weight(i, j) == 0.0 => proximity.weight(distance),
            _ => self.weight(i, j),
        }
    }

    /// Weight of the reference link of `i`.
    pub fn b(&self, i: AgentNumber) -> f64 {
        self.topology.b(i.index())
    }

    /// The agents from which `i` receives over static links, ascending.
    pub fn neighbours(&self, i: AgentNumber) -> impl Iterator<Item = AgentNumber> {
        self.topology.neighbours(i.index()).iter().map(|&j| AgentNumber::at(j))
    }
}
