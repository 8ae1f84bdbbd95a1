//! The node that measures.

use std::sync::Arc;

use lockstep::{Fault, Io, Layout, Participant, Slice, Step};

use super::Signals;
use crate::config::Problem;
use crate::effects::Sensor;
use crate::formula::Formula;
use crate::math::RandomStream;
use crate::role::Role;
use crate::scenario::{Context, Scenario};
use crate::vehicle::Model;

/// The sensors of all agents.
pub(in crate::wiring) struct SensorsParticipant {
    agents: Vec<Measured>,
}

/// What is measured of one agent.
struct Measured {
    source: Slice,
    out: Slice,
    values: Vec<f64>,
    /// The sensors of states of a vehicle by equations, and what follows from these.
    of_states: Vec<Placed>,
    derived: Option<Derived>,
    others: Vec<Placed>,
    /// Numbers that are the same: the second is a copy of the first.
    copies: Vec<(usize, usize)>,
}

/// A sensor with the numbers that it measures.
struct Placed {
    first: usize,
    length: usize,
    sensor: Sensor,
}

/// What a vehicle by equations computes of its states.
struct Derived {
    model: Arc<Model>,
    slots: Vec<f64>,
    /// Where the states are among the numbers.
    states: usize,
    /// The numbers that follow, with their formulas.
    formulas: Vec<(usize, Formula)>,
}

impl SensorsParticipant {
    pub(super) fn new(scenario: &Scenario, signals: &Signals) -> Result<Self, Vec<Problem>> {
        let context = &scenario.context;
        let count = context.agents.len();
        let agents = (0..count).filter_map(|agent| Some((agent, signals.find(Role::Plant, agent)?)));
        let measured = |(place, (agent, channel))| Measured::new(context, place, agent, signals.layout(channel));
        Ok(Self { agents: agents.enumerate().map(measured).collect::<Result<_, _>>()? })
    }
}

impl Measured {
    fn new(context: &Context, place: usize, agent: usize, layout: &Layout) -> Result<Self, Vec<Problem>> {
        let words = layout.words();
        let sensors = context.sensors.as_ref().map(|sensors| sensors.sensors(context, agent, layout)).transpose()?;
        let sensors = sensors.unwrap_or_default();
        let model = context.agents[agent].vehicle.model();
        let state_names: Vec<&str> =
            model.iter().flat_map(|model| model.states.iter().map(|state| state.name.as_str())).collect();
        let (mut of_states, mut others) = (Vec::new(), Vec::new());
        let mut has_own = vec![false; words];
        for (signal, errors) in &sensors {
            let Some((first, length)) = layout.find(signal) else { continue };
            let name = format!("sensor {signal} of agent {}", context.agents[agent].id);
            let stream = RandomStream::new(context.seed, &name);
            let placed = Placed { first, length, sensor: Sensor::new(errors, length, context.timing.dt, stream) };
            has_own[first..first + length].fill(true);
            if state_names.contains(&signal.as_str()) { of_states.push(placed) } else { others.push(placed) }
        }
        let derived = model.filter(|_| !of_states.is_empty()).and_then(|model| Derived::new(model, layout, &has_own));
        // A position that is measured is that of its states, too.
        let copies = model.filter(|_| sensors.contains_key("position")).map(|model| {
            let position = layout.find("position").map_or(0, |(first, _)| first);
            let states = model.position_states.iter().filter_map(|&state| layout.find(state_names[state]));
            (position..).zip(states).filter(|(_, (to, _))| !has_own[*to]).map(|(from, (to, _))| (from, to)).collect()
        });
        Ok(Self {
            source: Slice::new(place, 0, words),
            out: Slice::new(place, 0, words),
            values: vec![0.0; words],
            of_states,
            derived,
            others,
            copies: copies.unwrap_or_default(),
        })
    }

    fn update(&mut self, step: &Step, truth: &[f64]) {
        self.values.copy_from_slice(truth);
        let measure = |sensors: &mut [Placed], values: &mut [f64]| {
            for Placed { first, length, sensor } in sensors {
                let place = *first..*first + *length;
                sensor.update(step.index, &truth[place.clone()], &mut values[place]);
            }
        };
        measure(&mut self.of_states, &mut self.values);
        if let Some(derived) = &mut self.derived {
            derived.update(step.time(), &mut self.values);
        }
        measure(&mut self.others, &mut self.values);
        for &(from, to) in &self.copies {
            self.values[to] = self.values[from];
        }
    }
}

impl Derived {
    fn new(model: &Arc<Model>, layout: &Layout, has_own: &[bool]) -> Option<Self> {
        let (states, _) = layout.find(&model.states.first()?.name)?;
        let vectors = [("position", &model.position), ("velocity", &model.velocity)].into_iter();
        let outputs = model.outputs.iter().map(|output| (output.field.name.as_str(), &output.formulas));
        let mut formulas = Vec::new();
        for (name, list) in vectors.chain(outputs) {
            let Some((first, _)) = layout.find(name) else { continue };
            formulas.extend((first..).zip(list.iter().cloned()).filter(|(place, _)| !has_own[*place]));
        }
        let mut slots = model.start();
        // What depends on the inputs is not known to sensors of states.
        model.inputs_mut(&mut slots).fill(f64::NAN);
        Some(Self { model: Arc::clone(model), slots, states, formulas })
    }

    fn update(&mut self, time: f64, values: &mut [f64]) {
        let states = self.states..self.states + self.model.states.len();
        self.model.set(&mut self.slots, time, &values[states]);
        for (place, formula) in &self.formulas {
            let value = formula.evaluate(&self.slots);
            if !value.is_nan() {
                values[*place] = value;
            }
        }
    }
}

impl Participant for SensorsParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for agent in &mut self.agents {
            agent.update(step, io.slice(agent.source));
            io.slice_mut(agent.out).copy_from_slice(&agent.values);
        }
        Ok(())
    }
}
