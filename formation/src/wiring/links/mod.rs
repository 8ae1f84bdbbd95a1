//! `[links]` in the network: between a channel and those of its readers that belong to another agent stands a link.
//!
//! A link is a channel of its own, `/agent_5/from_2/state`: the fields of the channel that it carries, and behind them those of
//! [`LINK_FIELDS`]. The ports of the readers stay as they are. The links for the signals of a role are a node of the network.

mod participant;

use std::collections::BTreeMap;

use lockstep::{Channel, ChannelId, Field, Input, Layout, MAX_WORDS, Network, Node, Slice, Timing};

use self::participant::LinksParticipant;
use super::{NodeRole, Signals};
use crate::config::Problem;
use crate::effects::{Delay, LINK_FIELDS, Loss};
use crate::role::Role;
use crate::scenario::{CompiledLink, Context, LinkPlace, Links, Scenario};

/// The node of the links for the signals of one role.
#[derive(Clone, Debug)]
pub(super) struct LinkNode {
    role: Role,
    /// The links, in the order of their outputs.
    links: Vec<PlannedLink>,
}

/// A link with all that it reads, by the ports of its node.
#[derive(Clone, Debug)]
struct PlannedLink {
    ends: Ends,
    link: CompiledLink,
    source: Slice,
    /// The command of the sender, if a trigger reads it.
    others: Option<Slice>,
    /// The positions of sender and receiver, if the distance counts.
    positions: Option<[Slice; 2]>,
}

/// What a scenario asks of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedLink {
    /// The sender and the receiver, from 1.
    pub agents: [usize; 2],
    /// What is received, `/agent_5/from_2/state`.
    pub topic: String,
    /// The share of messages that are lost in the long run, besides outages and range, if it is known.
    pub loss: Option<f64>,
    /// The mean time on the way, s, if it is known.
    pub delay: Option<f64>,
    /// Messages per second; `None` if a trigger decides.
    pub rate: Option<f64>,
    /// Bits of a message.
    pub bits: f64,
}

/// A link, with the agents by their places, from 0.
#[derive(Clone, Copy, Debug)]
struct Ends {
    sender: usize,
    receiver: usize,
    source: ChannelId,
}

/// Puts links between the nodes of a network. The new nodes follow the others. `ids` has role and agent of each channel that links carry.
///
/// # Errors
/// Everything that is wrong with the parameters of a link.
pub(super) fn insert(
    scenario: &Scenario,
    signals: &Signals,
    nodes: &[NodeRole],
    network: &mut Network,
    ids: &[Option<(Role, usize)>],
) -> Result<Vec<LinkNode>, Vec<Problem>> {
    let Some(links) = &scenario.context.links else { return Ok(Vec::new()) };
    let mut made: BTreeMap<(ChannelId, usize), ChannelId> = BTreeMap::new();
    let mut by_role: BTreeMap<Role, (Vec<Ends>, Vec<ChannelId>)> = BTreeMap::new();
    for (place, NodeRole { role: reader, agents }) in nodes.iter().enumerate() {
        let &[receiver] = agents.as_slice() else { continue };
        if !reads_over_links(*reader) {
            continue;
        }
        for port in 0..network.nodes[place].inputs.len() {
            let source = network.nodes[place].inputs[port].channel;
            let Some((role, sender)) = ids[source.0] else { continue };
            if sender == receiver || !links.carries.contains(&role) {
                continue;
            }
            let channel = *made.entry((source, receiver)).or_insert_with(|| {
                let channel = ChannelId(network.channels.len());
                network.channels.push(link_channel(&network.channels[source.0], sender, receiver, role));
                let (ends, channels) = by_role.entry(role).or_default();
                ends.push(Ends { sender, receiver, source });
                channels.push(channel);
                channel
            });
            network.nodes[place].inputs[port].channel = channel;
        }
    }
    let mut inserted = Vec::new();
    for (role, (ends, outputs)) in by_role {
        let mut planner = Planner { scenario, links, signals, role, inputs: Vec::new(), ports: BTreeMap::new() };
        let planned = ends.into_iter().map(|ends| planner.plan(ends)).collect::<Result<_, _>>()?;
        let (name, inputs) = (format!("links_{}", role.channel()), planner.inputs);
        network.nodes.push(Node { name, inputs, outputs, every: 1, offset: 0 });
        inserted.push(LinkNode { role, links: planned });
    }
    Ok(inserted)
}

/// Whether participants of this role receive what they read of other agents over links.
pub(super) fn reads_over_links(role: Role) -> bool {
    matches!(role, Role::Observer | Role::Controller)
}

fn link_channel(source: &Channel, sender: usize, receiver: usize, role: Role) -> Channel {
    let about = LINK_FIELDS.map(|(name, unit)| Field::scalar(name, unit));
    Channel {
        topic: topic(sender, receiver, role),
        agent: receiver as u32 + 1,
        layout: Layout::new(source.layout.fields().iter().cloned().chain(about)),
        initial: Vec::new(),
    }
}

/// What the channel of a link is called.
fn topic(sender: usize, receiver: usize, role: Role) -> String {
    format!("/agent_{}/from_{}/{}", receiver + 1, sender + 1, role.channel())
}

/// The channel that this one carries, `/agent_2/state` for `/agent_5/from_2/state`.
pub(super) fn carried(topic: &str) -> Option<String> {
    let (_, rest) = topic.strip_prefix("/agent_")?.split_once("/from_")?;
    Some(format!("/agent_{rest}"))
}

/// Plans the links of a node, and collects what they read.
struct Planner<'a> {
    scenario: &'a Scenario,
    links: &'a Links,
    signals: &'a Signals,
    role: Role,
    inputs: Vec<Input>,
    /// The port of each, by channel and whether it is read delayed.
    ports: BTreeMap<(ChannelId, bool), usize>,
}

impl Planner<'_> {
    fn plan(&mut self, ends: Ends) -> Result<PlannedLink, Vec<Problem>> {
        let Self { scenario, links, signals, role, .. } = *self;
        // What a message consists of. Sensors change the numbers only.
        let layout = signals.layout(signals.find(role, ends.sender).unwrap_or(ends.source));
        let words = layout.words();
        if words + LINK_FIELDS.len() > MAX_WORDS {
            let (agent, most) = (ends.sender + 1, MAX_WORDS - LINK_FIELDS.len());
            let message =
                format!("the {role} of agent {agent} publishes {words} numbers: a link carries at most {most}");
            return Err(vec![scenario.problem("links", message)]);
        }
        // Besides the message, a trigger reads the command of the step before.
        let command = signals.find(Role::Controller, ends.sender).filter(|_| role != Role::Controller);
        let fields = command.into_iter().flat_map(|command| signals.layout(command).fields());
        let name = |field: &Field| format!("{}.{}", Role::Controller.channel(), field.name);
        let others: Vec<(String, usize)> = fields.map(|field| (name(field), field.shape.words())).collect();
        let place = LinkPlace { sender: ends.sender, receiver: ends.receiver, layout, others: &others };
        let link = links.model(&scenario.context, &place)?;
        let source = Slice::new(self.port(ends.source, Timing::SameStep), 0, words);
        let positions = match link.by_distance {
            true => Some([self.position(ends.sender)?, self.position(ends.receiver)?]),
            false => None,
        };
        let has_trigger = link.model.trigger.is_some() || link.model.interval.is_some();
        let others = command.filter(|_| has_trigger);
        let others =
            others.map(|channel| Slice::new(self.port(channel, Timing::Delayed), 0, signals.layout(channel).words()));
        Ok(PlannedLink { ends, link, source, others, positions })
    }

    /// The position of an agent, without its heading.
    fn position(&mut self, agent: usize) -> Result<Slice, Vec<Problem>> {
        let channel = self.signals.find(Role::Plant, agent);
        let found = channel.and_then(|channel| Some((channel, self.signals.layout(channel).find("position")?)));
        let Some((channel, (offset, length))) = found else {
            let message = format!("the distance is not known: agent {} publishes no position", agent + 1);
            return Err(vec![self.scenario.problem("links", message)]);
        };
        let length = length.min(self.scenario.context.agents[agent].vehicle.dimensions());
        Ok(Slice::new(self.port(channel, Timing::SameStep), offset, length))
    }

    fn port(&mut self, channel: ChannelId, timing: Timing) -> usize {
        *self.ports.entry((channel, timing == Timing::Delayed)).or_insert_with(|| {
            self.inputs.push(Input { channel, timing });
            self.inputs.len() - 1
        })
    }
}

impl LinkNode {
    /// What the scenario asks of each link.
    pub(super) fn asked(&self) -> impl Iterator<Item = AskedLink> {
        self.links.iter().map(|PlannedLink { ends, link: CompiledLink { model, .. }, .. }| AskedLink {
            agents: [ends.sender + 1, ends.receiver + 1],
            topic: topic(ends.sender, ends.receiver, self.role),
            loss: model.loss.as_ref().map_or(Some(0.0), Loss::expected),
            delay: model.delay.as_ref().map_or(Some(0.0), Delay::mean),
            rate: Some(model.schedule.rate()).filter(|_| model.trigger.is_none() && model.interval.is_none()),
            bits: model.bits,
        })
    }

    /// Builds the participant of a node.
    pub(super) fn build(&self, context: &Context) -> LinksParticipant {
        LinksParticipant::new(self, context)
    }
}
