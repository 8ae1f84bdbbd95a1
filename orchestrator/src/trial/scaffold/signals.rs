//! What a participant of a scenario reads and writes.

use formation::vehicle::Drive;
use formation::wiring::{Assembly, Role};
use lockstep::{ChannelId, Layout};

/// A signal of one agent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Signal {
    /// The participant that publishes it.
    pub(super) role: Role,
    /// Its name.
    pub(super) name: String,
    /// How many numbers it has.
    pub(super) length: usize,
    /// Its unit; empty if it has none.
    pub(super) unit: String,
}

impl Signal {
    /// What to call it in a program: `state_position`, or `input` if it is an output.
    pub(super) fn variable(&self, is_input: bool) -> String {
        if is_input { format!("{}_{}", self.role.channel(), self.name) } else { self.name.clone() }
    }
}

/// The signals of a participant.
#[derive(Clone, Debug)]
pub(super) struct Signals {
    /// The participant that is taken as the model, `controller_1`.
    pub(super) node: String,
    /// Whether it serves all agents.
    pub(super) serves_all: bool,
    /// What it reads of every agent that it serves.
    pub(super) inputs: Vec<Signal>,
    /// What it writes for every agent that it serves.
    pub(super) outputs: Vec<Signal>,
    /// Topics of other agents that it may read, too.
    pub(super) others: Vec<String>,
    /// Whether the inputs are the accelerations of the coordinates, so that the law of the templates works.
    pub(super) drives_accelerations: bool,
}

impl Signals {
    /// The signals of the first participant of `role`.
    ///
    /// # Errors
    /// Says that there is no such participant, or that its agents have different signals.
    pub(super) fn of(assembly: &Assembly, role: Role) -> Result<Self, String> {
        let name = &assembly.scenario.name;
        let index = assembly.nodes.iter().position(|node| node.role == role);
        let index = index.ok_or_else(|| format!("the scenario {name} has no {role}"))?;
        let (node, agents) = (&assembly.network.nodes[index], &assembly.nodes[index].agents);
        let channels = &assembly.network.channels;
        let of_agent = |agent: usize| {
            let of_it = |channel: &ChannelId| channels[channel.0].agent as usize == agent + 1;
            let mut inputs: Vec<ChannelId> = Vec::new();
            // One that is read of this step and of the step before is one signal here.
            for channel in node.inputs.iter().map(|input| input.channel).filter(of_it) {
                if !inputs.contains(&channel) {
                    inputs.push(channel);
                }
            }
            let outputs = node.outputs.iter().copied();
            let outputs = outputs.filter(|channel| channels[channel.0].agent as usize == agent + 1);
            let signals = |channel: ChannelId| signals_of(&channels[channel.0].topic, &channels[channel.0].layout);
            (inputs.into_iter().flat_map(signals).collect::<Vec<_>>(), outputs.flat_map(signals).collect::<Vec<_>>())
        };
        let (inputs, outputs) = of_agent(agents[0]);
        if let Some(other) = agents.iter().find(|&&agent| of_agent(agent) != (inputs.clone(), outputs.clone())) {
            return Err(format!(
                "in the scenario {name}, agents {} and {} have different signals; take a {role} of another scenario as the model",
                agents[0] + 1,
                other + 1
            ));
        }
        let served = |agent: u32| agents.iter().any(|&own| own + 1 == agent as usize);
        let others = node.inputs.iter().map(|input| &channels[input.channel.0]);
        let others = others.filter(|channel| !served(channel.agent)).map(|channel| channel.topic.clone()).collect();
        let serves_all = agents.len() > 1 || node.name == role.name();
        let is_driven = |agent: &usize| {
            let vehicle = &assembly.scenario.context.agents[*agent].vehicle;
            vehicle.omni().is_some_and(|omni| omni.drive == Drive::Acceleration)
        };
        let mut signals =
            Self { node: node.name.clone(), serves_all, inputs, outputs, others, drives_accelerations: false };
        signals.drives_accelerations =
            role == Role::Controller && agents.iter().all(is_driven) && signals.has_what_the_law_needs();
        Ok(signals)
    }

    /// Whether there are the signals of a law that tracks the reference.
    fn has_what_the_law_needs(&self) -> bool {
        let reads = |role: Role, name: &str| {
            self.inputs.iter().any(|input| input.role == role && input.name == name && input.length == 3)
        };
        let tracked = ["position", "velocity"];
        tracked.iter().all(|name| reads(Role::Plant, name) && reads(Role::Planner, name))
            && reads(Role::Planner, "acceleration")
            && self.outputs.iter().any(|output| output.name == "input" && output.length == 3)
    }
}

fn signals_of(topic: &str, layout: &Layout) -> Vec<Signal> {
    let role = Role::ALL.into_iter().find(|role| topic.ends_with(&format!("/{}", role.channel())));
    let fields = role.into_iter().flat_map(|role| layout.fields().iter().map(move |field| (role, field)));
    let signal = |(role, field): (Role, &lockstep::Field)| Signal {
        role,
        name: field.name.clone(),
        length: field.shape.words(),
        unit: field.unit.clone(),
    };
    fields.map(signal).collect()
}
