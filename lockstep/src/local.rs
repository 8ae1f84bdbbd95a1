//! All participants in one process: the same order, the same bits, no system call in a step.

use crate::execute::Member;
use crate::{Fault, LoopError, Network, Participant, Step, Store};

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
    /// Participants in order of execution.
    members: Vec<Member>,
    network: Network,
    store: Store,
    next: Step,
    period_ns: u64,
}

impl Local {
    /// A run of `network` whose node i is `participants[i]`, with steps of `dt` seconds.
    ///
    /// Headers are stamped with multiples of `dt` rounded to nanoseconds.
    ///
    /// # Errors
    /// [`LoopError`] if same-step edges form a loop.
    pub fn new(network: Network, participants: Vec<Box<dyn Participant>>, dt: f64) -> Result<Self, LoopError> {
        let phases = network.phases()?;
        let mut members: Vec<Member> = participants
            .into_iter()
            .enumerate()
            .map(|(node, participant)| Member::new(&network, node, participant))
            .collect();
        // Stable: within a phase the order of the network stays.
        members.sort_by_key(|member| phases[member.node]);
        let store = Store::new(network.channels.iter().map(|channel| &channel.layout));
        let period_ns = (dt * 1e9).round() as u64;
        Ok(Self { members, network, store, next: Step { index: 0, dt }, period_ns })
    }

    /// Runs one step of everybody and returns its number. Nodes that run at a lower rate hold their outputs in between.
    ///
    /// # Errors
    /// [`StepError`] if a participant faults or an output is not finite; the run cannot go on then.
    pub fn step(&mut self) -> Result<u64, StepError> {
        let step = self.next;
        for member in &mut self.members {
            member.run(&self.network, &mut self.store, &step, self.period_ns).map_err(|fault| StepError {
                node: self.network.nodes[member.node].name.clone(),
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
