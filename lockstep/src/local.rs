//! All participants in one process: the same order, the same bits, no system call in a step.

use crate::{Fault, Io, LoopError, Network, Participant, Ports, Step, Store};

/// A participant that could not compute its step.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{node} at step {step}: {fault}")]
pub struct StepError {
    /// Name of the node.
    pub node: String,
    /// Number of the step.
    pub step: u64,
    /// What it said.
    pub fault: Fault,
}

/// Runs a network in the calling thread.
pub struct Local {
    /// Nodes in order of execution.
    order: Vec<usize>,
    network: Network,
    participants: Vec<Box<dyn Participant>>,
    ports: Vec<Ports>,
    store: Store,
    next: Step,
}

impl Local {
    /// A run of `network` whose node i is `participants[i]`, with steps of `dt` seconds.
    ///
    /// # Errors
    /// [`LoopError`] if same-step edges form a loop.
    pub fn new(network: Network, participants: Vec<Box<dyn Participant>>, dt: f64) -> Result<Self, LoopError> {
        let phases = network.phases()?;
        let mut order: Vec<usize> = (0..network.nodes.len()).collect();
        order.sort_by_key(|&node| phases[node]);
        let ports = network.nodes.iter().map(Ports::of).collect();
        let store = Store::new(network.channels.iter().map(|channel| &channel.layout));
        Ok(Self { order, network, participants, ports, store, next: Step { index: 0, dt } })
    }

    /// Runs one step of everybody and returns its number.
    ///
    /// # Errors
    /// [`StepError`] if a participant faults; the run cannot go on then.
    pub fn step(&mut self) -> Result<u64, StepError> {
        let step = self.next;
        for &node in &self.order {
            let mut io = Io::new(&mut self.store, &self.ports[node], step.index);
            self.participants[node].step(&step, &mut io).map_err(|fault| StepError {
                node: self.network.nodes[node].name.clone(),
                step: step.index,
                fault,
            })?;
        }
        self.next.index += 1;
        Ok(step.index)
    }

    /// The samples of the last two steps.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// The network that runs.
    pub fn network(&self) -> &Network {
        &self.network
    }
}
