//! The node that carries messages.

use lockstep::{ChannelId, Fault, Input, Io, Node, Participant, Slice, Step, Timing};

use super::{LinkNode, Signals};
use crate::config::Problem;
use crate::effects::{Instant, LINK_FIELDS, Link};
use crate::math::RandomStream;
use crate::role::Role;
use crate::scenario::{CompiledLink, LinkPlace, Scenario};

/// All links for the signals of one role.
pub(in crate::wiring) struct LinksParticipant {
    wires: Vec<Wire>,
    /// For each agent, the time, s, until which it is busy sending.
    busy: Vec<f64>,
}

struct Wire {
    link: Link,
    sender: usize,
    source: Slice,
    /// What only a trigger reads.
    others: Option<Slice>,
    /// The positions of sender and receiver, if the distance counts.
    positions: Option<[Slice; 2]>,
    out: Slice,
    /// Before the first message, the receiver has the first sample of the sender, as if nothing had happened before; of a command, zeros.
    begins_with_sample: bool,
}

impl LinksParticipant {
    pub(super) fn new(
        links: &LinkNode,
        scenario: &Scenario,
        signals: &Signals,
        node: &Node,
    ) -> Result<Self, Vec<Problem>> {
        let context = &scenario.context;
        let Some(parameters) = &context.links else { return Err(vec![scenario.problem("links", "missing")]) };
        let port = |channel: ChannelId, timing: Timing| {
            node.inputs.iter().position(|input| *input == Input { channel, timing })
        };
        let mut wires = Vec::new();
        for (output, ends) in links.links.iter().enumerate() {
            let layout = links.layout(signals, ends);
            let words = layout.words();
            let others = links.others(signals, ends.sender);
            let place = LinkPlace { sender: ends.sender, receiver: ends.receiver, layout, others: &others };
            let CompiledLink { model, by_distance, is_symmetric } = parameters.model(context, &place)?;
            let has_trigger = model.trigger.is_some() || model.interval.is_some();
            let mut ids = [ends.sender, ends.receiver].map(|agent| context.agents[agent].id);
            if is_symmetric {
                ids.sort_unstable();
            }
            let name = format!("link {} -> {}, {}", ids[0], ids[1], links.role.channel());
            let command = signals.find(Role::Controller, ends.sender).filter(|_| has_trigger && !others.is_empty());
            let others = command.and_then(|channel| {
                Some(Slice::new(port(channel, Timing::Delayed)?, 0, signals.layout(channel).words()))
            });
            let position = |agent: usize| {
                let channel = signals.find(Role::Plant, agent)?;
                let (offset, length) = signals.layout(channel).find("position")?;
                let length = length.min(context.agents[agent].vehicle.dimensions());
                Some(Slice::new(port(channel, Timing::SameStep)?, offset, length))
            };
            let positions = || Some([position(ends.sender)?, position(ends.receiver)?]);
            wires.push(Wire {
                link: Link::new(model, words, context.timing.dt, RandomStream::new(context.seed, &name)),
                sender: ends.sender,
                source: Slice::new(port(ends.source, Timing::SameStep).unwrap_or(0), 0, words),
                others,
                positions: positions().filter(|_| by_distance),
                out: Slice::new(output, 0, words + LINK_FIELDS.len()),
                begins_with_sample: links.role != Role::Controller,
            });
        }
        Ok(Self { wires, busy: vec![0.0; context.agents.len()] })
    }
}

impl Participant for LinksParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let t = step.time();
        for wire in &mut self.wires {
            let source = io.slice(wire.source);
            if !wire.link.has_begun() && wire.begins_with_sample {
                wire.link.begin(source);
            }
            let distance = wire.positions.map_or(f64::NAN, |positions| {
                let [sender, receiver] = positions.map(|position| io.slice(position));
                sender.iter().zip(receiver).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
            });
            let others = wire.others.map_or(&[][..], |others| io.slice(others));
            wire.link.update(&Instant { step: step.index, t, distance }, source, others, &mut self.busy[wire.sender]);
            wire.link.write(t, io.slice_mut(wire.out));
        }
        Ok(())
    }
}
