//! Declared ranges: an output that leaves its own stops the run where it arises.

use lockstep::{Fault, Io, Layout, Node, Participant, Slice, Step};

use super::{Role, Signals};
use crate::config::{Problem, did_you_mean};
use crate::scenario::{FieldRange, Scenario};

/// A participant whose outputs are compared with their ranges.
struct Ranged {
    inner: Box<dyn Participant>,
    checks: Vec<Check>,
}

/// A field of an output and its range.
#[derive(Debug)]
struct Check {
    place: Slice,
    topic: String,
    field: String,
    min: f64,
    max: f64,
}

impl Participant for Ranged {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        self.inner.step(step, io)?;
        for check in &self.checks {
            let words = io.slice_mut(check.place);
            // NaN and infinity are reported by the check that follows this one everywhere.
            let beyond = |word: &f64| *word < check.min || *word > check.max;
            if let Some(at) = words.iter().position(beyond) {
                return Err(check.fault(at, words[at]));
            }
        }
        Ok(())
    }
}

impl Check {
    #[cold]
    fn fault(&self, at: usize, value: f64) -> Fault {
        let Self { topic, field, min, max, place } = self;
        let label = if place.length == 1 { field.clone() } else { format!("{field}[{at}]") };
        let range = match (*min, *max) {
            (f64::NEG_INFINITY, max) => format!("<= {max}"),
            (min, f64::INFINITY) => format!(">= {min}"),
            (min, max) => format!("{min} ... {max}"),
        };
        Fault(format!("output {topic}: {label} is {value}, outside its range {range} ([ranges] of the scenario)"))
    }
}

/// The participant of `role` in the place of `node`, with the ranges that the scenario declares for its outputs.
pub(super) fn guard(
    scenario: &Scenario,
    signals: &Signals,
    role: Role,
    node: &Node,
    inner: Box<dyn Participant>,
) -> Box<dyn Participant> {
    let mut checks = Vec::new();
    for range in scenario.ranges.iter().filter(|range| range.topic == role.channel()) {
        for (port, output) in node.outputs.iter().enumerate() {
            let channel = &signals.channels[output.0];
            if let Some((offset, length)) = channel.layout.find(&range.field) {
                let (topic, field) = (channel.topic.clone(), range.field.clone());
                let place = Slice::new(port, offset, length);
                checks.push(Check { place, topic, field, min: range.min, max: range.max });
            }
        }
    }
    if checks.is_empty() { inner } else { Box::new(Ranged { inner, checks }) }
}

/// What is wrong with the ranges of a scenario: those of topics or fields that no participant publishes.
pub(super) fn check(scenario: &Scenario, signals: &Signals) -> Vec<Problem> {
    scenario.ranges.iter().filter_map(|range| unknown(scenario, signals, range)).collect()
}

fn unknown(scenario: &Scenario, signals: &Signals, range: &FieldRange) -> Option<Problem> {
    let FieldRange { topic, field, .. } = range;
    let problem = |message: String| Some(scenario.problem("ranges", format!("{topic}.{field}: {message}")));
    let Some(role) = Role::ALL.into_iter().find(|role| role.channel() == topic) else {
        let hint = did_you_mean(topic, Role::ALL.map(Role::channel));
        return problem(format!("expected a field of state, reference, estimate or command{hint}"));
    };
    let published = signals.ids.iter().zip(&signals.channels).filter(|(id, _)| id.is_some_and(|(by, _)| by == role));
    let layouts: Vec<&Layout> = published.map(|(_, channel)| &channel.layout).collect();
    if layouts.iter().any(|layout| layout.find(field).is_some()) {
        return None;
    }
    let mut names: Vec<&str> = layouts.iter().flat_map(|l| l.fields()).map(|field| field.name.as_str()).collect();
    names.dedup();
    let hint = did_you_mean(field, names);
    problem(format!("the {role} of this scenario publishes no such field{hint}"))
}
