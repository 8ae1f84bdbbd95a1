//! `[links]` in the network: between a channel and those of its readers that belong to another agent stands a link.
//!
//! A link is a channel of its own, `/agent_5/from_2/state`: the fields of the channel that it carries, and behind them those of
//! [`LINK_FIELDS`]. The ports of the readers stay as they are. The links for the signals of a role are a node of the network.

mod participant;

use std::collections::BTreeMap;

use lockstep::{Channel, ChannelId, Field, Input, Layout, MAX_WORDS, Network, Node, Timing};

use self::participant::LinksParticipant;
use super::{NodeRole, Signals};
use crate::config::Problem;
use crate::effects::{Delay, LINK_FIELDS, Loss};
use crate::role::Role;
use crate::scenario::{LinkPlace, Links, Scenario};

/// The node of the links for the signals of one role.
#[derive(Clone, Debug)]
pub(super) struct LinkNode {
    role: Role,
    /// The links, in the order of their outputs.
    links: Vec<Ends>,
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
        let node = LinkNode { role, links: ends };
        let inputs = node.inputs(scenario, links, signals)?;
        network.nodes.push(Node { name: format!("links_{}", role.channel()), inputs, outputs, every: 1, offset: 0 });
        inserted.push(node);
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

impl LinkNode {
    /// What the links read.
    fn inputs(&self, scenario: &Scenario, links: &Links, signals: &Signals) -> Result<Vec<Input>, Vec<Problem>> {
        let mut inputs = Vec::new();
        for ends in &self.links {
            let layout = self.layout(signals, ends);
            if layout.words() + LINK_FIELDS.len() > MAX_WORDS {
                let (words, most) = (layout.words(), MAX_WORDS - LINK_FIELDS.len());
                let (agent, role) = (ends.sender + 1, self.role);
                let message =
                    format!("the {role} of agent {agent} publishes {words} numbers: a link carries at most {most}");
                return Err(vec![scenario.problem("links", message)]);
            }
            let others = self.others(signals, ends.sender);
            let place = LinkPlace { sender: ends.sender, receiver: ends.receiver, layout, others: &others };
            let link = links.model(&scenario.context, &place)?;
            let mut add = |input: Input| {
                if !inputs.contains(&input) {
                    inputs.push(input);
                }
            };
            add(Input { channel: ends.source, timing: Timing::SameStep });
            if link.by_distance {
                for agent in [ends.sender, ends.receiver] {
                    let channel = signals
                        .find(Role::Plant, agent)
                        .filter(|channel| signals.layout(*channel).find("position").is_some());
                    let channel = channel.ok_or_else(|| {
                        let message = format!("the distance is not known: agent {} publishes no position", agent + 1);
                        vec![scenario.problem("links", message)]
                    })?;
                    add(Input { channel, timing: Timing::SameStep });
                }
            }
            if link.model.trigger.is_some() || link.model.interval.is_some() {
                let command = signals.find(Role::Controller, ends.sender).filter(|_| !others.is_empty());
                command.into_iter().for_each(|channel| add(Input { channel, timing: Timing::Delayed }));
            }
        }
        Ok(inputs)
    }

    /// What a message consists of. Sensors change the numbers only.
    fn layout<'a>(&self, signals: &'a Signals, ends: &Ends) -> &'a Layout {
        signals.layout(signals.find(self.role, ends.sender).unwrap_or(ends.source))
    }

    /// The signals of the sender that only triggers read: its command of the step before.
    fn others(&self, signals: &Signals, sender: usize) -> Vec<(String, usize)> {
        let command = signals.find(Role::Controller, sender).filter(|_| self.role != Role::Controller);
        let fields = command.into_iter().flat_map(|command| signals.layout(command).fields());
        fields.map(|field| (format!("{}.{}", Role::Controller.channel(), field.name), field.shape.words())).collect()
    }

    /// What the scenario asks of each link.
    pub(super) fn asked(&self, scenario: &Scenario, signals: &Signals) -> Vec<AskedLink> {
        let Some(links) = &scenario.context.links else { return Vec::new() };
        let asked = self.links.iter().filter_map(|ends| {
            let (layout, others) = (self.layout(signals, ends), self.others(signals, ends.sender));
            let place = LinkPlace { sender: ends.sender, receiver: ends.receiver, layout, others: &others };
            // A mistake has been reported when the links were put in.
            let model = links.model(&scenario.context, &place).ok()?.model;
            Some(AskedLink {
                agents: [ends.sender + 1, ends.receiver + 1],
                topic: topic(ends.sender, ends.receiver, self.role),
                loss: model.loss.as_ref().map_or(Some(0.0), Loss::expected),
                delay: model.delay.as_ref().map_or(Some(0.0), Delay::mean),
                rate: Some(model.schedule.rate()).filter(|_| model.trigger.is_none() && model.interval.is_none()),
                bits: model.bits,
            })
        });
        asked.collect()
    }

    /// Builds the participant of a node.
    ///
    /// # Errors
    /// Everything that is wrong with the parameters of a link.
    pub(super) fn build(
        &self,
        scenario: &Scenario,
        signals: &Signals,
        node: &Node,
    ) -> Result<LinksParticipant, Vec<Problem>> {
        LinksParticipant::new(self, scenario, signals, node)
    }
}
