//! The nominal sliding mode formation controller behind saturated actuators (NFC). (6.21), (6.22)

use formation::math::clip_vector;
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::sliding_feedback::{FormationInputs, published, vehicle};
use crate::{Command, FormationErrors, SlidingFeedback};

/// Gains of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SaturatedNominal {
    /// c, gain of the sliding variable, 1/s.
    pub c: f64,
    /// λ, slope of the sliding surface, 1/s.
    pub lam: f64,
}

/// The controller of one robot.
#[derive(Clone, Debug)]
pub struct SaturatedNominalController {
    feedback: SlidingFeedback,
    vehicle: Omni,
    limit: f64,
}

impl SaturatedNominalController {
    /// A controller of `vehicle`, whose inputs end at `limit`.
    pub fn new(feedback: SlidingFeedback, vehicle: Omni, limit: f64) -> Self {
        Self { feedback, vehicle, limit }
    }

    /// The input at `heading` (rad) for these errors and the estimated `disturbance`.
    pub fn update(&self, errors: &FormationErrors, heading: f64, disturbance: &Vector3<f64>) -> Command {
        let acceleration = self.feedback.acceleration(errors, disturbance);
        let demanded = self.vehicle.inverse(heading) * acceleration; // (6.22)
        Command { input: clip_vector(&demanded, self.limit), demanded, sliding: self.feedback.sliding(errors) }
    }
}

impl Component for SaturatedNominal {
    fn check(&self, context: &Context) -> Checks {
        Checks::default().positive("c", self.c).positive("lam", self.lam).strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let (vehicle, limit) = vehicle(context, agent, "saturated_nominal")?;
        let feedback = SlidingFeedback { gain: self.c, slope: self.lam };
        Ok(Box::new(SaturatedNominalParticipant {
            controller: SaturatedNominalController::new(feedback, vehicle.clone(), limit),
            inputs: FormationInputs::new(context, agent, bind)?,
            disturbance: bind.estimate(agent, "disturbance")?,
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

struct SaturatedNominalParticipant {
    controller: SaturatedNominalController,
    inputs: FormationInputs,
    disturbance: In<3>,
    outputs: BoundOutputs<(Command, FormationErrors)>,
}

impl Participant for SaturatedNominalParticipant {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let errors = self.inputs.errors(io);
        let disturbance = io.get(self.disturbance).into();
        let command = self.controller.update(&errors, self.inputs.position(io).z, &disturbance);
        self.outputs.write(io, &(command, errors));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::vehicle::Drive;
    use proptest::prelude::*;

    fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-size..size, -size..size, -size..size].prop_map(Vector3::from)
    }

    proptest! {
        /// Without the limit the closed loop of the sliding variable's agent is what the law says, whatever the heading.
        #[test]
        fn demands_the_acceleration_of_the_law(
            position in vector(2.0), velocity in vector(1.0), others in vector(3.0), disturbance in vector(1.0), heading in -4.0..4.0f64,
        ) {
            let vehicle = Omni { drive: Drive::Force, radius: 0.2, mass: 3.0, inertia: 0.08, friction: 0.0 };
            let feedback = SlidingFeedback { gain: 2.0, slope: 1.5 };
            let errors = FormationErrors {
                position,
                velocity,
                local_position: others,
                local_velocity: 0.5 * others,
                acceleration: Vector3::new(0.1, 0.2, 0.0),
            };
            let controller = SaturatedNominalController::new(feedback, vehicle.clone(), 1.0);
            let command = controller.update(&errors, heading, &disturbance);
            let caused = vehicle.matrix(heading) * command.demanded;
            let expected = Vector3::new(0.1, 0.2, 0.0) - disturbance - 2.0 * (0.5 + 1.5) * others - 1.5 * velocity - position;
            prop_assert!((caused - expected).norm() < 1e-9, "{caused} {expected}");
            prop_assert!(command.input.amax() <= 1.0);
            prop_assert_eq!(command.input, command.demanded.map(|value| value.clamp(-1.0, 1.0)));
        }
    }
}
