//! `[sensors]` and `[actuators]` in the network: between the plant and its observers and controllers stand sensors, and between a
//! controller and the plant actuators.
//!
//! What sensors measure is a channel of its own, `/agent_2/measured/state`, and what actuators make of a command is
//! `/agent_2/applied/command`; each has the fields of the channel that it stands for. The ports of the readers stay as they are.

mod actuators;
mod sensors;

use lockstep::{Channel, ChannelId, Input, Network, Node, Participant, Timing};

use self::actuators::ActuatorsParticipant;
use self::sensors::SensorsParticipant;
use super::links::reads_over_links;
use super::{NodeRole, Signals};
use crate::config::Problem;
use crate::role::Role;
use crate::scenario::{ACTUATORS, SENSORS, Scenario};

/// A node of sensors or of actuators, of all agents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InstrumentNode {
    Sensors,
    Actuators,
}

/// What a channel of sensors and of actuators is called between the agent and the channel that it stands for.
const MEASURED: &str = "measured";
const APPLIED: &str = "applied";

/// Puts sensors and actuators between the nodes of a network. The new nodes follow the others. The channels of sensors are entered into `ids`
/// as those of the plant.
///
/// # Errors
/// Everything that is wrong with their parameters.
pub(super) fn insert(
    scenario: &Scenario,
    signals: &Signals,
    nodes: &[NodeRole],
    network: &mut Network,
    ids: &mut Vec<Option<(Role, usize)>>,
) -> Result<Vec<InstrumentNode>, Vec<Problem>> {
    let mut inserted = Vec::new();
    if scenario.context.sensors.is_some() {
        add(Role::Plant, SENSORS, MEASURED, reads_over_links, signals, nodes, network, ids);
        inserted.push(InstrumentNode::Sensors);
    }
    if scenario.context.actuators.is_some() {
        add(Role::Controller, ACTUATORS, APPLIED, |role| role == Role::Plant, signals, nodes, network, ids);
        inserted.push(InstrumentNode::Actuators);
    }
    Ok(inserted)
}

/// Adds the node called `name` with a channel for each agent that stands for that of `role`, and gives these channels to `readers`.
#[expect(clippy::too_many_arguments, reason = "what both kinds have in common, called in one place")]
fn add(
    role: Role,
    name: &str,
    stem: &str,
    readers: impl Fn(Role) -> bool,
    signals: &Signals,
    nodes: &[NodeRole],
    network: &mut Network,
    ids: &mut Vec<Option<(Role, usize)>>,
) {
    let mut stands_for = vec![None; network.channels.len()];
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for agent in 0.. {
        let Some(source) = signals.find(role, agent) else { break };
        let channel = ChannelId(network.channels.len());
        let Channel { agent: number, layout, .. } = network.channels[source.0].clone();
        let topic = format!("/agent_{}/{stem}/{}", agent + 1, role.channel());
        network.channels.push(Channel { topic, agent: number, layout, initial: Vec::new() });
        // Only observers and controllers may read over links what sensors have measured.
        ids.push((role == Role::Plant).then_some((role, agent)));
        inputs.push(Input { channel: source, timing: Timing::SameStep });
        outputs.push(channel);
        stands_for[source.0] = Some(channel);
    }
    for (place, _) in nodes.iter().enumerate().filter(|(_, node)| readers(node.role)) {
        for input in &mut network.nodes[place].inputs {
            if let Some(Some(channel)) = stands_for.get(input.channel.0) {
                input.channel = *channel;
            }
        }
    }
    network.nodes.push(Node { name: name.into(), inputs, outputs, every: 1, offset: 0 });
}

/// The channel for which one of sensors or actuators stands, `/agent_2/state` for `/agent_2/measured/state`.
pub(super) fn original(topic: &str) -> Option<String> {
    let (agent, name) = [MEASURED, APPLIED].into_iter().find_map(|stem| topic.split_once(&format!("/{stem}/")))?;
    Some(format!("{agent}/{name}"))
}

impl InstrumentNode {
    /// Builds the participant of a node.
    ///
    /// # Errors
    /// Everything that is wrong with its parameters.
    pub(super) fn build(self, scenario: &Scenario, signals: &Signals) -> Result<Box<dyn Participant>, Vec<Problem>> {
        match self {
            Self::Sensors => Ok(Box::new(SensorsParticipant::new(scenario, signals)?)),
            Self::Actuators => Ok(Box::new(ActuatorsParticipant::new(scenario, signals)?)),
        }
    }
}
