//! The formation controllers of sections 5.2 and 5.3 that rely on an observer: limited maintenance input, and a consensus input
//! that is either clipped or scaled to fit (CIDA).

use formation::config::PerAgent;
use formation::math::Projection;
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::speed_vehicle::{require_speed_vehicles, resolved, speed_vehicle};
use crate::{LocalError, consensus_share};

/// How the consensus input is fitted beside the maintenance input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// Their sum is saturated, channel by channel. (OBFC)
    Saturation,
    /// The consensus input is scaled as a whole. (AOBFC)
    Cida,
}

/// Gains and limits of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct ObserverFormation {
    /// How the consensus input is fitted in.
    pub distribution: Distribution,
    /// k, gain of the local error, 1/s; one for all agents or one each.
    pub k: PerAgent,
    /// End of the linear range of the limit of Ê, m/s and rad/s.
    pub EM: f64,
    /// Softness of that limit.
    pub psi_E: f64,
    /// End of the linear range of the limit of the maintenance input, m/s.
    pub tau: f64,
    /// Softness of that limit, m/s.
    pub psi: f64,
    /// End of the linear range of the limit of the whole input, m/s; for `saturation`.
    pub tau_bar: f64,
    /// Softness of that limit, m/s.
    pub psi_bar: f64,
}

/// The limits of an [`ObserverFormationController`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserverFormationLimits {
    /// S̄(Ê; EM, ψE).
    pub estimate: Projection,
    /// S̄(um; τ, ψ).
    pub maintenance: Projection,
    /// What happens to the sum.
    pub whole: WholeLimit,
}

/// What keeps the whole input feasible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WholeLimit {
    /// S̄(um + ue; τ̄, ψ̄).
    Saturation(Projection),
    /// ξ̄ from the given limit UM.
    Cida(f64),
}

/// The controller of one agent.
#[derive(Clone, Debug)]
pub struct ObserverFormationController {
    gain: f64,
    limits: ObserverFormationLimits,
    vehicle: Omni,
    /// u, wheel speeds, m/s.
    pub input: Vector3<f64>,
    /// um, what keeps the agent on its reference.
    pub maintenance: Vector3<f64>,
    /// ue, what brings it there.
    pub consensus: Vector3<f64>,
    /// ξ̄, the share of the consensus input that is applied.
    pub share: f64,
}

impl ObserverFormationController {
    /// A controller with the gain k for `vehicle`, as known.
    pub fn new(gain: f64, limits: ObserverFormationLimits, vehicle: Omni) -> Self {
        let zero = Vector3::zeros();
        Self { gain, limits, vehicle, input: zero, maintenance: zero, consensus: zero, share: 1.0 }
    }

    /// Computes the input from the heading, the reference velocity, the local error and the estimated uncertainty.
    pub fn update(
        &mut self,
        heading: f64,
        reference_velocity: &Vector3<f64>,
        error: &Vector3<f64>,
        estimate: &Vector3<f64>,
    ) {
        let inverse = self.vehicle.inverse(heading);
        let limits = &self.limits;
        self.consensus = inverse * (-self.gain * error);
        self.maintenance =
            limits.maintenance.vector(&(inverse * (reference_velocity - limits.estimate.vector(estimate)))); // (5.28)
        match &limits.whole {
            WholeLimit::Saturation(projection) => {
                self.input = projection.vector(&(self.maintenance + self.consensus));
            }
            WholeLimit::Cida(limit) => {
                self.share = consensus_share(&self.maintenance, &self.consensus, *limit);
                self.input = self.maintenance + self.share * self.consensus;
            }
        }
    }
}

impl Component for ObserverFormation {
    fn check(&self, context: &Context) -> Checks {
        let cida = self.distribution == Distribution::Cida;
        let reach = self.tau + self.psi;
        let feasible = !cida || context.input_limit.is_some_and(|limit| reach < limit);
        let infeasible = format!(
            "the maintenance input reaches up to tau + psi = {reach} m/s; the distribution `cida` needs that below the limit UM of \
             the vehicle"
        );
        let checks = require_speed_vehicles(Checks::default(), context);
        checks
            .positive_each("k", &self.k, context)
            .require(
                context.input_limit.is_some() || !cida,
                "/vehicle",
                "missing field `UM`, which this controller needs",
            )
            .positive("EM", self.EM)
            .not_negative("psi_E", self.psi_E)
            .positive("tau", self.tau)
            .not_negative("psi", self.psi)
            .positive("tau_bar", self.tau_bar)
            .not_negative("psi_bar", self.psi_bar)
            .require(feasible, "tau", infeasible)
            .strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let limits = ObserverFormationLimits {
            estimate: Projection::new(self.EM, self.psi_E),
            maintenance: Projection::new(self.tau, self.psi),
            whole: match self.distribution {
                Distribution::Saturation => WholeLimit::Saturation(Projection::new(self.tau_bar, self.psi_bar)),
                Distribution::Cida => WholeLimit::Cida(context.input_limit.unwrap_or(f64::INFINITY)),
            },
        };
        let gain = resolved(&self.k, context, agent)?;
        let vehicle = speed_vehicle(context, agent)?;
        Ok(Box::new(ObserverFormationParticipant {
            controller: ObserverFormationController::new(gain, limits, vehicle),
            error: LocalError::new(context, agent, bind, "position")?,
            position: bind.state(agent, "position")?,
            reference_velocity: bind.reference(agent, "velocity")?,
            estimate: bind.estimate(agent, "disturbance")?,
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

/// What a step results in.
struct Outcome {
    input: Vector3<f64>,
    error: Vector3<f64>,
    maintenance: Vector3<f64>,
    consensus: Vector3<f64>,
    share: f64,
}

fn published(context: &Context, agent: usize) -> Outputs<Outcome> {
    Outputs::new()
        .field(context.agents[agent].vehicle.input_field(), |outcome: &Outcome| outcome.input)
        .vector("error", "m, m, rad", |outcome| outcome.error)
        .vector("maintenance", "m/s", |outcome| outcome.maintenance)
        .vector("consensus", "m/s", |outcome| outcome.consensus)
        .scalar("xi_bar", "", |outcome| outcome.share)
}

struct ObserverFormationParticipant {
    controller: ObserverFormationController,
    error: LocalError,
    position: In<3>,
    reference_velocity: In<3>,
    estimate: In<3>,
    outputs: BoundOutputs<Outcome>,
}

impl Participant for ObserverFormationParticipant {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let error = self.error.local(io);
        let [_, _, heading] = io.get(self.position);
        let controller = &mut self.controller;
        controller.update(heading, &io.get(self.reference_velocity).into(), &error, &io.get(self.estimate).into());
        let ObserverFormationController { input, maintenance, consensus, share, .. } = *controller;
        self.outputs.write(io, &Outcome { input, error, maintenance, consensus, share });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::vehicle::Drive;
    use proptest::prelude::*;

    fn controller(whole: WholeLimit) -> ObserverFormationController {
        let vehicle = Omni { drive: Drive::Speed, radius: 0.21, mass: 1.0, inertia: 1.0, friction: 0.0 };
        let limits = ObserverFormationLimits {
            estimate: Projection::new(0.1, 0.01),
            maintenance: Projection::new(0.22, 0.01),
            whole,
        };
        ObserverFormationController::new(3.0, limits, vehicle)
    }

    proptest! {
        #[test]
        fn no_input_exceeds_its_limit(
            heading in -7.0..7.0f64,
            rate in proptest::array::uniform3(-2.0..2.0f64),
            error in proptest::array::uniform3(-5.0..5.0f64),
            estimate in proptest::array::uniform3(-9.0..9.0f64),
        ) {
            for whole in [WholeLimit::Cida(0.25), WholeLimit::Saturation(Projection::new(0.24, 0.01))] {
                let mut controller = controller(whole);
                controller.update(heading, &rate.into(), &error.into(), &estimate.into());
                prop_assert!(controller.maintenance.amax() <= 0.23);
                prop_assert!(controller.input.amax() <= 0.25 + 1e-12);
            }
        }

        /// While nothing saturates, the error decays at the rate k in every channel.
        #[test]
        fn both_agree_while_nothing_saturates(
            heading in -7.0..7.0f64,
            rate in proptest::array::uniform3(-0.01..0.01f64),
            error in proptest::array::uniform3(-0.01..0.01f64),
        ) {
            for whole in [WholeLimit::Cida(0.25), WholeLimit::Saturation(Projection::new(0.24, 0.01))] {
                let mut controller = controller(whole);
                let estimate = Vector3::new(0.01, -0.02, 0.03);
                controller.update(heading, &rate.into(), &error.into(), &estimate);
                let velocity = controller.vehicle.matrix(heading) * controller.input + estimate;
                prop_assert!((velocity - Vector3::from(rate) + 3.0 * Vector3::from(error)).norm() < 1e-12);
                prop_assert_eq!(controller.share, 1.0);
            }
        }
    }
}
