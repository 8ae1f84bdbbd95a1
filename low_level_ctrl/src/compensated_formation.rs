//! The formation controllers of section 5.4: feedback of an observer's estimate, and an auxiliary variable that takes up what the
//! actuators cannot deliver.

use formation::config::Diagonal;
use formation::math::clip_vector;
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::LocalError;
use crate::speed_vehicle::{require_speed_vehicles, speed_vehicle};

/// Gains and options of the controller; each gain a number or one per coordinate.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompensatedFormation {
    /// Whether the observer's estimate is fed back: OBFC and COBFC.
    pub feedback: bool,
    /// Whether the auxiliary variable compensates the saturation: CFC and COBFC.
    pub compensator: bool,
    /// ke, gain of the local error, 1/s.
    pub ke: Diagonal,
    /// kξ, gain of the auxiliary variable, 1/s.
    pub kxi: Diagonal,
    /// η7, how strongly the auxiliary variable takes up the clipped input.
    pub eta7: Diagonal,
    /// η8, its decay, 1/s.
    pub eta8: Diagonal,
}

/// The gains as vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensatedGains {
    /// ke.
    pub error: Vector3<f64>,
    /// kξ; 0 without the compensator.
    pub auxiliary: Vector3<f64>,
    /// η7; 0 without the compensator.
    pub uptake: Vector3<f64>,
    /// η8.
    pub decay: Vector3<f64>,
    /// UM, the limit of the actuators, m/s.
    pub limit: f64,
}

/// The controller of one agent. Measurements may come at any interval.
#[derive(Clone, Debug)]
pub struct CompensatedFormationController {
    gains: CompensatedGains,
    vehicle: Omni,
    /// u, wheel speeds within the limit, m/s.
    pub input: Vector3<f64>,
    /// u_nom, wheel speeds without the limit, m/s.
    pub nominal: Vector3<f64>,
    /// ξ, the auxiliary variable.
    pub auxiliary: Vector3<f64>,
}

impl CompensatedFormationController {
    /// A controller for `vehicle`, as known.
    pub fn new(gains: CompensatedGains, vehicle: Omni) -> Self {
        let zero = Vector3::zeros();
        Self { gains, vehicle, input: zero, nominal: zero, auxiliary: zero }
    }

    /// Computes the input from the heading, the reference velocity, the local error and the estimated uncertainty (0 if it is
    /// not fed back).
    pub fn update(
        &mut self,
        heading: f64,
        reference_velocity: &Vector3<f64>,
        error: &Vector3<f64>,
        estimate: &Vector3<f64>,
    ) {
        let gains = &self.gains;
        self.nominal = self.vehicle.inverse(heading)
            * (reference_velocity
                - gains.error.component_mul(error)
                - estimate
                - gains.auxiliary.component_mul(&self.auxiliary)); // (5.39) to (5.41)
        self.input = clip_vector(&self.nominal, gains.limit); // (5.2)
    }

    /// Advances the auxiliary variable by `dt` seconds, with what [`CompensatedFormationController::update`] clipped at this heading.
    pub fn advance(&mut self, dt: f64, heading: f64) {
        let gains = &self.gains;
        let lost = self.vehicle.matrix(heading) * (self.nominal - self.input);
        self.auxiliary += dt * (gains.uptake.component_mul(&lost) - gains.decay.component_mul(&self.auxiliary));
    }
}

impl Component for CompensatedFormation {
    fn check(&self, context: &Context) -> Checks {
        let gains = [("ke", &self.ke), ("kxi", &self.kxi), ("eta7", &self.eta7), ("eta8", &self.eta8)];
        let checks = require_speed_vehicles(Checks::default(), context);
        let checks = gains.into_iter().fold(checks, |checks, (field, gain)| {
            let problem = gain.problem(3);
            checks.require(problem.is_none(), field, problem.unwrap_or_default())
        });
        let limited = context.input_limit.is_some();
        checks.require(limited, "/vehicle", "missing field `UM`, which this controller needs").led(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let compensating = |gain: &Diagonal| if self.compensator { gain.vector() } else { Ok(Vector3::zeros()) };
        let gains = CompensatedGains {
            error: self.ke.vector().map_err(Refusal)?,
            auxiliary: compensating(&self.kxi).map_err(Refusal)?,
            uptake: compensating(&self.eta7).map_err(Refusal)?,
            decay: self.eta8.vector().map_err(Refusal)?,
            limit: context.input_limit.unwrap_or(f64::INFINITY),
        };
        Ok(Box::new(CompensatedFormationParticipant {
            controller: CompensatedFormationController::new(gains, speed_vehicle(context, agent)?),
            error: LocalError::new(context, agent, bind, "position")?,
            position: bind.state(agent, "position")?,
            reference_velocity: bind.reference(agent, "velocity")?,
            estimate: if self.feedback { Some(bind.estimate(agent, "disturbance")?) } else { None },
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

/// What a step results in.
struct Outcome {
    input: Vector3<f64>,
    error: Vector3<f64>,
    nominal: Vector3<f64>,
    /// ξ.
    auxiliary: Vector3<f64>,
}

fn published(context: &Context, agent: usize) -> Outputs<Outcome> {
    Outputs::new()
        .field(context.agents[agent].vehicle.input_field(), |outcome: &Outcome| outcome.input)
        .vector("error", "m, m, rad", |outcome| outcome.error)
        .vector("nominal", "m/s", |outcome| outcome.nominal)
        .vector("xi", "m, m, rad", |outcome| outcome.auxiliary)
}

struct CompensatedFormationParticipant {
    controller: CompensatedFormationController,
    error: LocalError,
    position: In<3>,
    reference_velocity: In<3>,
    estimate: Option<In<3>>,
    outputs: BoundOutputs<Outcome>,
}

impl Participant for CompensatedFormationParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let error = self.error.local(io);
        let [_, _, heading] = io.get(self.position);
        let estimate = self.estimate.map_or(Vector3::zeros(), |signal| Vector3::from(io.get(signal)));
        let controller = &mut self.controller;
        controller.update(heading, &io.get(self.reference_velocity).into(), &error, &estimate);
        let CompensatedFormationController { input, nominal, auxiliary, .. } = *controller;
        self.outputs.write(io, &Outcome { input, error, nominal, auxiliary });
        controller.advance(step.dt, heading);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::vehicle::Drive;
    use proptest::prelude::*;

    fn controller() -> CompensatedFormationController {
        let gains = CompensatedGains {
            error: Vector3::new(1.0, 1.0, 0.5),
            auxiliary: Vector3::repeat(2.0),
            uptake: Vector3::new(6.0, 6.0, 1.0),
            decay: Vector3::repeat(0.5),
            limit: 0.2,
        };
        let vehicle = Omni { drive: Drive::Speed, radius: 0.13, mass: 1.0, inertia: 1.0, friction: 0.0 };
        CompensatedFormationController::new(gains, vehicle)
    }

    proptest! {
        /// With η8 > 0 the auxiliary variable lowers the demand until it saturates less, and it never grows beyond the demand.
        #[test]
        fn the_auxiliary_variable_is_bounded(
            heading in -7.0..7.0f64,
            error in proptest::array::uniform3(-3.0..3.0f64),
        ) {
            let mut controller = controller();
            let error = Vector3::from(error);
            controller.update(heading, &Vector3::zeros(), &error, &Vector3::zeros());
            let demanded = (controller.nominal - controller.input).norm();
            for _ in 0..5000 {
                controller.update(heading, &Vector3::zeros(), &error, &Vector3::zeros());
                prop_assert!(controller.input.amax() <= 0.2);
                controller.advance(1e-3, heading);
                prop_assert!(controller.auxiliary.norm() <= 3.0 * error.norm());
            }
            prop_assert!((controller.nominal - controller.input).norm() <= demanded);
        }

        #[test]
        fn it_dies_out_once_nothing_saturates(xi in proptest::array::uniform3(-0.01..0.01f64), dt in 1e-3..0.05f64) {
            let mut controller = controller();
            controller.auxiliary = xi.into();
            controller.update(0.3, &Vector3::zeros(), &Vector3::zeros(), &Vector3::zeros());
            prop_assert_eq!(controller.input, controller.nominal);
            controller.advance(dt, 0.3);
            prop_assert!((controller.auxiliary - (1.0 - 0.5 * dt) * Vector3::from(xi)).norm() < 1e-15);
        }
    }

    #[test]
    fn one_step_by_hand() {
        let mut controller = controller();
        controller.auxiliary = Vector3::new(0.1, 0.0, -0.1);
        let (rate, error, estimate) =
            (Vector3::new(0.1, 0.2, 0.0), Vector3::new(0.5, -0.5, 0.2), Vector3::new(0.05, 0.0, -0.05));
        controller.update(0.4, &rate, &error, &estimate);
        let wanted = Vector3::new(0.1 - 0.5 - 0.05 - 0.2, 0.2 + 0.5, -0.1 + 0.05 + 0.2);
        let matrix = controller.vehicle.matrix(0.4);
        assert!((matrix * controller.nominal - wanted).norm() < 1e-14);
        let lost = wanted - matrix * controller.input;
        let expected = Vector3::new(0.1 + 0.01 * (6.0 * lost.x - 0.05), 0.06 * lost.y, -0.1 + 0.01 * (lost.z + 0.05));
        controller.advance(0.01, 0.4);
        assert!((controller.auxiliary - expected).norm() < 1e-14, "{}", controller.auxiliary);
    }
}
