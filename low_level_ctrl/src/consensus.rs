//! Linear consensus tracking: the plainest formation controller there is, and the example of `docs/adding-a-controller.md`.

use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, Checks, Component, Refusal};
use lockstep::{Fault, Field, In, Io, Out, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::LocalError;

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

impl Consensus {
    /// The acceleration (order 2) or velocity (order 1) that drives the local errors `e_x` and `e_v` to zero: `feedforward` is
    /// that of the reference.
    pub fn demand(&self, feedforward: &Vector3<f64>, e_x: &Vector3<f64>, e_v: &Vector3<f64>) -> Vector3<f64> {
        feedforward - self.k_x * e_x - self.k_v * e_v
    }
}

impl Component for Consensus {
    fn check(&self, context: &Context) -> Checks {
        Checks::default().positive("k_x", self.k_x).not_negative("k_v", self.k_v).strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        vec![context.agents[agent].vehicle.input_field(), Field::vector("error", 3, "m, m, rad")]
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let vehicle = context.agents[agent].nominal.omni().ok_or_else(|| {
            Refusal("the controller `consensus` drives planar robots; a quadcopter needs an attitude loop".into())
        })?;
        let second_order = vehicle.order() == 2;
        Ok(Box::new(ConsensusParticipant {
            law: self.clone(),
            vehicle: vehicle.clone(),
            position: bind.state(agent, "position")?,
            position_error: LocalError::new(context, agent, bind, "position")?,
            velocity_error: second_order.then(|| LocalError::new(context, agent, bind, "velocity")).transpose()?,
            feedforward: bind.reference(agent, if second_order { "acceleration" } else { "velocity" })?,
            input: bind.out(agent, "input")?,
            error: bind.out(agent, "error")?,
        }))
    }
}

struct ConsensusParticipant {
    law: Consensus,
    vehicle: Omni,
    position: In<3>,
    position_error: LocalError,
    velocity_error: Option<LocalError>,
    feedforward: In<3>,
    input: Out<3>,
    error: Out<3>,
}

impl Participant for ConsensusParticipant {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let e_x = self.position_error.local(io);
        let e_v = self.velocity_error.as_ref().map_or_else(Vector3::zeros, |error| error.local(io));
        let demand = self.law.demand(&io.get(self.feedforward).into(), &e_x, &e_v);
        let heading = io.get(self.position)[2];
        io.set(self.input, (self.vehicle.inverse(heading) * demand).into());
        io.set(self.error, e_x.into());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
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
}
