//! A worker's part in one phase: what it fetches, whose turn it is, what it publishes.

use std::collections::{BTreeMap, BTreeSet};

use crate::board::{self, ChannelReader, ChannelWriter, Hub};
use crate::page::{FaultKind, Page, Report};
use crate::service::ServiceError;
use crate::shares::Shares;
use lockstep::execute::{Place, stamp};
use lockstep::{ChannelId, Plan, Status, Step, Store, Timing};

/// What a worker does in one phase.
pub(super) struct Seat {
    pub(super) phase: usize,
    /// Its number among the workers of the phase.
    pub(super) position: usize,
    fetches: Vec<Fetch>,
    /// Its nodes in order of execution.
    pub(super) members: Vec<Seated>,
}

/// A channel that another process writes.
struct Fetch {
    reader: ChannelReader,
    timing: Timing,
    /// The node that needs it first.
    node: usize,
}

/// A node with its place to publish.
pub(super) struct Seated {
    pub(super) place: Place,
    /// Its number among the nodes of the worker as the plan lists them.
    pub(super) number: usize,
    writers: Vec<ChannelWriter>,
}

/// The seats of a worker, in order of phases, with all channels open for its process number `incarnation`.
pub(super) fn take(
    plan: &Plan,
    worker: usize,
    incarnation: u32,
    hub: &Hub,
    page: &Page,
) -> Result<Vec<Seat>, ServiceError> {
    let network = &plan.network;
    let mut hosted: Vec<(usize, usize)> = plan.workers[worker].nodes.iter().copied().enumerate().collect();
    // The order of execution is that of the network, not that in which a worker lists its nodes.
    hosted.sort_by_key(|&(_, node)| (plan.phases[node], node));
    let order: Vec<usize> = hosted.iter().map(|&(_, node)| node).collect();
    let mut seats: Vec<Seat> = Vec::new();
    let shares = Shares::of(plan);
    let mut writers: BTreeMap<ChannelId, ChannelWriter> = BTreeMap::new();
    for share in shares.of_worker(worker) {
        let opened = hub.open(plan, share, incarnation)?.writers()?;
        writers.extend(opened.into_iter().map(|writer| (writer.channel(), writer)));
    }
    for (number, node) in hosted {
        let phase = plan.phases[node];
        if seats.last().is_none_or(|seat| seat.phase != phase) {
            let position = plan.members(phase).iter().position(|&member| member == worker).unwrap_or(0);
            seats.push(Seat { phase, position, fetches: Vec::new(), members: Vec::new() });
        }
        let outputs = network.nodes[node].outputs.iter();
        let writers = outputs.filter_map(|output| writers.remove(output)).collect();
        if let Some(seat) = seats.last_mut() {
            seat.members.push(Seated { place: Place::new(network, node), number, writers });
        }
    }
    let wanted = wanted_channels(plan, &order);
    for share in shares.all() {
        let is_wanted = |channel: &ChannelId| wanted.contains_key(channel);
        if !share.channels.iter().any(|(channel, _)| is_wanted(channel)) {
            continue;
        }
        let board = hub.open(plan, share, page.incarnation(share.worker))?;
        for reader in board.readers(is_wanted)? {
            let (timing, node) = wanted[&reader.channel];
            if let Some(seat) = seats.iter_mut().find(|seat| seat.phase == plan.phases[node]) {
                seat.fetches.push(Fetch { reader, timing, node });
            }
        }
    }
    // In order of the network, in whatever services they are.
    seats.iter_mut().for_each(|seat| seat.fetches.sort_by_key(|fetch| fetch.reader.channel));
    Ok(seats)
}

/// What the nodes in `order` read from other processes: of which step, and who needs it first.
fn wanted_channels(plan: &Plan, order: &[usize]) -> BTreeMap<ChannelId, (Timing, usize)> {
    let writers = plan.network.writers();
    let own: BTreeSet<usize> = order.iter().copied().collect();
    let mut wanted: BTreeMap<ChannelId, (Timing, usize)> = BTreeMap::new();
    for &node in order {
        for input in &plan.network.nodes[node].inputs {
            // Nobody writes it: it reads as its initial sample. A node of this process writes it: it is in the store.
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

impl Seat {
    /// Fetches what the nodes of the seat read from other processes.
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

/// Opens what the seats read from workers that were replaced.
pub(super) fn follow(hub: &Hub, page: &Page, plan: &Plan, seats: &mut [Seat]) -> Result<(), ServiceError> {
    let readers = seats.iter_mut().flat_map(|seat| seat.fetches.iter_mut().map(|fetch| &mut fetch.reader));
    board::follow(hub, page, plan, readers)
}

impl Seated {
    /// The channels that it writes.
    pub(super) fn outputs(&self) -> impl Iterator<Item = ChannelId> {
        self.writers.iter().map(ChannelWriter::channel)
    }

    /// Lets the last samples stand for `step` too, since nobody computes any more.
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
        let finished = self.place.finish(&plan.network, store, step, &stamp);
        finished.map_err(|wrong| fault(self.place.node, step, wrong.0))?;
        self.publish(store, step);
        Ok(())
    }
}

/// The report of a node that cannot go on.
#[cold]
pub(super) fn fault(node: usize, step: &Step, message: String) -> Report {
    Report { kind: FaultKind::Fault, node, step: step.index, message }
}
