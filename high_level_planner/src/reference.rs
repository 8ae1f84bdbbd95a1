//! The planner without a plan of its own: publishes the reference of the scenario.

use formation::formula::Jet;
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{Trajectory, TrajectorySample};

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

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        published().fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let trajectories =
            agents.iter().map(|&agent| Ok((Trajectory::new(context, agent), published().bind(agent, bind)?)));
        Ok(Box::new(ReferenceParticipant { trajectories: trajectories.collect::<Result<_, Refusal>>()? }))
    }
}

fn published() -> Outputs<TrajectorySample> {
    Outputs::new()
        .vector("position", "", |sample: &TrajectorySample| sample.position)
        .vector("velocity", "", |sample| sample.velocity)
        .vector("acceleration", "", |sample| sample.acceleration)
        .vector("jerk", "", |sample| sample.jerk)
}

struct ReferenceParticipant {
    trajectories: Vec<(Trajectory, BoundOutputs<TrajectorySample>)>,
}

impl Participant for ReferenceParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for (trajectory, outputs) in &self.trajectories {
            outputs.write(io, &trajectory.at(step.time()));
        }
        Ok(())
    }
}
