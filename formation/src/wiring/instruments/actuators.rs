//! The node that applies commands.

use lockstep::{Fault, Io, Participant, Slice, Step};

use super::Signals;
use crate::config::Problem;
use crate::effects::ActuatorLaw;
use crate::role::Role;
use crate::scenario::Scenario;

/// The actuators of all agents.
pub(in crate::wiring) struct ActuatorsParticipant {
    agents: Vec<Applied>,
}

/// The actuators of one agent: one for each of its inputs.
struct Applied {
    /// The whole command.
    command: Slice,
    values: Vec<f64>,
    /// Where the inputs begin in it.
    first: usize,
    laws: Vec<ActuatorLaw>,
}

impl ActuatorsParticipant {
    pub(super) fn new(scenario: &Scenario, signals: &Signals) -> Result<Self, Vec<Problem>> {
        let context = &scenario.context;
        let mut agents = Vec::new();
        let commands =
            (0..context.agents.len()).filter_map(|agent| Some((agent, signals.find(Role::Controller, agent)?)));
        for (port, (agent, channel)) in commands.enumerate() {
            let layout = signals.layout(channel);
            let (first, length) = layout.find("input").unwrap_or((0, 0));
            let vehicle = &context.agents[agent].vehicle;
            let name = |place: usize| match vehicle.model() {
                Some(model) => model.inputs.get(place).map_or(String::new(), |input| input.name.clone()),
                None => format!("u{}", place + 1),
            };
            let names: Vec<String> = (0..length).map(name).collect();
            let limits = context.actuators.as_ref().map(|actuators| actuators.actuators(context, agent, &names));
            let limits = limits.transpose()?.unwrap_or_default();
            let laws = limits.iter().map(|limits| ActuatorLaw::new(limits, 1, context.timing.dt)).collect();
            let words = layout.words();
            agents.push(Applied { command: Slice::new(port, 0, words), values: vec![0.0; words], first, laws });
        }
        Ok(Self { agents })
    }
}

impl Participant for ActuatorsParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for Applied { command, values, first, laws } in &mut self.agents {
            let asked = io.slice(*command);
            values.copy_from_slice(asked);
            for (place, law) in (*first..).zip(laws) {
                law.update(step.index, &asked[place..=place], &mut values[place..=place]);
            }
            io.slice_mut(*command).copy_from_slice(values);
        }
        Ok(())
    }
}
