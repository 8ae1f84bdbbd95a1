//! One node, one step: what [`Local`](crate::Local) and a worker process do alike, so that both give the same bits.
//!
//! Only a crate that carries out runs needs this.

use crate::store::is_unwritten;
use crate::{Channel, Fault, Header, Io, Network, Participant, Period, Ports, Status, Step, Store};

/// A participant with its node in the network.
pub(crate) struct Member {
    pub(crate) runner: NodeRunner,
    participant: Box<dyn Participant>,
}

impl Member {
    /// The participant of node number `node`.
    pub(crate) fn new(network: &Network, node: usize, participant: Box<dyn Participant>) -> Self {
        Self { runner: NodeRunner::new(network, node), participant }
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
        if !self.runner.is_due(network, store, step) {
            return Ok(());
        }
        self.participant.step(step, &mut self.runner.io(store, step))?;
        self.runner.finish(network, store, step, stamp)
    }
}

/// Runs the steps of a node, except for the computation itself: checks which steps are its own, and its outputs.
pub struct NodeRunner {
    /// Number of the node in the network.
    pub node: usize,
    ports: Ports,
    /// Agent numbers of the outputs.
    agents: Vec<u32>,
    /// Whether the node runs at every step from the first.
    always: bool,
}

impl NodeRunner {
    /// For node number `node`.
    pub fn new(network: &Network, node: usize) -> Self {
        let place = &network.nodes[node];
        let agents = place.outputs.iter().map(|output| network.channels[output.0].agent).collect();
        Self { node, ports: Ports::of(place), agents, always: place.always_runs() }
    }

    /// Whether the node runs at `step`. If it does, nothing is written of its outputs yet, so that what it forgets is not a
    /// finite number; if it does not, its last outputs stand for this step too.
    #[inline]
    pub fn is_due(&self, network: &Network, store: &mut Store, step: &Step) -> bool {
        let last_run = if self.always { Some(step.index) } else { network.nodes[self.node].last_run(step.index) };
        match last_run {
            Some(run) if run == step.index => {
                self.forget(store, step);
                true
            }
            Some(_) => {
                self.ports.outputs.iter().for_each(|&output| store.hold(output, step.index, Status::Held));
                false
            }
            // Not yet its turn: its channels read as their initial samples.
            None => false,
        }
    }

    /// Makes its outputs of `step` ones of which nothing is written yet.
    #[inline]
    pub(crate) fn forget(&self, store: &mut Store, step: &Step) {
        self.ports.outputs.iter().for_each(|&output| store.forget(output, step.index));
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
pub(crate) fn all_finite(words: &[f64]) -> bool {
    // Without an early end, so that several numbers are looked at in one instruction.
    words.iter().fold(true, |finite, word| finite & word.is_finite())
}

#[cold]
fn not_finite(channel: &Channel, words: &[f64]) -> Fault {
    let at = words.iter().position(|word| !word.is_finite()).unwrap_or(0);
    let (topic, label) = (&channel.topic, channel.layout.label(at));
    if is_unwritten(words[at]) {
        return Fault(format!(
            "output {topic}: {label} is NaN: it was not written; write every number of an output at every step"
        ));
    }
    Fault(format!("output {topic}: {label} is {}", words[at]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ChannelId, Field, Layout, Node, Slice};

    /// Writes the first `words` numbers of its output at each of its runs.
    struct Writes(Vec<usize>);

    impl Participant for Writes {
        fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
            io.slice_mut(Slice::new(0, 0, self.0.remove(0))).fill(0.0);
            Ok(())
        }
    }

    /// What comes of the steps of a participant that writes so many numbers at each of its runs.
    fn outcome(words: &[usize], every: u64) -> (u64, String) {
        let layout = Layout::new([Field::vector("input", 2, ""), Field::scalar("norm", "")]);
        let channel = Channel { topic: "/command".into(), layout, ..Channel::default() };
        let node = Node { name: "own".into(), inputs: vec![], outputs: vec![ChannelId(0)], every, offset: 0 };
        let network = Network { channels: vec![channel], nodes: vec![node] };
        let mut run = crate::Local::new(network, vec![Box::new(Writes(words.to_vec()))], 1.0).unwrap();
        (0..).find_map(|step| run.step().err().map(|error| (step, error.fault.0))).unwrap()
    }

    #[test]
    fn a_number_that_is_not_written_is_named_in_the_step() {
        let told = |label| {
            format!(
                "output /command: {label} is NaN: it was not written; write every number of an output at every step"
            )
        };
        assert_eq!(outcome(&[2], 1), (0, told("norm")));
        assert_eq!(outcome(&[3, 1], 1), (1, told("input[1]")));
        // Not what was written two steps before, either; a sample that is held is not to be written.
        assert_eq!(outcome(&[3, 3, 3, 0], 1), (3, told("input[0]")));
        assert_eq!(outcome(&[3, 3, 2], 4), (8, told("norm")));
    }

    #[test]
    fn one_number_that_is_not_finite_is_found_wherever_it_stands() {
        for length in 1..=9 {
            assert!(all_finite(&vec![f64::MAX; length]));
            for at in 0..length {
                for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let mut words = vec![0.0; length];
                    words[at] = bad;
                    assert!(!all_finite(&words), "{words:?}");
                }
            }
        }
    }
}
