//! The kind `external`: a place in the network without a law, which a program takes.
//!
//! The scenario says what the program publishes and reads. What is read before its first sample comes from a stand-in, which
//! publishes where the agents start.

mod reading;
mod signal;

use std::collections::BTreeMap;

use lockstep::{Fault, Field, Io, MAX_WORDS, Participant, Slice, Step};
use schemars::{JsonSchema, SchemaGenerator};
use serde::Deserialize;

use super::{Bind, Checks, Component, Kind, Refusal, Role};
use crate::config::read;
use crate::formula::{Formula, Jet};
use crate::scenario::{Agent, Context};
use crate::vehicle::Vehicle;
use reading::{Need, Reading};
use signal::Signal;

/// The name of the kind.
pub const EXTERNAL: &str = "external";

/// The kind of every role that a program plays.
pub(super) const KIND: Kind = Kind {
    name: EXTERNAL,
    summary: "no law: a program replaces it ([swap] or --swap), with the signals that the section declares",
    read: |node, path, problems| {
        let role = Role::ALL.into_iter().find(|role| role.name() == path)?;
        let parameters = read::<Parameters>(node, path, problems)?;
        Some(Box::new(External { role, parameters }))
    },
    schema: SchemaGenerator::subschema_for::<Parameters>,
};

/// What a section with `kind = "external"` may say.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Parameters {
    /// Signals that the program publishes besides the standard ones, by name: their size, or a table of `size`, `unit` and
    /// `initial`, the values that are read before its first step (by default zeros).
    #[serde(default)]
    signals: BTreeMap<String, Signal>,
    /// Whether the standard signals of the role are published: `input` of a controller; `position` and `velocity` of a plant or an
    /// observer; `position`, `velocity` and `acceleration` of a planner.
    #[serde(default = "yes")]
    standard: bool,
    /// The participants whose signals the program reads: `plant`, `neighbours.controller@before`, `all.observer`, `planner.1,3-6`. By default those
    /// of its own agent and of the in-neighbours.
    reads: Option<Vec<String>>,
}

fn yes() -> bool {
    true
}

struct External {
    role: Role,
    parameters: Parameters,
}

impl Component for External {
    fn check(&self, context: &Context) -> Checks {
        let mut checks = Checks::default();
        for (name, signal) in &self.parameters.signals {
            checks.findings.extend(signal.findings(name));
        }
        if !checks.findings.is_empty() {
            return checks;
        }
        let agents = 0..context.agents.len();
        let standard: Vec<(usize, Vec<Field>)> = agents
            .map(|agent| (agent, self.standard(context, agent).into_iter().map(|(field, _)| field).collect()))
            .collect();
        for name in self.parameters.signals.keys() {
            if standard.iter().any(|(_, fields)| fields.iter().any(|field| field.name == *name)) {
                let message =
                    format!("`{name}` is a standard signal of a {}; `standard = false` leaves those out", self.role);
                checks.findings.push((format!("signals.{name}"), message));
            }
        }
        let own: usize = self.parameters.signals.values().map(|signal| signal.size).sum();
        let words = |fields: &[Field]| own + fields.iter().map(|field| field.shape.words()).sum::<usize>();
        if let Some((agent, fields)) = standard.iter().find(|(_, fields)| words(fields) > MAX_WORDS) {
            let message = format!(
                "a sample has at most {MAX_WORDS} numbers, and all signals of agent {} together have {}",
                agent + 1,
                words(fields)
            );
            checks.findings.push(("signals".into(), message));
        }
        if own == 0 && !self.parameters.standard {
            let message =
                format!("the {} publishes nothing: declare `signals`, or leave out `standard = false`", self.role);
            checks.findings.push(("standard".into(), message));
        }
        for (number, text) in (1..).zip(self.parameters.reads.iter().flatten()) {
            let reading = Reading::parse(text).and_then(|reading| reading.agents(context, &[]));
            checks = checks.require(reading.is_ok(), &format!("reads.{number}"), reading.err().unwrap_or_default());
        }
        checks
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        self.published(context, agent).into_iter().map(|(field, _)| field).collect()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        for (reading, need) in self.readings()? {
            for agent in reading.agents(context, agents).map_err(Refusal)? {
                match need {
                    Need::IfPublished if !bind.publishes(reading.role, agent) => {}
                    _ => bind
                        .whole(reading.role, agent, reading.timing)
                        .map_err(|Refusal(why)| Refusal::at("reads", why))?,
                }
            }
        }
        let mut initial = Vec::new();
        for &agent in agents {
            for (field, values) in self.published(context, agent) {
                initial.push((bind.slice_out(agent, &field.name, values.len())?, values));
            }
        }
        Ok(Box::new(StandIn { initial }))
    }

    fn is_external(&self) -> bool {
        true
    }
}

impl External {
    fn readings(&self) -> Result<Vec<(Reading, Need)>, Refusal> {
        let Some(texts) = &self.parameters.reads else { return Ok(Reading::usual(self.role)) };
        texts.iter().map(|text| Ok((Reading::parse(text).map_err(Refusal)?, Need::Always))).collect()
    }

    /// All outputs with their initial values.
    fn published(&self, context: &Context, agent: usize) -> Vec<(Field, Vec<f64>)> {
        let own = self.parameters.signals.iter().map(|(name, Signal { size, unit, initial })| {
            (Field::vector(name, *size, unit), initial.clone().unwrap_or_else(|| vec![0.0; *size]))
        });
        self.standard(context, agent).into_iter().chain(own).collect()
    }

    /// The standard outputs of the role with their initial values.
    fn standard(&self, context: &Context, agent: usize) -> Vec<(Field, Vec<f64>)> {
        if !self.parameters.standard {
            return Vec::new();
        }
        let row = &context.agents[agent];
        let mut signals = self.of_role(context, agent, row);
        // Equations may have no place, or no input.
        signals.retain(|(field, _)| field.shape.words() > 0);
        signals
    }

    fn of_role(&self, context: &Context, agent: usize, row: &Agent) -> Vec<(Field, Vec<f64>)> {
        let motion = |position: &[f64], velocity: &[f64]| {
            let [position_unit, velocity_unit] = units(&row.vehicle);
            let mut signals = vec![(Field::vector("position", position.len(), position_unit), position.to_vec())];
            if row.vehicle.order() == 2 {
                signals.push((Field::vector("velocity", velocity.len(), velocity_unit), velocity.to_vec()));
            }
            signals
        };
        match self.role {
            Role::Controller => vec![(row.vehicle.input_field(), vec![0.0; row.vehicle.inputs()])],
            Role::Plant => motion(&row.position, &row.velocity),
            Role::Observer => motion(&row.estimate, &row.estimate_velocity),
            Role::Planner => {
                let at_start = |formula: &Formula| formula.evaluate_jet(&[Jet::time(0.0)]);
                let jets: Vec<Jet> = match context.reference.get(agent) {
                    Some(formulas) => formulas.iter().map(at_start).collect(),
                    None => vec![Jet::constant(0.0); row.vehicle.coordinates()],
                };
                let signal = |name: &str, value: fn(&Jet) -> f64| {
                    (Field::vector(name, jets.len(), ""), jets.iter().map(value).collect())
                };
                vec![
                    signal("position", |jet| jet.value),
                    signal("velocity", |jet| jet.rate),
                    signal("acceleration", |jet| jet.acceleration),
                ]
            }
        }
    }
}

/// Units of the coordinates and the velocities of a vehicle.
fn units(vehicle: &Vehicle) -> [&'static str; 2] {
    match (vehicle.omni(), vehicle.quadcopter()) {
        (Some(_), _) => ["m, m, rad", "m/s, m/s, rad/s"],
        (_, Some(_)) => ["m, rad", "m/s, rad/s"],
        _ => ["", ""],
    }
}

/// Publishes what there is before a program has run.
struct StandIn {
    initial: Vec<(Slice, Vec<f64>)>,
}

impl Participant for StandIn {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        for (place, values) in &self.initial {
            io.slice_mut(*place).copy_from_slice(values);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
