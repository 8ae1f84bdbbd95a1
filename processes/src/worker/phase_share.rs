//! A worker's part in one phase: what it fetches, which of its nodes run, what it publishes.

use std::collections::{BTreeMap, BTreeSet};

use crate::board::{self, Boards, ChannelReader, ChannelWriter};
use crate::board_parts::BoardParts;
use crate::page::{FaultKind, Page, Report};
use crate::service::ServiceError;
use lockstep::execute::{NodeRunner, stamp};
use lockstep::{ChannelId, Plan, Status, Step, Store, Timing};

/// What a worker does in one phase.
pub(super) struct PhaseShare {
    pub(super) phase: usize,
    /// Its number among the workers of the phase.
    pub(super) position: usize,
    fetches: Vec<Fetch>,
    /// Its nodes in order of execution.
    pub(super) members: Vec<HostedNode>,
}

/// A channel that another process writes.
struct Fetch {
    reader: ChannelReader,
    timing: Timing,
    /// The node that needs it first.
    node: usize,
}

/// A node with its place to publish.
pub(super) struct HostedNode {
    pub(super) runner: NodeRunner,
    /// Its number among the nodes of the worker as the plan lists them.
    pub(super) number: usize,
    writers: Vec<ChannelWriter>,
}

/// The shares of a worker, in order of phases, with all channels open for its process number `incarnation`.
pub(super) fn take(
    plan: &Plan,
    worker: usize,
    incarnation: u32,
    boards: &Boards,
    page: &Page,
) -> Result<Vec<PhaseShare>, ServiceError> {
    let network = &plan.network;
    let mut hosted: Vec<(usize, usize)> = plan.workers[worker].nodes.iter().copied().enumerate().collect();
    // The order of execution is that of the network, not that in which a worker lists its nodes.
    hosted.sort_by_key(|&(_, node)| (plan.phases[node], node));
    let order: Vec<usize> = hosted.iter().map(|&(_, node)| node).collect();
    let mut shares: Vec<PhaseShare> = Vec::new();
    let parts = BoardParts::of(plan);
    let mut writers: BTreeMap<ChannelId, ChannelWriter> = BTreeMap::new();
    for part in parts.of_worker(worker) {
        let opened = boards.open(plan, part, incarnation)?.writers()?;
        writers.extend(opened.into_iter().map(|writer| (writer.channel(), writer)));
    }
    for (number, node) in hosted {
        let phase = plan.phases[node];
        if shares.last().is_none_or(|share| share.phase != phase) {
            let position = plan.members(phase).iter().position(|&member| member == worker).unwrap_or(0);
            shares.push(PhaseShare { phase, position, fetches: Vec::new(), members: Vec::new() });
        }
        let outputs = network.nodes[node].outputs.iter();
        let writers = outputs.filter_map(|output| writers.remove(output)).collect();
        if let Some(share) = shares.last_mut() {
            share.members.push(HostedNode { runner: NodeRunner::new(network, node), number, writers });
        }
    }
    let wanted = wanted_channels(plan, &order);
    for part in parts.all() {
        let is_wanted = |channel: &ChannelId| wanted.contains_key(channel);
        if !part.channels.iter().any(|(channel, _)| is_wanted(channel)) {
            continue;
        }
        let board = boards.open(plan, part, page.incarnation(part.worker))?;
        for reader in board.readers(is_wanted)? {
            let (timing, node) = wanted[&reader.channel];
            if let Some(share) = shares.iter_mut().find(|share| share.phase == plan.phases[node]) {
                share.fetches.push(Fetch { reader, timing, node });
            }
        }
    }
    // In order of the network, in whatever services they are.
    shares.iter_mut().for_each(|share| share.fetches.sort_by_key(|fetch| fetch.reader.channel));
    Ok(shares)
}

/// What the nodes in `order` read from other processes: of which step, and who needs it first.
fn wanted_channels(plan: &Plan, order: &[usize]) -> BTreeMap<ChannelId, (Timing, usize)> {
    let writers = plan.network.writers();
    let own: BTreeSet<usize> = order.iter().copied().collect();
    let mut wanted: BTreeMap<ChannelId, (Timing, usize)> = BTreeMap::new();
    for &node in order {
        for input in &plan.network.nodes[node].inputs {
            // No node writes it: it reads as its initial sample. A node of this process writes it: it is in the store.
            if writers[input.channel.0].is_none_or(|writer| own.contains(&writer)) {
                continue;
            }
            let entry = wanted.entry(input.channel).or_insert((input.timing, node));
            // What is fetched in every step for a same-step reader is still there for a delayed one in the next step.
            if input.timing == Timing::SameStep && entry.0 == Timing::Delayed {
                *entry = (Timing::SameStep, node);
            }
        }
    }
    wanted
}

impl PhaseShare {
    /// Fetches what the nodes of the share read from other processes.
    ///
    /// # Errors
    /// A sample that is not the one that was due.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn fetch(&self, plan: &Plan, store: &mut Store, step: &Step) -> Result<(), Report> {
        for fetch in &self.fetches {
            let sample = match fetch.timing {
                Timing::SameStep => Some(step.index),
                Timing::Delayed => step.index.checked_sub(1),
            };
            let Some(sample) = sample else { continue };
            fetch
                .reader
                .fetch(&plan.network, store, sample)
                .map_err(|wrong| fault(fetch.node, step, wrong.describe(&plan.network)))?;
        }
        Ok(())
    }
}

/// Opens what the shares read from workers that were replaced.
pub(super) fn follow(boards: &Boards, page: &Page, plan: &Plan, shares: &mut [PhaseShare]) -> Result<(), ServiceError> {
    let readers = shares.iter_mut().flat_map(|share| share.fetches.iter_mut().map(|fetch| &mut fetch.reader));
    board::follow(boards, page, plan, readers)
}

impl HostedNode {
    /// The channels that it writes.
    pub(super) fn outputs(&self) -> impl Iterator<Item = ChannelId> {
        self.writers.iter().map(ChannelWriter::channel)
    }

    /// Lets the last samples stand for `step` too, since its participant does not compute any more.
    pub(super) fn hold(&self, store: &mut Store, step: &Step) {
        self.outputs().for_each(|output| store.hold(output, step.index, Status::Stale));
    }

    /// Publishes what stands in the store for `step`.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn publish(&mut self, store: &Store, step: &Step) {
        self.writers.iter_mut().for_each(|writer| writer.publish(store, step.index));
    }

    /// Checks, stamps and publishes what was computed at `step`.
    ///
    /// # Errors
    /// If an output is not a finite number.
    #[unsafe(link_section = "lockstep_step")]
    pub(super) fn finish(&mut self, plan: &Plan, store: &mut Store, step: &Step) -> Result<(), Report> {
        let stamp = stamp(step, plan.period);
        let finished = self.runner.finish(&plan.network, store, step, &stamp);
        finished.map_err(|wrong| fault(self.runner.node, step, wrong.0))?;
        self.publish(store, step);
        Ok(())
    }
}

/// The report of a node that cannot go on.
#[cold]
pub(super) fn fault(node: usize, step: &Step, message: String) -> Report {
    Report { kind: FaultKind::Fault, node, step: step.index, message }
}
