//! The agents of a scene, the signals that hold their coordinates, and the links between them.

use std::collections::BTreeMap;

use formation::scenario::Agent;
use formation::wiring::Assembly;
use lockstep::{ChannelId, Network, Store};

use super::message::Pose;

/// Okabe and Ito's colours, black replaced by a grey that shows on dark and on light ground.
const COLOURS: [[u8; 3]; 8] = [
    [0x00, 0x72, 0xb2],
    [0xe6, 0x9f, 0x00],
    [0x99, 0x99, 0x99],
    [0x56, 0xb4, 0xe9],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xf0, 0xe4, 0x42],
];

/// The channels of a network by agent.
struct Published<'a> {
    network: &'a Network,
    by_agent: BTreeMap<u32, Vec<usize>>,
}

impl<'a> Published<'a> {
    fn of(network: &'a Network) -> Self {
        let mut by_agent: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (index, channel) in network.channels.iter().enumerate() {
            by_agent.entry(channel.agent).or_default().push(index);
        }
        Self { network, by_agent }
    }
}

/// Numbers that stand in a channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Signal {
    channel: ChannelId,
    offset: usize,
    width: usize,
}

impl Signal {
    /// The field of this name of an agent, on the topic that ends in `role`, or on any topic.
    fn find(published: &Published, agent: u32, role: Option<&str>, field: &str) -> Option<Self> {
        published.by_agent.get(&agent)?.iter().find_map(|&index| {
            let channel = &published.network.channels[index];
            if role.is_some_and(|role| channel.topic.rsplit('/').next() != Some(role)) {
                return None;
            }
            let (offset, width) = channel.layout.find(field)?;
            Some(Self { channel: ChannelId(index), offset, width })
        })
    }

    /// Its values at the step that ran last.
    pub(super) fn read<'a>(&self, store: &'a Store, step: u64) -> &'a [f64] {
        &store.read(self.channel, step)[self.offset..self.offset + self.width]
    }
}

/// An agent as it is drawn.
#[derive(Clone, Debug)]
pub(super) struct Actor {
    /// Its number.
    pub(super) number: u32,
    /// Its frame.
    pub(super) frame: String,
    /// Whether it drives on the ground, its third coordinate being its heading, or flies.
    pub(super) planar: bool,
    /// Radius of its body, m.
    pub(super) radius: f64,
    /// Red, green, blue, opacity.
    pub(super) colour: [f32; 4],
    position: Signal,
    /// Its heading, where that is not a part of the position.
    heading: Option<Signal>,
    target: Option<Signal>,
}

impl Actor {
    fn new(network: &Published, agent: &Agent) -> Option<Self> {
        let number = agent.number;
        let position = Signal::find(network, number, Some("state"), "position")?;
        let reference = |field| Signal::find(network, number, Some("reference"), field);
        let heading = agent.vehicle.heading().and_then(|field| Signal::find(network, number, Some("state"), field));
        let [red, green, blue] =
            COLOURS[(number as usize + COLOURS.len() - 1) % COLOURS.len()].map(|part| f32::from(part) / 255.0);
        Some(Self {
            number,
            frame: format!("agent_{number}"),
            planar: agent.vehicle.dimensions() <= 2,
            radius: agent.vehicle.radius().unwrap_or(0.25),
            colour: [red, green, blue, 1.0],
            position,
            heading,
            // Where its place in the formation is; for some planners that is what is tracked.
            target: reference("desired_position").or_else(|| reference("position")),
        })
    }

    /// Where it is.
    pub(super) fn pose(&self, store: &Store, step: u64) -> Pose {
        let position = self.position.read(store, step);
        let Some(heading) = self.heading else { return Pose::of(position, self.planar) };
        let at = |index: usize| position.get(index).copied().unwrap_or(0.0);
        Pose::of(&[at(0), at(1), heading.read(store, step)[0]], self.planar)
    }

    /// Where its place in the formation is, if the planner says so.
    pub(super) fn target(&self, store: &Store, step: u64) -> Option<Pose> {
        Some(Pose::of(self.target?.read(store, step), self.planar))
    }

    /// Whether [`Actor::target`] gives anything.
    pub(super) fn has_target(&self) -> bool {
        self.target.is_some()
    }
}

/// A link of the communication graph. Agents by their place among the actors.
#[derive(Clone, Debug)]
pub(super) struct Link {
    /// The sender.
    pub(super) from: usize,
    /// The receiver.
    pub(super) to: usize,
    /// Whether it is in the graph of the scenario, and not there only while the agents are close.
    pub(super) fixed: bool,
    /// Its weight, if it is logged.
    weight: Option<(Signal, usize)>,
    /// From which steps on the graph of the scenario has it, and has it not; nothing if that never changes.
    switches: Vec<(u64, bool)>,
}

impl Link {
    /// Whether it exists.
    pub(super) fn exists(&self, store: &Store, step: u64) -> bool {
        let is_on = self.switches.iter().rev().find(|(start, _)| *start <= step).is_none_or(|(_, is_on)| *is_on);
        self.weight.map_or(is_on, |(signal, place)| signal.read(store, step)[place] > 0.0)
    }
}

/// All agents whose position is recorded.
pub(super) fn actors(assembly: &Assembly) -> Vec<Actor> {
    let agents = &assembly.scenario.context.agents;
    let published = Published::of(&assembly.network);
    agents.iter().filter_map(|agent| Actor::new(&published, agent)).collect()
}

/// All links between actors that can exist.
pub(super) fn links(assembly: &Assembly, actors: &[Actor]) -> Vec<Link> {
    let (agents, topology) = (&assembly.scenario.context.agents, &assembly.scenario.context.topology);
    let published = Published::of(&assembly.network);
    // Weights are listed by the place of an agent in the scenario.
    let places: BTreeMap<u32, usize> = agents.iter().map(|agent| agent.number).zip(0..).collect();
    let by_place: BTreeMap<usize, usize> =
        actors.iter().enumerate().map(|(actor, agent)| (places[&agent.number], actor)).collect();
    let mut links = Vec::new();
    for (to, receiver) in actors.iter().enumerate() {
        let row = places[&receiver.number];
        let weights =
            Signal::find(&published, receiver.number, None, "adjacency").filter(|signal| signal.width == agents.len());
        let weight = |column| weights.map(|signal| (signal, column));
        let schedule = topology.neighbourhood(row);
        let neighbours = schedule.heard();
        let switches = |column: usize| match topology.is_switching() {
            true => topology.intervals().iter().map(|(start, graph)| (*start, graph.a(row, column) > 0.0)).collect(),
            false => Vec::new(),
        };
        match weights {
            // Any link may come to exist.
            Some(_) => links.extend(by_place.iter().filter(|(_, from)| **from != to).map(|(&column, &from)| {
                let fixed = neighbours.binary_search(&column).is_ok();
                Link { from, to, fixed, weight: weight(column), switches: Vec::new() }
            })),
            None => links.extend(neighbours.iter().filter_map(|&column| {
                let switches = switches(column);
                Some(Link { from: *by_place.get(&column)?, to, fixed: true, weight: None, switches })
            })),
        }
    }
    links
}
