//! The formation controllers of section 5.2 without an observer: a three-layer network inside the controller, tuned by the local
//! error.

use formation::config::PerAgent;
use formation::math::{Projection, clip_vector};
use formation::nalgebra::{Vector3, Vector6};
use formation::networks::{HiddenRate, ThreeLayer, ThreeLayerRates};
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::LocalError;
use crate::speed_vehicle::{require_speed_vehicles, resolved, speed_vehicle};

/// More hidden neurons than this are taken for a mistake.
const MAX_NEURONS: usize = 1000;

/// Gains and limits of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct NeuralFormation {
    /// Whether Ê is limited before it is used: false is CTFC, true RCTFC.
    pub limit_estimate: bool,
    /// k, gain of the local error, 1/s; one for all agents or one each.
    pub k: PerAgent,
    /// η1 to η4: learning rate and leakage of Ŵ, learning rate and leakage of Ĵ.
    pub eta: [f64; 4],
    /// n̄, number of hidden neurons.
    pub n_hidden: usize,
    /// End of the linear range of the limit of Ê, m/s and rad/s.
    pub EM: f64,
    /// Softness of that limit.
    pub psi_E: f64,
    /// End of the linear range of the limit of the input, m/s.
    pub tau_bar: f64,
    /// Softness of that limit, m/s.
    pub psi_bar: f64,
}

/// What a [`NeuralFormationController`] is set up with, besides its network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeuralFormationSettings {
    /// k.
    pub gain: f64,
    /// Rates of the network.
    pub rates: ThreeLayerRates,
    /// S̄(Ê; EM, ψE), if Ê is limited.
    pub estimate: Option<Projection>,
    /// S̄(u; τ̄, ψ̄).
    pub input: Projection,
    /// UM, the limit of the actuators.
    pub actuators: f64,
}

/// The controller of one agent.
#[derive(Clone, Debug)]
pub struct NeuralFormationController {
    settings: NeuralFormationSettings,
    vehicle: Omni,
    /// The network; its inputs are coordinates and wheel speeds.
    pub network: ThreeLayer<6, 3>,
    /// u, wheel speeds, m/s.
    pub input: Vector3<f64>,
    /// um, what keeps the agent on its reference.
    pub maintenance: Vector3<f64>,
    /// ue, what brings it there.
    pub consensus: Vector3<f64>,
    /// Ê, the output of the network.
    pub estimate: Vector3<f64>,
    /// The input as it acted since the last update.
    applied: Vector3<f64>,
}

impl NeuralFormationController {
    /// A controller for `vehicle`, as known, with the random weights of its network.
    pub fn new(settings: NeuralFormationSettings, vehicle: Omni, network: ThreeLayer<6, 3>) -> Self {
        let zero = Vector3::zeros();
        Self {
            settings,
            vehicle,
            network,
            input: zero,
            maintenance: zero,
            consensus: zero,
            estimate: zero,
            applied: zero,
        }
    }

    /// Computes the input from position, reference velocity and local error, then tunes the network over `dt` seconds.
    pub fn update(
        &mut self,
        dt: f64,
        position: &Vector3<f64>,
        reference_velocity: &Vector3<f64>,
        error: &Vector3<f64>,
    ) {
        let settings = &self.settings;
        let [x, y, heading] = (*position).into();
        let [u1, u2, u3] = self.applied.into();
        self.estimate = self.network.respond(&Vector6::new(x, y, heading, u1, u2, u3)); // (5.6)
        let estimate = settings.estimate.map_or(self.estimate, |projection| projection.vector(&self.estimate));
        let inverse = self.vehicle.inverse(heading);
        self.consensus = inverse * (-settings.gain * error);
        self.maintenance = inverse * (reference_velocity - estimate);
        self.input = settings.input.vector(&(self.maintenance + self.consensus)); // (5.28)
        self.applied = clip_vector(&self.input, settings.actuators);
        self.network.learn(dt, &settings.rates, error); // (5.12), (5.14)
    }
}

impl Component for NeuralFormation {
    fn check(&self, context: &Context) -> Checks {
        let names = ["eta.1", "eta.2", "eta.3", "eta.4"];
        let checks = require_speed_vehicles(Checks::default(), context);
        let checks = checks.positive_each("k", &self.k, context);
        let checks = self.eta.iter().zip(names).fold(checks, |checks, (rate, name)| checks.not_negative(name, *rate));
        let neurons = format!("expected 1 to {MAX_NEURONS} neurons, found {}", self.n_hidden);
        checks
            .require((1..=MAX_NEURONS).contains(&self.n_hidden), "n_hidden", neurons)
            .positive("EM", self.EM)
            .not_negative("psi_E", self.psi_E)
            .positive("tau_bar", self.tau_bar)
            .not_negative("psi_bar", self.psi_bar)
            .strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let [outer, outer_leak, hidden, hidden_leak] = self.eta;
        // η3 over 2 n N: n coordinates of each of the N agents.
        let hidden = HiddenRate::Constant(hidden / (2.0 * 3.0 * context.agents.len() as f64));
        let settings = NeuralFormationSettings {
            gain: resolved(&self.k, context, agent)?,
            rates: ThreeLayerRates { outer, outer_leak, hidden, hidden_leak },
            estimate: self.limit_estimate.then(|| Projection::new(self.EM, self.psi_E)),
            input: Projection::new(self.tau_bar, self.psi_bar),
            actuators: context.input_limit.unwrap_or(f64::INFINITY),
        };
        let network = ThreeLayer::seeded(context.seed, agent, self.n_hidden);
        Ok(Box::new(NeuralFormationParticipant {
            controller: NeuralFormationController::new(settings, speed_vehicle(context, agent)?, network),
            error: LocalError::new(context, agent, bind, "position")?,
            position: bind.state(agent, "position")?,
            reference_velocity: bind.reference(agent, "velocity")?,
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
    network: Vector3<f64>,
    weight_norm: f64,
    hidden_weight_norm: f64,
}

fn published(context: &Context, agent: usize) -> Outputs<Outcome> {
    Outputs::new()
        .field(context.agents[agent].vehicle.input_field(), |outcome: &Outcome| outcome.input)
        .vector("error", "m, m, rad", |outcome| outcome.error)
        .vector("maintenance", "m/s", |outcome| outcome.maintenance)
        .vector("consensus", "m/s", |outcome| outcome.consensus)
        .vector("network", "m/s, m/s, rad/s", |outcome| outcome.network)
        .scalar("weight_norm", "", |outcome| outcome.weight_norm)
        .scalar("hidden_weight_norm", "", |outcome| outcome.hidden_weight_norm)
}

struct NeuralFormationParticipant {
    controller: NeuralFormationController,
    error: LocalError,
    position: In<3>,
    reference_velocity: In<3>,
    outputs: BoundOutputs<Outcome>,
}

impl Participant for NeuralFormationParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let error = self.error.local(io);
        let controller = &mut self.controller;
        // The weights of this instant, before they are tuned.
        let (weight_norm, hidden_weight_norm) = (controller.network.outer_norm(), controller.network.hidden_norm());
        controller.update(step.dt, &io.get(self.position).into(), &io.get(self.reference_velocity).into(), &error);
        let outcome = Outcome {
            input: controller.input,
            error,
            maintenance: controller.maintenance,
            consensus: controller.consensus,
            network: controller.estimate,
            weight_norm,
            hidden_weight_norm,
        };
        self.outputs.write(io, &outcome);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::vehicle::Drive;
    use proptest::prelude::*;

    fn controller(estimate: Option<Projection>) -> NeuralFormationController {
        let vehicle = Omni { drive: Drive::Speed, radius: 0.25, mass: 1.0, inertia: 1.0, friction: 0.0 };
        let rates = ThreeLayerRates {
            outer: 15.0,
            outer_leak: 0.1,
            hidden: HiddenRate::Constant(0.1 / 36.0),
            hidden_leak: 0.06,
        };
        let input = Projection::new(0.24, 0.01);
        let settings = NeuralFormationSettings { gain: 3.0, rates, estimate, input, actuators: 0.25 };
        NeuralFormationController::new(settings, vehicle, ThreeLayer::seeded(17, 2, 5))
    }

    proptest! {
        #[test]
        fn the_input_is_limited_and_the_used_estimate_too(
            position in proptest::array::uniform3(-4.0..4.0f64),
            error in proptest::array::uniform3(-5.0..5.0f64),
        ) {
            let mut controller = controller(Some(Projection::new(0.1, 0.01)));
            for _ in 0..50 {
                controller.update(0.1, &position.into(), &Vector3::zeros(), &error.into());
                prop_assert!(controller.input.amax() <= 0.25);
                let used = controller.vehicle.matrix(position[2]) * controller.maintenance;
                prop_assert!(used.amax() <= 0.11 + 1e-12);
            }
        }
    }

    /// The network sees the input that acted before, and its estimate acts against the disturbance.
    #[test]
    fn the_first_step_knows_no_disturbance() {
        let mut controller = controller(None);
        let (position, error) = (Vector3::new(0.3, -0.2, 0.1), Vector3::new(0.01, -0.02, 0.0));
        controller.update(1e-3, &position, &Vector3::new(0.05, 0.0, 0.0), &error);
        assert_eq!(controller.estimate, Vector3::zeros());
        let velocity = controller.vehicle.matrix(0.1) * controller.input;
        assert!((velocity - Vector3::new(0.02, 0.06, 0.0)).norm() < 1e-12, "{velocity}");
        let applied = controller.input;
        let mut expected = controller.network.clone();
        controller.update(1e-3, &position, &Vector3::zeros(), &error);
        let [u1, u2, u3] = applied.into();
        assert_eq!(controller.estimate, expected.respond(&Vector6::new(0.3, -0.2, 0.1, u1, u2, u3)));
        assert!(controller.estimate.norm() > 0.0);
    }
}
