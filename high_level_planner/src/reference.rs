//! The planner without a plan of its own: publishes the reference of the scenario.

use formation::formula::{Formula, Jet};
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

/// Has no parameters.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {}

impl Component for Reference {
    /// The third derivative, which only this planner publishes; the others are checked with the formulas.
    fn check(&self, context: &Context) -> Checks {
        let finding = context.reference.iter().enumerate().find_map(|(agent, formulas)| {
            let jets = formulas.iter().map(|formula| formula.evaluate_jet(&[Jet::time(0.0)]));
            jets.enumerate().find_map(|(coordinate, jet)| {
                let others = [jet.value, jet.rate, jet.acceleration];
                let only_jerk = others.iter().all(|value| value.is_finite()) && !jet.jerk.is_finite();
                only_jerk.then_some((agent + 1, coordinate + 1, jet.jerk))
            })
        });
        let Some((agent, coordinate, jerk)) = finding else { return Checks::default() };
        let message = format!("its third derivative is {jerk} at t = 0 for agent {agent}");
        Checks::default().require(false, &format!("/reference.position.{coordinate}"), message)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let references = agents.iter().map(|&agent| {
            let formulas = context.reference[agent].clone();
            let jets = vec![Jet::constant(0.0); formulas.len()];
            Ok(AgentReference { formulas, jets, outputs: published(context, agent).bind(agent, bind)? })
        });
        Ok(Box::new(ReferenceParticipant { references: references.collect::<Result<_, Refusal>>()? }))
    }
}

/// Each coordinate with its first three derivatives.
fn published(context: &Context, agent: usize) -> Outputs<Vec<Jet>> {
    let length = context.reference[agent].len();
    let each = |value: fn(&Jet) -> f64| {
        move |jets: &Vec<Jet>, place: &mut [f64]| {
            place.iter_mut().zip(jets).for_each(|(place, jet)| *place = value(jet));
        }
    };
    Outputs::new()
        .slice("position", length, "", each(|jet| jet.value))
        .slice("velocity", length, "", each(|jet| jet.rate))
        .slice("acceleration", length, "", each(|jet| jet.acceleration))
        .slice("jerk", length, "", each(|jet| jet.jerk))
}

struct ReferenceParticipant {
    references: Vec<AgentReference>,
}

/// The reference of one agent.
struct AgentReference {
    formulas: Vec<Formula>,
    jets: Vec<Jet>,
    outputs: BoundOutputs<Vec<Jet>>,
}

impl Participant for ReferenceParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for AgentReference { formulas, jets, outputs } in &mut self.references {
            for (jet, formula) in jets.iter_mut().zip(&*formulas) {
                *jet = formula.evaluate_jet(&[Jet::time(step.time())]);
            }
            outputs.write(io, jets);
        }
        Ok(())
    }
}
