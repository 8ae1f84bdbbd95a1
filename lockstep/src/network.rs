//! The step graph: who writes what, who reads it when, and the phases that follow.

use serde::{Deserialize, Serialize};

use crate::Layout;

/// Number of a channel within its [`Network`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ChannelId(pub usize);

/// Which sample of a channel a reader needs at step k.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Timing {
    /// That of step k: the reader runs after the writer (Gauss-Seidel).
    SameStep,
    /// That of step k-1: no order within the step (Jacobi).
    Delayed,
}

/// A stream of samples with one writer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Its name in the log, `/agent_3/state`.
    pub topic: String,
    /// Agent number from 1, or 0 if it belongs to none.
    pub agent: u32,
    /// What its samples consist of.
    pub layout: Layout,
    /// What is read until its writer has run, and by delayed readers at step 0. Empty: zeros.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub initial: Vec<f64>,
}

/// A channel that a node reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Input {
    /// The channel.
    pub channel: ChannelId,
    /// Of this step or of the one before.
    pub timing: Timing,
}

/// A participant as the graph sees it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Node {
    /// Its name, `controller_3`.
    pub name: String,
    /// Channels it reads, in order of its input ports.
    pub inputs: Vec<Input>,
    /// Channels it writes, in order of its output ports.
    pub outputs: Vec<ChannelId>,
    /// Runs at every `every`-th step (0 counts as 1) ...
    pub every: u64,
    /// ... starting with this one.
    pub offset: u64,
}

impl Node {
    /// Whether it runs at every step from the first.
    pub fn always_runs(&self) -> bool {
        self.every <= 1 && self.offset == 0
    }

    /// The last step up to and including `step` at which the node runs; `None` before its first.
    pub fn last_run(&self, step: u64) -> Option<u64> {
        let since_offset = step.checked_sub(self.offset)?;
        Some(step - since_offset % self.every.max(1))
    }
}

/// Same-step edges that form a loop: no node could run first.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("algebraic loop: {} -> {}; make one of these edges delayed", .0.join(" -> "), .0[0])]
pub struct LoopError(pub Vec<String>);

/// All nodes and channels of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Network {
    /// Channels; a [`ChannelId`] is an index into them.
    pub channels: Vec<Channel>,
    /// Nodes in their order of execution within a phase.
    pub nodes: Vec<Node>,
}

impl Network {
    /// Which node writes each channel (`None`: none does).
    pub fn writers(&self) -> Vec<Option<usize>> {
        let mut writers = vec![None; self.channels.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            for channel in &node.outputs {
                writers[channel.0] = Some(index);
            }
        }
        writers
    }

    /// The phase of every node: the topological level of the same-step edges.
    ///
    /// # Errors
    /// [`LoopError`] names the nodes of a loop of same-step edges.
    pub fn phases(&self) -> Result<Vec<usize>, LoopError> {
        let writers = self.writers();
        let before: Vec<Vec<usize>> = self
            .nodes
            .iter()
            .map(|node| {
                let same_step = node.inputs.iter().filter(|input| input.timing == Timing::SameStep);
                same_step.filter_map(|input| writers[input.channel.0]).collect()
            })
            .collect();
        let mut phases: Vec<Option<usize>> = vec![None; self.nodes.len()];
        let mut path = Vec::new();
        for node in 0..self.nodes.len() {
            self.visit(node, &before, &mut phases, &mut path)?;
        }
        Ok(phases.into_iter().map(|phase| phase.unwrap_or(0)).collect())
    }

    fn visit(
        &self,
        node: usize,
        before: &[Vec<usize>],
        phases: &mut [Option<usize>],
        path: &mut Vec<usize>,
    ) -> Result<usize, LoopError> {
        if let Some(phase) = phases[node] {
            return Ok(phase);
        }
        if let Some(start) = path.iter().position(|&visited| visited == node) {
            // The path runs against the edges; print it along them.
            return Err(LoopError(path[start..].iter().rev().map(|&n| self.nodes[n].name.clone()).collect()));
        }
        path.push(node);
        let mut phase = 0;
        for &writer in &before[node] {
            phase = phase.max(self.visit(writer, before, phases, path)? + 1);
        }
        path.pop();
        phases[node] = Some(phase);
        Ok(phase)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network(edges: &[(&[(usize, Timing)], usize)]) -> Network {
        let channel = |i| Channel { topic: format!("/c{i}"), ..Channel::default() };
        let nodes = edges.iter().enumerate().map(|(i, (inputs, output))| Node {
            name: format!("n{i}"),
            inputs: inputs.iter().map(|&(c, timing)| Input { channel: ChannelId(c), timing }).collect(),
            outputs: vec![ChannelId(*output)],
            every: 1,
            offset: 0,
        });
        Network { channels: (0..edges.len()).map(channel).collect(), nodes: nodes.collect() }
    }

    use Timing::{Delayed, SameStep};

    #[test]
    fn a_slow_node_runs_at_multiples_after_its_offset() {
        let mut node = network(&[(&[], 0)]).nodes.remove(0);
        (node.every, node.offset) = (3, 2);
        let runs: Vec<_> = (0..9).map(|step| node.last_run(step)).collect();
        assert_eq!(runs, [None, None, Some(2), Some(2), Some(2), Some(5), Some(5), Some(5), Some(8)]);
    }

    #[test]
    fn phases_are_levels_of_same_step_edges() {
        let net =
            network(&[(&[(2, Delayed)], 0), (&[(0, SameStep)], 1), (&[(0, SameStep), (1, SameStep)], 2), (&[], 3)]);
        assert_eq!(net.phases(), Ok(vec![0, 1, 2, 0]));
    }

    #[test]
    fn a_loop_is_refused_by_name() {
        let net = network(&[(&[(1, SameStep)], 0), (&[(0, SameStep)], 1)]);
        let error = net.phases().unwrap_err().to_string();
        assert!(error.contains("n0") && error.contains("n1") && error.contains("delayed"), "{error}");
    }
}
