//! The formation controller with an anti-windup compensator, its inputs clipped (CFC) or regulated (LPBCFC). (6.23), (6.24)

use formation::math::{clip_vector, regulate};
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::sliding_feedback::{FormationInputs, published, vehicle};
use crate::{Command, FormationErrors, SlidingFeedback};

/// What becomes of a command beyond the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Regulation {
    /// Every element is clipped by itself.
    Clip,
    /// The linear program of Algorithm 3.
    LinearProgram,
}

/// Gains and options of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SaturatedCompensated {
    /// c, gain of the sliding variable, 1/s.
    pub c: f64,
    /// λ, slope of the sliding surface, 1/s.
    pub lam: f64,
    /// η3, sensitivity of the compensator to what the actuators cannot do.
    pub eta3: f64,
    /// η4, rate at which the compensator decays, 1/s.
    pub eta4: f64,
    /// What becomes of a command beyond the limits.
    pub regulation: Regulation,
}

/// The controller of one robot.
#[derive(Clone, Debug)]
pub struct SaturatedCompensatedController {
    gains: SaturatedCompensated,
    feedback: SlidingFeedback,
    vehicle: Omni,
    limit: f64,
    /// ξ, the state of the compensator.
    pub compensator: Vector3<f64>,
}

impl SaturatedCompensatedController {
    /// A controller of `vehicle`, whose inputs end at `limit`.
    pub fn new(gains: SaturatedCompensated, vehicle: Omni, limit: f64) -> Self {
        let feedback = SlidingFeedback { gain: gains.c, slope: gains.lam };
        Self { gains, feedback, vehicle, limit, compensator: Vector3::zeros() }
    }

    /// The input at `heading` (rad) for these errors and the estimated `disturbance`.
    pub fn update(&self, errors: &FormationErrors, heading: f64, disturbance: &Vector3<f64>) -> Command {
        let acceleration = self.feedback.acceleration(errors, disturbance) - self.gains.c * self.compensator;
        let demanded = self.vehicle.inverse(heading) * acceleration; // (6.23)
        let input = match self.gains.regulation {
            Regulation::Clip => clip_vector(&demanded, self.limit),
            Regulation::LinearProgram => regulate(&self.vehicle.matrix(heading), &demanded, self.limit), // (6.28)
        };
        Command { input, demanded, sliding: self.feedback.sliding(errors) }
    }

    /// Advances the compensator by `dt` seconds with the demand of this instant. What drives it is the excess over the plain
    /// limits, however the input is regulated.
    pub fn advance(&mut self, dt: f64, heading: f64, demanded: &Vector3<f64>) {
        let excess = demanded - clip_vector(demanded, self.limit);
        let SaturatedCompensated { eta3, eta4, .. } = self.gains;
        self.compensator += dt * (eta3 * (self.vehicle.matrix(heading) * excess) - eta4 * self.compensator); // (6.24)
    }
}

impl Component for SaturatedCompensated {
    fn check(&self, context: &Context) -> Checks {
        Checks::default()
            .positive("c", self.c)
            .positive("lam", self.lam)
            .not_negative("eta3", self.eta3)
            .not_negative("eta4", self.eta4)
            .strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        [published(context, agent).fields(), published_compensator().fields()].concat()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let (vehicle, limit) = vehicle(context, agent, "saturated_compensated")?;
        Ok(Box::new(SaturatedCompensatedParticipant {
            controller: SaturatedCompensatedController::new(self.clone(), vehicle.clone(), limit),
            inputs: FormationInputs::new(context, agent, bind)?,
            disturbance: bind.estimate(agent, "disturbance")?,
            outputs: published(context, agent).bind(agent, bind)?,
            compensator: published_compensator().bind(agent, bind)?,
        }))
    }
}

fn published_compensator() -> Outputs<SaturatedCompensatedController> {
    Outputs::new().vector("xi", "m/s, m/s, rad/s", |controller: &SaturatedCompensatedController| controller.compensator)
}

struct SaturatedCompensatedParticipant {
    controller: SaturatedCompensatedController,
    inputs: FormationInputs,
    disturbance: In<3>,
    outputs: BoundOutputs<(Command, FormationErrors)>,
    compensator: BoundOutputs<SaturatedCompensatedController>,
}

impl Participant for SaturatedCompensatedParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let errors = self.inputs.errors(io);
        let heading = self.inputs.position(io).z;
        let disturbance = io.get(self.disturbance).into();
        let command = self.controller.update(&errors, heading, &disturbance);
        self.outputs.write(io, &(command, errors));
        self.compensator.write(io, &self.controller);
        self.controller.advance(step.dt, heading, &command.demanded);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::vehicle::Drive;

    fn controller(regulation: Regulation) -> SaturatedCompensatedController {
        let vehicle = Omni { drive: Drive::Force, radius: 0.2, mass: 3.0, inertia: 0.08, friction: 0.0 };
        let gains = SaturatedCompensated { c: 2.0, lam: 2.0, eta3: 1.0, eta4: 0.5, regulation };
        SaturatedCompensatedController::new(gains, vehicle, 1.0)
    }

    fn far_away() -> FormationErrors {
        let error = Vector3::new(2.0, -1.5, 0.6);
        let zero = Vector3::zeros();
        FormationErrors {
            position: error,
            velocity: zero,
            local_position: 2.0 * error,
            local_velocity: zero,
            acceleration: zero,
        }
    }

    /// The compensator settles where it takes all the excess out of the command: η3 g excess = η4 ξ.
    #[test]
    fn the_compensator_settles_at_the_excess() {
        for regulation in [Regulation::Clip, Regulation::LinearProgram] {
            let mut controller = controller(regulation);
            let errors = far_away();
            let zero = Vector3::zeros();
            let before = controller.update(&errors, 0.3, &zero).demanded;
            for _ in 0..20_000 {
                let command = controller.update(&errors, 0.3, &zero);
                controller.advance(1e-3, 0.3, &command.demanded);
            }
            let command = controller.update(&errors, 0.3, &zero);
            let excess = command.demanded - clip_vector(&command.demanded, 1.0);
            let balance = controller.vehicle.matrix(0.3) * excess - 0.5 * controller.compensator;
            assert!(balance.norm() < 1e-6, "{regulation:?}: {balance}");
            assert!(command.demanded.norm() < 0.5 * before.norm());
        }
    }

    /// Straight towards the back of wheel 3, with a little turn: clipped to (1, 1, -1), the wheels turn the robot the other way.
    #[test]
    fn clipping_reverses_what_regulation_does_not() {
        let mut errors = far_away();
        let angle = 0.3 - std::f64::consts::FRAC_PI_6;
        errors.position = Vector3::new(2.0 * libm::cos(angle), 2.0 * libm::sin(angle), 0.05);
        errors.local_position = 2.0 * errors.position;
        let reversed = |regulation| {
            let controller = controller(regulation);
            let command = controller.update(&errors, 0.3, &Vector3::zeros());
            let effect = controller.vehicle.matrix(0.3);
            let (demanded, done) = (effect * command.demanded, effect * command.input);
            (0..3).any(|j| demanded[j] * done[j] < -1e-9)
        };
        assert!(reversed(Regulation::Clip));
        assert!(!reversed(Regulation::LinearProgram));
    }
}
