//! Which channels of a worker share a service.
//!
//! A service takes as long to set up as some thousand keys, so a worker of many participants must not have one for each of
//! them. But iceoryx2 looks for a key among all those of the service, one by one, so that a service must not have many.

use std::collections::BTreeSet;

use lockstep::{ChannelId, Plan};

/// Most channels of a service.
const MOST: usize = 64;

/// The services of all workers.
pub(crate) struct BoardParts {
    /// By worker.
    parts: Vec<Vec<BoardPart>>,
    /// By channel: worker and number of the service among its own; `None` for a channel without a writer.
    places: Vec<Option<(usize, usize)>>,
}

/// The channels of a service.
#[derive(Debug)]
pub(crate) struct BoardPart {
    /// The worker that writes them.
    pub(crate) worker: usize,
    /// Its number among those of the worker.
    pub(crate) number: usize,
    /// The channels, and the node that writes each.
    pub(crate) channels: Vec<(ChannelId, usize)>,
}

impl BoardParts {
    /// Those of a run.
    pub(crate) fn of(plan: &Plan) -> Self {
        let mut places = vec![None; plan.network.channels.len()];
        let of_worker = |worker: usize| -> Vec<BoardPart> {
            let nodes = plan.workers[worker].nodes.iter();
            let outputs = |&node: &usize| plan.network.nodes[node].outputs.iter().map(move |&output| (output, node));
            let channels: Vec<(ChannelId, usize)> = nodes.flat_map(outputs).collect();
            let parts = channels.chunks(MOST).enumerate();
            parts.map(|(number, channels)| BoardPart { worker, number, channels: channels.to_vec() }).collect()
        };
        let parts: Vec<Vec<BoardPart>> = (0..plan.workers.len()).map(of_worker).collect();
        for part in parts.iter().flatten() {
            part.channels.iter().for_each(|(channel, _)| places[channel.0] = Some((part.worker, part.number)));
        }
        Self { parts, places }
    }

    /// All services.
    pub(crate) fn all(&self) -> impl Iterator<Item = &BoardPart> {
        self.parts.iter().flatten()
    }

    /// The services of a worker.
    pub(crate) fn of_worker(&self, worker: usize) -> &[BoardPart] {
        &self.parts[worker]
    }

    /// By worker and service: the workers that read channels of it.
    pub(crate) fn readers(&self, plan: &Plan) -> Vec<Vec<BTreeSet<usize>>> {
        let mut readers: Vec<Vec<BTreeSet<usize>>> =
            self.parts.iter().map(|parts| vec![BTreeSet::new(); parts.len()]).collect();
        for (reader, worker) in plan.workers.iter().enumerate() {
            let inputs = worker.nodes.iter().flat_map(|&node| &plan.network.nodes[node].inputs);
            for (writer, part) in inputs.filter_map(|input| self.places[input.channel.0]) {
                readers[writer][part].insert(reader);
            }
        }
        readers
    }
}

#[cfg(test)]
mod tests {
    use lockstep::{Channel, Input, Network, Node, Timing, WorkerPlan};

    use super::*;

    /// 100 nodes that write a channel each and read that of the node before, in two workers.
    fn plan() -> Plan {
        let node = |index: usize| Node {
            name: format!("n{index}"),
            inputs: vec![Input { channel: ChannelId((index + 99) % 100), timing: Timing::Delayed }],
            outputs: vec![ChannelId(index)],
            every: 1,
            offset: 0,
        };
        let channel = |index| Channel { topic: format!("/c{index}"), ..Channel::default() };
        let network = Network { channels: (0..100).map(channel).collect(), nodes: (0..100).map(node).collect() };
        let workers =
            [0..90, 90..100].map(|nodes| WorkerPlan { name: format!("w{}", nodes.start), nodes: nodes.collect() });
        Plan::new("parts", network, 1_000_000, 1, workers.to_vec()).unwrap()
    }

    #[test]
    fn a_service_has_many_channels_but_not_all() {
        let parts = BoardParts::of(&plan());
        let sizes: Vec<_> = parts.all().map(|part| (part.worker, part.number, part.channels.len())).collect();
        assert_eq!(sizes, [(0, 0, 64), (0, 1, 26), (1, 0, 10)]);
        let channels: Vec<usize> = parts.all().flat_map(|part| &part.channels).map(|(channel, _)| channel.0).collect();
        assert_eq!(channels, (0..100).collect::<Vec<_>>());
    }

    #[test]
    fn who_reads_a_service_is_counted_once() {
        let plan = plan();
        let readers = BoardParts::of(&plan).readers(&plan);
        let only = |workers: &[usize]| workers.iter().copied().collect::<BTreeSet<_>>();
        assert_eq!(readers, [vec![only(&[0]), only(&[0, 1])], vec![only(&[0, 1])]]);
    }
}
