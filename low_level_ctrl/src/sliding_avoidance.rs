//! The distributed sliding mode controller of chapter 3: forms up with the neighbours, cancels the estimated disturbances,
//! and is pushed off obstacles by their potential fields.

use formation::config::PerAgent;
use formation::math::PotentialField;
use formation::nalgebra::{Vector2, Vector3};
use formation::scenario::{Boundary, Context};
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::LocalError;

/// Gains and options of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlidingAvoidance {
    /// c, gain of the sliding variable, 1/s; one number for all agents or one each.
    pub c: PerAgent,
    /// λ, slope of the sliding surface, 1/s; likewise.
    pub lam: PerAgent,
    /// α, strength of the potential fields, m²/s².
    pub apf: f64,
    /// Whether obstacles repel.
    pub use_apf: bool,
    /// Whether the estimates of an observer are used; without them, all disturbances count as 0.
    pub use_do: bool,
}

/// The signals of one instant that the law needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AvoidanceSignals {
    /// x, m and rad.
    pub position: Vector3<f64>,
    /// δx = x - xd.
    pub deviation: Vector3<f64>,
    /// δv = v - dxd/dt.
    pub velocity_deviation: Vector3<f64>,
    /// ex, local error of δx.
    pub error: Vector3<f64>,
    /// ev, local error of δv.
    pub velocity_error: Vector3<f64>,
    /// ed, local error of d̂. (3.9)
    pub mismatched_error: Vector3<f64>,
    /// Second derivative of xd.
    pub reference_acceleration: Vector3<f64>,
    /// d̂, mismatched disturbance.
    pub mismatched: Vector3<f64>,
    /// Rate of d̂.
    pub mismatched_rate: Vector3<f64>,
    /// ŵ, matched disturbance.
    pub disturbance: Vector3<f64>,
}

/// Gains of one agent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingAvoidanceGains {
    /// c, 1/s.
    pub c: f64,
    /// λ, 1/s.
    pub lambda: f64,
    /// α, m²/s².
    pub repulsion: f64,
}

/// The controller of one robot.
#[derive(Clone, Debug)]
pub struct SlidingAvoidanceController {
    gains: SlidingAvoidanceGains,
    vehicle: Omni,
    /// Centre and field of every obstacle.
    fields: Vec<(Vector2<f64>, PotentialField)>,
    /// u, the input.
    pub input: Vector3<f64>,
    /// s, the sliding variable.
    pub sliding: Vector3<f64>,
    /// F, what the obstacles add to the acceleration.
    pub repulsion: Vector3<f64>,
}

impl SlidingAvoidanceController {
    /// A controller for `vehicle` that is repelled by what is within these boundaries.
    pub fn new(gains: SlidingAvoidanceGains, vehicle: Omni, boundaries: &[Boundary]) -> Self {
        let field = |boundary: &Boundary| {
            let Boundary { centre, inner, outer } = *boundary;
            (centre, PotentialField { strength: gains.repulsion, inner, outer })
        };
        let zero = Vector3::zeros();
        Self {
            gains,
            vehicle,
            fields: boundaries.iter().map(field).collect(),
            input: zero,
            sliding: zero,
            repulsion: zero,
        }
    }

    /// Computes the input.
    pub fn update(&mut self, signals: &AvoidanceSignals) {
        let SlidingAvoidanceGains { c, lambda, .. } = self.gains;
        self.sliding = signals.velocity_error + signals.mismatched_error + lambda * signals.error; // (3.10)
        self.repulsion = self.repulsion_at(&signals.position.xy());
        let acceleration = -c * self.sliding
            - signals.disturbance
            - signals.mismatched_rate
            - lambda * signals.velocity_deviation
            - lambda * signals.mismatched
            - signals.deviation
            + signals.reference_acceleration
            + self.repulsion;
        self.input = self.vehicle.inverse(signals.position.z) * acceleration; // (3.13)
    }

    /// F, the sum of all fields; nothing pushes the heading. (3.6)
    fn repulsion_at(&self, place: &Vector2<f64>) -> Vector3<f64> {
        let mut sum = Vector2::zeros();
        for (centre, field) in &self.fields {
            sum += field.force(&(place - centre));
        }
        Vector3::new(sum.x, sum.y, 0.0)
    }
}

impl Component for SlidingAvoidance {
    fn check(&self, context: &Context) -> Checks {
        let obstacles = context.obstacles.is_some() || !self.use_apf;
        Checks::default()
            .positive_each("c", &self.c, context)
            .positive_each("lam", &self.lam, context)
            .not_negative("apf", self.apf)
            .require(obstacles, "use_apf", "needs the section `[obstacles]`: p_obs, r_obs, eps1, eps2")
            .strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let omni = context.agents[agent].nominal.omni().filter(|omni| omni.order() == 2).ok_or_else(|| {
            Refusal(
                "the controller `sliding_avoidance` drives ground robots of order 2; this vehicle is not one".into(),
            )
        })?;
        let obstacles = context.obstacles.as_ref().filter(|_| self.use_apf);
        let boundaries = obstacles.map_or_else(Vec::new, |obstacles| obstacles.boundaries(omni.radius));
        let of = |rule| context.value(rule, agent).map_err(Refusal);
        let gains = SlidingAvoidanceGains { c: of(&self.c)?, lambda: of(&self.lam)?, repulsion: self.apf };
        Ok(Box::new(SlidingAvoidanceParticipant {
            controller: SlidingAvoidanceController::new(gains, omni.clone(), &boundaries),
            position: bind.state(agent, "position")?,
            position_error: LocalError::new(context, agent, bind, "position")?,
            velocity_error: LocalError::new(context, agent, bind, "velocity")?,
            reference_acceleration: bind.reference(agent, "acceleration")?,
            estimates: self.use_do.then(|| Estimates::new(context, agent, bind)).transpose()?,
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

/// What a step results in.
struct Outcome {
    input: Vector3<f64>,
    sliding: Vector3<f64>,
    error: Vector3<f64>,
    repulsion: Vector3<f64>,
}

fn published(context: &Context, agent: usize) -> Outputs<Outcome> {
    Outputs::new()
        .field(context.agents[agent].vehicle.input_field(), |outcome: &Outcome| outcome.input)
        .vector("sliding", "m/s, m/s, rad/s", |outcome| outcome.sliding)
        .vector("error", "m, m, rad", |outcome| outcome.error)
        .vector("repulsion", "m/s^2, m/s^2, rad/s^2", |outcome| outcome.repulsion)
}

struct SlidingAvoidanceParticipant {
    controller: SlidingAvoidanceController,
    position: In<3>,
    position_error: LocalError,
    velocity_error: LocalError,
    reference_acceleration: In<3>,
    /// `None`: all disturbances count as 0.
    estimates: Option<Estimates>,
    outputs: BoundOutputs<Outcome>,
}

/// What observers say: the own one, and those of the neighbours.
struct Estimates {
    mismatched: LocalError,
    mismatched_rate: In<3>,
    disturbance: In<3>,
}

impl Estimates {
    fn new(context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        Ok(Self {
            mismatched: LocalError::of_estimates(context, agent, bind, "mismatched")?,
            mismatched_rate: bind.estimate(agent, "mismatched_rate")?,
            disturbance: bind.estimate(agent, "disturbance")?,
        })
    }
}

impl Participant for SlidingAvoidanceParticipant {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let estimated = |of: fn(&Estimates, &Io) -> Vector3<f64>| {
            self.estimates.as_ref().map_or_else(Vector3::zeros, |estimates| of(estimates, io))
        };
        let signals = AvoidanceSignals {
            position: io.get(self.position).into(),
            deviation: self.position_error.own(io),
            velocity_deviation: self.velocity_error.own(io),
            error: self.position_error.local(io),
            velocity_error: self.velocity_error.local(io),
            mismatched_error: estimated(|estimates, io| estimates.mismatched.local(io)),
            reference_acceleration: io.get(self.reference_acceleration).into(),
            mismatched: estimated(|estimates, io| estimates.mismatched.own(io)),
            mismatched_rate: estimated(|estimates, io| io.get(estimates.mismatched_rate).into()),
            disturbance: estimated(|estimates, io| io.get(estimates.disturbance).into()),
        };
        let controller = &mut self.controller;
        controller.update(&signals);
        let SlidingAvoidanceController { input, sliding, repulsion, .. } = *controller;
        self.outputs.write(io, &Outcome { input, sliding, error: signals.error, repulsion });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use formation::vehicle::Drive;
    use proptest::prelude::*;

    use super::*;

    const GAINS: SlidingAvoidanceGains = SlidingAvoidanceGains { c: 2.0, lambda: 3.0, repulsion: 0.05 };

    fn robot() -> Omni {
        Omni { drive: Drive::Force, radius: 0.25, mass: 5.0, inertia: 0.15, friction: 0.0 }
    }

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        [-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64].prop_map(Vector3::from)
    }

    proptest! {
        /// An agent that hears the reference only, with weight 1, and whose observer is right: the law leaves ds/dt = -c s - δx.
        /// This fixes the sign of every term of (3.13).
        #[test]
        fn the_sliding_variable_decays(position in vector(), velocity in vector(), d in vector(), d_rate in vector(), w in vector(), acceleration in vector()) {
            let mut controller = SlidingAvoidanceController::new(GAINS, robot(), &[]);
            let (deviation, velocity_deviation) = (position, velocity);
            controller.update(&AvoidanceSignals {
                position,
                deviation,
                velocity_deviation,
                error: deviation,
                velocity_error: velocity_deviation,
                mismatched_error: d,
                reference_acceleration: acceleration,
                mismatched: d,
                mismatched_rate: d_rate,
                disturbance: w,
            });
            prop_assert!((controller.sliding - (velocity + d + GAINS.lambda * position)).norm() < 1e-12);
            let deviation_rate = velocity_deviation + d;
            let velocity_deviation_rate = robot().matrix(position.z) * controller.input + w - acceleration;
            let rate = velocity_deviation_rate + d_rate + GAINS.lambda * deviation_rate;
            prop_assert!((rate + GAINS.c * controller.sliding + deviation).norm() < 1e-9);
        }
    }

    /// At rest on the reference, only the obstacle acts: it pushes away from its centre.
    #[test]
    fn obstacles_push_away() {
        let zero = Vector3::zeros();
        let position = Vector3::new(1.0, 2.0, 0.4);
        let still = AvoidanceSignals {
            position,
            deviation: zero,
            velocity_deviation: zero,
            error: zero,
            velocity_error: zero,
            mismatched_error: zero,
            reference_acceleration: zero,
            mismatched: zero,
            mismatched_rate: zero,
            disturbance: zero,
        };
        let boundary = Boundary { centre: Vector2::new(1.0, 2.75), inner: 0.5, outer: 1.0 };
        let mut controller = SlidingAvoidanceController::new(GAINS, robot(), &[boundary]);
        controller.update(&still);
        let acceleration = robot().matrix(position.z) * controller.input;
        let expected = Vector3::new(0.0, -0.05 * 0.25 / 0.0625, 0.0);
        assert!((acceleration - expected).norm() < 1e-12, "{acceleration}");
        assert_eq!(controller.sliding, zero);
    }
}
