//! One node, one step: what [`Local`](crate::Local) and a worker process do alike, so that both give the same bits.

use crate::{Channel, Fault, Header, Io, Layout, Network, Participant, Ports, Status, Step, Store};

/// A participant in its place in the network.
pub(crate) struct Member {
    /// Number of the node in the network.
    pub(crate) node: usize,
    ports: Ports,
    participant: Box<dyn Participant>,
}

impl Member {
    /// The participant of node number `node`.
    pub(crate) fn new(network: &Network, node: usize, participant: Box<dyn Participant>) -> Self {
        Self { node, ports: Ports::of(&network.nodes[node]), participant }
    }

    /// Runs the node at `step`, or holds its last outputs if it is not its turn.
    ///
    /// # Errors
    /// What the participant says, or that an output is not a finite number.
    pub(crate) fn run(
        &mut self,
        network: &Network,
        store: &mut Store,
        step: &Step,
        period_ns: u64,
    ) -> Result<(), Fault> {
        match network.nodes[self.node].last_run(step.index) {
            Some(run) if run == step.index => {
                self.participant.step(step, &mut Io::new(store, &self.ports, step.index))?;
                for &output in &self.ports.outputs {
                    let channel = &network.channels[output.0];
                    check_finite(channel, store.read(output, step.index))?;
                    store.stamp(output, step.index, Header::new(step.index, period_ns, channel.agent, Status::Fresh));
                }
            }
            Some(_) => self.ports.outputs.iter().for_each(|&output| store.hold(output, step.index)),
            // Not yet its turn: its channels read as zeros.
            None => {}
        }
        Ok(())
    }
}

/// A number that is not finite would spread over the whole formation within a few steps; it is stopped where it arises.
fn check_finite(channel: &Channel, words: &[f64]) -> Result<(), Fault> {
    match words.iter().position(|word| !word.is_finite()) {
        None => Ok(()),
        Some(at) => Err(not_finite(&channel.topic, &channel.layout, at, words[at])),
    }
}

#[cold]
fn not_finite(topic: &str, layout: &Layout, at: usize, value: f64) -> Fault {
    Fault(format!("output {topic}: {} is {value}", layout.label(at)))
}
