//! The node that carries messages.

use lockstep::{Fault, Io, Participant, Slice, Step};

use super::{LinkNode, PlannedLink};
use crate::effects::{Instant, LINK_FIELDS, Link};
use crate::math::RandomStream;
use crate::role::Role;
use crate::scenario::Context;

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
    pub(super) fn new(node: &LinkNode, context: &Context) -> Self {
        let wire = |(output, planned): (usize, &PlannedLink)| {
            let PlannedLink { ends, link, source, others, positions } = planned;
            let mut ids = [ends.sender, ends.receiver].map(|agent| context.agents[agent].id);
            if link.is_symmetric {
                ids.sort_unstable();
            }
            let name = format!("link {} -> {}, {}", ids[0], ids[1], node.role.channel());
            let (words, stream) = (source.length, RandomStream::new(context.seed, &name));
            Wire {
                link: Link::new(link.model.clone(), words, context.timing.dt, stream),
                sender: ends.sender,
                source: *source,
                others: *others,
                positions: *positions,
                out: Slice::new(output, 0, words + LINK_FIELDS.len()),
                begins_with_sample: node.role != Role::Controller,
            }
        };
        let wires = node.links.iter().enumerate().map(wire).collect();
        Self { wires, busy: vec![0.0; context.agents.len()] }
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
