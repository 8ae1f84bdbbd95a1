//! The low-level controller of a quadcopter in section 7.2: position loop, guidance law, attitude loop.

use formation::nalgebra::{Vector3, Vector4, Vector6};
use formation::scenario::Context;
use formation::vehicle::Quadcopter;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{Differentiation, DifferentiatorSettings, SlopePair};

const GRAVITY: f64 = 9.81;

/// How the disturbance estimate is faded in. (7.40)
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Introduction {
    /// At full weight from the start.
    None,
    /// By a logistic function of time.
    Logistic,
    /// (7.40) as printed, which starts at -1.
    Printed,
}

/// Gains and options of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HierarchicalUav {
    /// λp, slope of the position loop's sliding surface, 1/s.
    pub lam_p: f64,
    /// cp, 1/s.
    pub c_p: f64,
    /// kp, 1/s².
    pub k_p: f64,
    /// λa, slope of the attitude loop's sliding surface, 1/s.
    pub lam_a: f64,
    /// ca, 1/s.
    pub c_a: f64,
    /// ka, 1/s².
    pub k_a: f64,
    /// Desired yaw, rad.
    #[serde(default)]
    pub psi_d: f64,
    /// Limit of the rate of the attitude reference, rad/s.
    pub xi1_max: f64,
    /// Limit of its second derivative, rad/s².
    pub xi2_max: f64,
    /// How the estimate is faded in.
    pub intro: Introduction,
    /// γ1, steepness of the introduction, 1/s.
    pub gamma1: f64,
    /// γ2, its middle, s.
    pub gamma2: f64,
    /// How the attitude reference is differentiated.
    pub diff: Differentiation,
    /// Steps over which a smoothed derivative is taken and held.
    pub n_diff: u64,
    /// The position loop runs at every so many steps, and holds the thrust and attitude that it asks for in between.
    #[serde(default = "one")]
    pub position_every: u64,
}

fn one() -> u64 {
    1
}

/// What the controller has to track, and the disturbance that its observer reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UavReference {
    /// x̄, m.
    pub position: Vector3<f64>,
    /// v̄, m/s.
    pub velocity: Vector3<f64>,
    /// ū, m/s².
    pub acceleration: Vector3<f64>,
}

/// The controller of one quadcopter.
#[derive(Clone, Debug)]
pub struct HierarchicalUavController {
    gains: HierarchicalUav,
    vehicle: Quadcopter,
    slopes: SlopePair,
    /// up, the acceleration that the position loop has asked for last.
    push: Vector3<f64>,
    /// (T, τ1, τ2, τ3), N.
    pub input: [f64; 4],
    /// sp.
    pub sliding_position: Vector3<f64>,
    /// ŝa.
    pub sliding_attitude: Vector3<f64>,
    /// ad = (φd, θd, ψd), rad.
    pub attitude_reference: Vector3<f64>,
    /// ξ1, rad/s.
    pub attitude_rate: Vector3<f64>,
    /// ξ2, rad/s².
    pub attitude_acceleration: Vector3<f64>,
}

impl HierarchicalUavController {
    /// A controller for `vehicle`.
    pub fn new(gains: HierarchicalUav, vehicle: Quadcopter) -> Self {
        let settings = DifferentiatorSettings {
            method: gains.diff,
            hold: gains.n_diff,
            rate_limit: gains.xi1_max,
            acceleration_limit: gains.xi2_max,
        };
        let zero = Vector3::zeros();
        Self {
            gains,
            vehicle,
            slopes: SlopePair::new(&settings),
            push: zero,
            input: [0.0; 4],
            sliding_position: zero,
            sliding_attitude: zero,
            attitude_reference: zero,
            attitude_rate: zero,
            attitude_acceleration: zero,
        }
    }

    /// Computes thrust and torques from the measured state, the reference and the estimated disturbance.
    pub fn update(
        &mut self,
        step: &Step,
        coordinates: &Vector6<f64>,
        velocities: &Vector6<f64>,
        reference: &UavReference,
        disturbance: &Vector6<f64>,
    ) {
        let introduced = self.introduction(step.time()) * disturbance;
        let every = self.gains.position_every;
        if step.index.is_multiple_of(every) {
            self.push = self.position_loop(coordinates, velocities, reference, &introduced);
            self.guide();
            // The attitude reference is a signal of the slow loop, and so are its derivatives.
            let (run, period, reference) = (step.index / every, step.dt * every as f64, &self.attitude_reference);
            (self.attitude_rate, self.attitude_acceleration) = self.slopes.update(run, period, reference);
        }
        let turn = self.attitude_loop(coordinates, velocities, &introduced);
        let thrust = self.vehicle.mass * self.push.z / (libm::cos(coordinates[3]) * libm::cos(coordinates[4])); // (7.43)
        let effect = self.vehicle.torque_effect();
        self.input = [thrust, turn[0] / effect[0], turn[1] / effect[1], turn[2] / effect[2]];
    }

    /// f(t). (7.40)
    fn introduction(&self, time: f64) -> f64 {
        let decay = libm::exp(-self.gains.gamma1 * (time - self.gains.gamma2));
        match self.gains.intro {
            Introduction::None => 1.0,
            Introduction::Logistic => 1.0 / (1.0 + decay),
            Introduction::Printed => (1.0 - decay) / (1.0 + decay),
        }
    }

    /// up, the acceleration that the position loop asks for. (7.41)
    fn position_loop(
        &mut self,
        coordinates: &Vector6<f64>,
        velocities: &Vector6<f64>,
        reference: &UavReference,
        disturbance: &Vector6<f64>,
    ) -> Vector3<f64> {
        let HierarchicalUav { lam_p, c_p, k_p, .. } = self.gains;
        let error = coordinates.fixed_rows::<3>(0) - reference.position;
        let rate = velocities.fixed_rows::<3>(0) - reference.velocity;
        self.sliding_position = rate + lam_p * error; // (7.26)
        reference.acceleration
            - disturbance.fixed_rows::<3>(0)
            - lam_p * rate
            - k_p * error
            - c_p * self.sliding_position
            + Vector3::new(0.0, 0.0, GRAVITY)
    }

    /// Roll and pitch that point the thrust along `push`. (7.31)
    fn guide(&mut self) {
        let push = &self.push;
        let (sin_yaw, cos_yaw) = (libm::sin(self.gains.psi_d), libm::cos(self.gains.psi_d));
        let roll = libm::asin((push.x * sin_yaw - push.y * cos_yaw) / push.norm());
        let pitch = libm::atan((push.x * cos_yaw + push.y * sin_yaw) / push.z);
        self.attitude_reference = Vector3::new(roll, pitch, self.gains.psi_d);
    }

    /// ua, the angular acceleration that the attitude loop asks for. (7.42)
    fn attitude_loop(
        &mut self,
        coordinates: &Vector6<f64>,
        velocities: &Vector6<f64>,
        disturbance: &Vector6<f64>,
    ) -> Vector3<f64> {
        let HierarchicalUav { lam_a, c_a, k_a, .. } = self.gains;
        let error = coordinates.fixed_rows::<3>(3) - self.attitude_reference;
        let rate = velocities.fixed_rows::<3>(3) - self.attitude_rate;
        self.sliding_attitude = rate + lam_a * error; // (7.36)
        self.attitude_acceleration
            - disturbance.fixed_rows::<3>(3)
            - lam_a * rate
            - k_a * error
            - c_a * self.sliding_attitude
    }
}

impl Component for HierarchicalUav {
    fn check(&self, _: &Context) -> Checks {
        Checks::default()
            .positive("lam_p", self.lam_p)
            .positive("c_p", self.c_p)
            .positive("k_p", self.k_p)
            .positive("lam_a", self.lam_a)
            .positive("c_a", self.c_a)
            .positive("k_a", self.k_a)
            .finite("psi_d", self.psi_d)
            .positive("xi1_max", self.xi1_max)
            .positive("xi2_max", self.xi2_max)
            .positive("gamma1", self.gamma1)
            .finite("gamma2", self.gamma2)
            .require(self.n_diff >= 1, "n_diff", "expected at least one step, found 0")
            .require(self.position_every >= 1, "position_every", "expected at least one step, found 0")
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let vehicle = context.agents[agent].nominal.quadcopter().ok_or_else(|| {
            let reason = "flies quadcopters; this vehicle has no thrust and no attitude";
            Refusal(format!("the controller `hierarchical_uav` {reason}"))
        })?;
        Ok(Box::new(HierarchicalUavParticipant {
            controller: HierarchicalUavController::new(self.clone(), vehicle.clone()),
            coordinates: bind.state(agent, "position")?,
            velocities: bind.state(agent, "velocity")?,
            reference: [
                bind.reference(agent, "position")?,
                bind.reference(agent, "velocity")?,
                bind.reference(agent, "acceleration")?,
            ],
            disturbance: bind.estimate(agent, "disturbance")?,
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

fn published(context: &Context, agent: usize) -> Outputs<HierarchicalUavController> {
    Outputs::new()
        .field(context.agents[agent].vehicle.input_field(), |controller: &HierarchicalUavController| {
            Vector4::from(controller.input)
        })
        .vector("attitude_reference", "rad", |controller| controller.attitude_reference)
        .vector("xi1", "rad/s", |controller| controller.attitude_rate)
        .vector("xi2", "rad/s^2", |controller| controller.attitude_acceleration)
        .vector("sliding_position", "m/s", |controller| controller.sliding_position)
        .vector("sliding_attitude", "rad/s", |controller| controller.sliding_attitude)
}

struct HierarchicalUavParticipant {
    controller: HierarchicalUavController,
    coordinates: In<6>,
    velocities: In<6>,
    reference: [In<3>; 3],
    disturbance: In<6>,
    outputs: BoundOutputs<HierarchicalUavController>,
}

impl Participant for HierarchicalUavParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let [position, velocity, acceleration] = self.reference.map(|signal| Vector3::from(io.get(signal)));
        let reference = UavReference { position, velocity, acceleration };
        let controller = &mut self.controller;
        controller.update(
            step,
            &io.get(self.coordinates).into(),
            &io.get(self.velocities).into(),
            &reference,
            &io.get(self.disturbance).into(),
        );
        self.outputs.write(io, controller);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
