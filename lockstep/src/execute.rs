//! One node, one step: what [`Local`](crate::Local) and a worker process do alike, so that both give the same bits.
//!
//! Only a crate that carries out runs needs this.

use crate::{Channel, Fault, Header, Io, Network, Participant, Period, Ports, Status, Step, Store};

/// A participant in its place in the network.
pub(crate) struct Member {
    pub(crate) place: Place,
    participant: Box<dyn Participant>,
}

impl Member {
    /// The participant of node number `node`.
    pub(crate) fn new(network: &Network, node: usize, participant: Box<dyn Participant>) -> Self {
        Self { place: Place::new(network, node), participant }
    }

    /// Runs the node at `step`, or holds its last outputs if it is not its turn. `stamp` is the [`stamp`] of the step.
    ///
    /// # Errors
    /// What the participant says, or that an output is not a finite number.
    pub(crate) fn run(
        &mut self,
        network: &Network,
        store: &mut Store,
        step: &Step,
        stamp: &Header,
    ) -> Result<(), Fault> {
        if !self.place.is_due(network, store, step) {
            return Ok(());
        }
        self.participant.step(step, &mut self.place.io(store, step))?;
        self.place.finish(network, store, step, stamp)
    }
}

/// A node as far as its steps are concerned, whoever computes them.
pub struct Place {
    /// Number of the node in the network.
    pub node: usize,
    ports: Ports,
    /// Agent numbers of the outputs.
    agents: Vec<u32>,
    /// Whether the node runs at every step from the first.
    always: bool,
}

impl Place {
    /// The place of node number `node`.
    pub fn new(network: &Network, node: usize) -> Self {
        let place = &network.nodes[node];
        let agents = place.outputs.iter().map(|output| network.channels[output.0].agent).collect();
        Self { node, ports: Ports::of(place), agents, always: place.always_runs() }
    }

    /// Whether the node runs at `step`. If it does not, its last outputs stand for this step too.
    #[inline]
    pub fn is_due(&self, network: &Network, store: &mut Store, step: &Step) -> bool {
        let last_run = if self.always { Some(step.index) } else { network.nodes[self.node].last_run(step.index) };
        match last_run {
            Some(run) if run == step.index => true,
            Some(_) => {
                self.ports.outputs.iter().for_each(|&output| store.hold(output, step.index, Status::Held));
                false
            }
            // Not yet its turn: its channels read as zeros.
            None => false,
        }
    }

    /// What the node sees of its channels at `step`.
    pub fn io<'a>(&'a self, store: &'a mut Store, step: &Step) -> Io<'a> {
        Io::new(store, &self.ports, step.index)
    }

    /// Checks and stamps the outputs that were computed at `step`.
    ///
    /// # Errors
    /// If an output is not a finite number.
    #[inline]
    pub fn finish(&self, network: &Network, store: &mut Store, step: &Step, stamp: &Header) -> Result<(), Fault> {
        for (&output, &agent) in self.ports.outputs.iter().zip(&self.agents) {
            if !all_finite(store.read(output, step.index)) {
                return Err(not_finite(&network.channels[output.0], store.read(output, step.index)));
            }
            let status = if store.take_mark(output) { Status::Held as u32 } else { stamp.status };
            store.stamp(output, step.index, Header { agent, status, ..*stamp });
        }
        Ok(())
    }
}

/// The header of all fresh samples of a step, but for the agent.
pub fn stamp(step: &Step, period: Period) -> Header {
    Header::new(step.index, period, 0, Status::Fresh)
}

/// A number that is not finite would spread over the whole formation within a few steps; it is stopped where it arises.
fn all_finite(words: &[f64]) -> bool {
    // Without an early end, so that several numbers are looked at in one instruction.
    words.iter().fold(true, |finite, word| finite & word.is_finite())
}

#[cold]
fn not_finite(channel: &Channel, words: &[f64]) -> Fault {
    let at = words.iter().position(|word| !word.is_finite()).unwrap_or(0);
    Fault(format!("output {}: {} is {}", channel.topic, channel.layout.label(at), words[at]))
}
