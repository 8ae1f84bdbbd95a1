//! Initial samples: what a channel reads as until its writer has run.

use std::collections::BTreeSet;

use crate::execute::{NodeRunner, all_finite};
use crate::{ChannelId, LoopError, Network, Participant, Step, Store, Timing};

/// Gives those channels an initial sample that are read before they are written: by delayed edges at step 0, and by any edge if
/// their writer runs later than that.
///
/// The initial sample is what the writer computes at step 0: a plant its initial state, an observer its initial estimates.
/// `starters` are the writers, by number and newly built; they are used up. A channel of another writer, or of one that cannot
/// compute its step, starts with zeros.
///
/// # Errors
/// [`LoopError`] if same-step edges form a loop.
pub fn set(network: &mut Network, mut starters: Vec<(usize, Box<dyn Participant>)>, dt: f64) -> Result<(), LoopError> {
    let phases = network.phases()?;
    let early = read_early(network);
    if early.is_empty() {
        return Ok(());
    }
    starters.sort_by_key(|&(node, _)| (phases[node], node));
    let (mut store, step) = (Store::of(network), Step { index: 0, dt });
    for (node, mut participant) in starters {
        let runner = NodeRunner::new(network, node);
        runner.forget(&mut store, &step);
        let computed = participant.step(&step, &mut runner.io(&mut store, &step)).is_ok();
        for &output in &network.nodes[node].outputs {
            let sample = store.read(output, 0);
            let sample = if computed && all_finite(sample) { sample.to_vec() } else { vec![0.0; sample.len()] };
            store.begin(output, &sample);
            if early.contains(&output) && sample.iter().any(|word| word.to_bits() != 0) {
                network.channels[output.0].initial = sample;
            }
        }
    }
    Ok(())
}

/// The channels that are read before their first sample.
fn read_early(network: &Network) -> BTreeSet<ChannelId> {
    let writers = network.writers();
    let starts_late = |channel: ChannelId| writers[channel.0].is_some_and(|writer| network.nodes[writer].offset > 0);
    let inputs = network.nodes.iter().flat_map(|node| &node.inputs);
    let early = inputs.filter(|input| input.timing == Timing::Delayed || starts_late(input.channel));
    early.map(|input| input.channel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Channel, Fault, Field, In, Input, Io, Layout, Local, Node, Out};

    /// Publishes `start` at step 0 plus what it reads, and one more in every run.
    struct Count {
        value: f64,
        read: Option<In<1>>,
    }

    impl Participant for Count {
        fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
            let read = self.read.map_or(0.0, |input| io.get(input)[0]);
            io.set(Out::<1>::new(0, 0), [self.value + read]);
            self.value += 1.0;
            Ok(())
        }
    }

    fn count(value: f64, reads: bool) -> Box<dyn Participant> {
        Box::new(Count { value, read: reads.then(|| In::new(0, 0)) })
    }

    /// A source that starts at step `offset` and runs at every `every`-th step, and a reader of it.
    fn pair(timing: Timing, every: u64, offset: u64) -> Network {
        let channel = |topic: &str| Channel {
            topic: topic.into(),
            layout: Layout::new([Field::scalar("value", "")]),
            ..Channel::default()
        };
        let input = Input { channel: ChannelId(0), timing };
        let source = Node { name: "source".into(), inputs: vec![], outputs: vec![ChannelId(0)], every, offset };
        let reader =
            Node { name: "reader".into(), inputs: vec![input], outputs: vec![ChannelId(1)], every: 1, offset: 0 };
        Network { channels: vec![channel("/source"), channel("/reader")], nodes: vec![source, reader] }
    }

    /// What the reader has published at the first steps, less the number of the step.
    fn seen(timing: Timing, every: u64, offset: u64) -> Vec<f64> {
        let mut network = pair(timing, every, offset);
        set(&mut network, vec![(0, count(5.0, false))], 1.0).unwrap();
        let mut run = Local::new(network, vec![count(5.0, false), count(0.0, true)], 1.0).unwrap();
        let mut values = Vec::new();
        for step in 0..5 {
            run.step().unwrap();
            values.push(run.store().read(ChannelId(1), step)[0] - step as f64);
        }
        values
    }

    #[test]
    fn a_delayed_edge_reads_the_initial_sample_at_step_0() {
        assert_eq!(seen(Timing::Delayed, 1, 0), [5.0, 5.0, 6.0, 7.0, 8.0]);
        assert_eq!(seen(Timing::SameStep, 1, 0), [5.0, 6.0, 7.0, 8.0, 9.0]);
    }

    #[test]
    fn the_initial_sample_stands_until_the_writer_has_run() {
        assert_eq!(seen(Timing::SameStep, 2, 1), [5.0, 5.0, 5.0, 6.0, 6.0]);
        assert_eq!(seen(Timing::Delayed, 2, 1), [5.0, 5.0, 5.0, 5.0, 6.0]);
        assert_eq!(seen(Timing::Delayed, 3, 3), [5.0, 5.0, 5.0, 5.0, 5.0]);
    }

    #[test]
    fn only_what_is_read_early_has_one() {
        for (timing, offset, early) in [(Timing::SameStep, 0, 0), (Timing::SameStep, 1, 1), (Timing::Delayed, 0, 1)] {
            let mut network = pair(timing, 1, offset);
            set(&mut network, vec![(0, count(5.0, false)), (1, count(0.0, true))], 1.0).unwrap();
            let initial: Vec<usize> = network.channels.iter().map(|channel| channel.initial.len()).collect();
            assert_eq!(initial, [early, 0]);
        }
    }

    #[test]
    fn initial_samples_follow_from_each_other_along_delayed_edges_too() {
        let mut network = pair(Timing::Delayed, 1, 0);
        let input = Input { channel: ChannelId(1), timing: Timing::Delayed };
        network.nodes.push(Node { name: "last".into(), inputs: vec![input], outputs: vec![], every: 1, offset: 0 });
        set(&mut network, vec![(1, count(2.0, true)), (0, count(5.0, false))], 1.0).unwrap();
        assert_eq!(network.channels[0].initial, [5.0]);
        assert_eq!(network.channels[1].initial, [7.0]);
    }

    #[test]
    fn a_writer_that_cannot_compute_its_step_starts_with_zeros() {
        let mut network = pair(Timing::Delayed, 1, 0);
        set(&mut network, vec![(0, count(f64::NAN, false))], 1.0).unwrap();
        assert!(network.channels[0].initial.is_empty());
    }
}
