//! Linear consensus tracking: the plainest formation controller there is, and the example of `docs/adding-a-controller.md`.

use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::LocalError;

// ANCHOR: parameters
/// Gains of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Consensus {
    /// Gain of the local position error: 1/s for robots of order 1, 1/s² for those of order 2.
    pub k_x: f64,
    /// Gain of the local velocity error, 1/s. Of no use to robots of order 1.
    #[serde(default)]
    pub k_v: f64,
}
// ANCHOR_END: parameters

// ANCHOR: law
impl Consensus {
    /// The acceleration (order 2) or velocity (order 1) that drives the local errors `e_x` and `e_v` to zero: `feedforward` is
    /// that of the reference.
    pub fn demand(&self, feedforward: &Vector3<f64>, e_x: &Vector3<f64>, e_v: &Vector3<f64>) -> Vector3<f64> {
        feedforward - self.k_x * e_x - self.k_v * e_v
    }
}
// ANCHOR_END: law

// ANCHOR: component
impl Component for Consensus {
    fn check(&self, context: &Context) -> Checks {
        Checks::default().positive("k_x", self.k_x).not_negative("k_v", self.k_v).strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let vehicle = context.agents[agent].nominal.omni().ok_or_else(|| {
            let kind = context.agents[agent].vehicle.kind();
            let advice = match context.agents[agent].vehicle.model() {
                Some(_) => "the controller `formulas` has a law for each of its inputs",
                None => "a quadcopter needs an attitude loop",
            };
            Refusal(format!(
                "the controller `consensus` drives planar robots and integrators, not the vehicle `{kind}`; {advice}"
            ))
        })?;
        let second_order = vehicle.order() == 2;
        Ok(Box::new(ConsensusParticipant {
            law: self.clone(),
            vehicle: vehicle.clone(),
            position: bind.state(agent, "position")?,
            position_error: LocalError::new(context, agent, bind, "position")?,
            velocity_error: second_order.then(|| LocalError::new(context, agent, bind, "velocity")).transpose()?,
            feedforward: bind.reference(agent, if second_order { "acceleration" } else { "velocity" })?,
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}
// ANCHOR_END: component

// ANCHOR: outputs
/// What a step results in.
struct Outcome {
    input: Vector3<f64>,
    /// e_x.
    error: Vector3<f64>,
}

/// The outputs: name, unit and value of each.
fn published(context: &Context, agent: usize) -> Outputs<Outcome> {
    Outputs::new().field(context.agents[agent].vehicle.input_field(), |outcome: &Outcome| outcome.input).vector(
        "error",
        "m, m, rad",
        |outcome| outcome.error,
    )
}
// ANCHOR_END: outputs

// ANCHOR: participant
struct ConsensusParticipant {
    law: Consensus,
    vehicle: Omni,
    position: In<3>,
    position_error: LocalError,
    velocity_error: Option<LocalError>,
    feedforward: In<3>,
    outputs: BoundOutputs<Outcome>,
}

impl Participant for ConsensusParticipant {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let e_x = self.position_error.local(io);
        let e_v = self.velocity_error.as_ref().map_or_else(Vector3::zeros, |error| error.local(io));
        let demand = self.law.demand(&io.get(self.feedforward).into(), &e_x, &e_v);
        let heading = io.get(self.position)[2];
        self.outputs.write(io, &Outcome { input: self.vehicle.inverse(heading) * demand, error: e_x });
        Ok(())
    }
}
// ANCHOR_END: participant

#[cfg(test)]
mod tests {
    use formation::wiring::Role;
    use formation::wiring::testing::TestBench;

    use super::*;

    #[test]
    fn errors_are_opposed() {
        let law = Consensus { k_x: 2.0, k_v: 3.0 };
        let zero = Vector3::zeros();
        assert_eq!(law.demand(&zero, &Vector3::new(1.0, 0.0, -1.0), &zero), Vector3::new(-2.0, 0.0, 2.0));
        assert_eq!(law.demand(&zero, &zero, &Vector3::new(0.0, 1.0, 0.0)), Vector3::new(0.0, -3.0, 0.0));
        let feedforward = Vector3::new(0.1, 0.2, 0.3);
        assert_eq!(law.demand(&feedforward, &zero, &zero), feedforward);
    }

    // ANCHOR: test
    /// A robot of order 2 that alone knows the reference, b = 1: its local errors are its own ones.
    #[test]
    fn input_and_error_are_published_under_their_names() {
        let text = r#"
            name = "one"
            agents = [{ position = [0, 0, 0] }]
            timing = { dt = 0.1, duration = 1 }
            vehicle = { kind = "integrator" }
            topology = { b = 1 }
            reference = { position = [0, 0, 0] }
            controller = { kind = "consensus", k_x = 2, k_v = 3 }
        "#;
        let mut bench = TestBench::new(text, Role::Controller, crate::KINDS).unwrap_or_else(|all| panic!("{}", all[0]));
        bench.set(Role::Plant, 0, "position", &[1.0, 0.0, 0.0]);
        bench.set(Role::Plant, 0, "velocity", &[0.0, 1.0, 0.0]);
        bench.step().unwrap();
        assert_eq!(bench.output(0, "error"), [1.0, 0.0, 0.0]);
        assert_eq!(bench.output(0, "input"), [-2.0, -3.0, 0.0]);
    }
    // ANCHOR_END: test
}
