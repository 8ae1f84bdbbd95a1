//! The planner without a plan of its own: publishes the reference of the scenario.

use formation::formula::Jet;
use formation::scenario::Context;
use formation::wiring::{Bind, Checks, Component, Refusal};
use lockstep::{Fault, Field, Io, Out, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::Trajectory;

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
        ["position", "velocity", "acceleration", "jerk"].map(|name| Field::vector(name, 3, "")).into()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let published = agents.iter().map(|&agent| {
            let mut out = |name| bind.out(agent, name);
            let ports = [out("position")?, out("velocity")?, out("acceleration")?, out("jerk")?];
            Ok((Trajectory::new(context, agent), ports))
        });
        Ok(Box::new(ReferenceParticipant { published: published.collect::<Result<_, Refusal>>()? }))
    }
}

struct ReferenceParticipant {
    published: Vec<(Trajectory, [Out<3>; 4])>,
}

impl Participant for ReferenceParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for (trajectory, [position, velocity, acceleration, jerk]) in &self.published {
            let sample = trajectory.at(step.time());
            io.set(*position, sample.position.into());
            io.set(*velocity, sample.velocity.into());
            io.set(*acceleration, sample.acceleration.into());
            io.set(*jerk, sample.jerk.into());
        }
        Ok(())
    }
}
