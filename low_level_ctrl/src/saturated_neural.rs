//! The nominal formation controller whose network is tuned by the formation error itself (CTNNE). Section 6.6, design 1

use formation::nalgebra::{Vector3, Vector6};
use formation::networks::{InitialWeights, Leak, OutputLayer, tanh_of_state};
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::sliding_feedback::{FormationInputs, published, vehicle};
use crate::{Command, FormationErrors, SaturatedNominalController, SlidingFeedback};

/// Gains of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SaturatedNeural {
    /// c, gain of the sliding variable, 1/s.
    pub c: f64,
    /// λ, slope of the sliding surface, 1/s.
    pub lam: f64,
    /// η1, learning rate.
    pub eta1: f64,
    /// η2, leakage, 1/s.
    pub eta2: f64,
    /// Ŵ(0).
    #[serde(rename = "What0")]
    pub initial_weights: InitialWeights,
}

/// The controller of one robot.
#[derive(Clone, Debug)]
pub struct SaturatedNeuralController {
    nominal: SaturatedNominalController,
    rate: f64,
    leak: f64,
    /// Ŵ.
    pub layer: OutputLayer<6, 3>,
    regressor: Vector6<f64>,
    /// ŵ at the last update.
    pub disturbance: Vector3<f64>,
}

impl SaturatedNeuralController {
    /// The controller `nominal` with a network that starts with the weights of `layer`.
    pub fn new(nominal: SaturatedNominalController, rate: f64, leak: f64, layer: OutputLayer<6, 3>) -> Self {
        Self { nominal, rate, leak, layer, regressor: Vector6::zeros(), disturbance: Vector3::zeros() }
    }

    /// The input at these coordinates and velocities, with the estimate of the network as it is.
    pub fn update(&mut self, errors: &FormationErrors, position: &Vector3<f64>, velocity: &Vector3<f64>) -> Command {
        self.regressor = tanh_of_state(position, velocity);
        self.disturbance = self.layer.output(&self.regressor); // (6.6)
        self.nominal.update(errors, position.z, &self.disturbance)
    }

    /// Tunes the network over `dt` seconds with the sliding variable of the last update.
    pub fn advance(&mut self, dt: f64, sliding: &Vector3<f64>) {
        self.layer.learn(dt, self.rate, &self.regressor, sliding, Leak::Constant(self.leak));
    }
}

impl Component for SaturatedNeural {
    fn check(&self, context: &Context) -> Checks {
        let agents = context.agents.len();
        let problem = (0..agents).find_map(|agent| self.initial_weights.resolve::<6, 3>(agents, agent).err());
        Checks::default()
            .positive("c", self.c)
            .positive("lam", self.lam)
            .not_negative("eta1", self.eta1)
            .not_negative("eta2", self.eta2)
            .require(problem.is_none(), "What0", problem.unwrap_or_default())
            .strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        [published(context, agent).fields(), published_network().fields()].concat()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let (vehicle, limit) = vehicle(context, agent, "saturated_neural")?;
        let feedback = SlidingFeedback { gain: self.c, slope: self.lam };
        let nominal = SaturatedNominalController::new(feedback, vehicle.clone(), limit);
        let weights = self.initial_weights.resolve(context.agents.len(), agent);
        let layer = OutputLayer::new(weights.map_err(|message| Refusal(format!("What0: {message}")))?);
        Ok(Box::new(SaturatedNeuralParticipant {
            controller: SaturatedNeuralController::new(nominal, self.eta1, self.eta2, layer),
            inputs: FormationInputs::new(context, agent, bind)?,
            outputs: published(context, agent).bind(agent, bind)?,
            network: published_network().bind(agent, bind)?,
        }))
    }
}

fn published_network() -> Outputs<SaturatedNeuralController> {
    Outputs::new()
        .vector("disturbance", "m/s^2, m/s^2, rad/s^2", |controller: &SaturatedNeuralController| controller.disturbance)
        .scalar("weight_norm", "", |controller| controller.layer.weights.norm())
}

struct SaturatedNeuralParticipant {
    controller: SaturatedNeuralController,
    inputs: FormationInputs,
    outputs: BoundOutputs<(Command, FormationErrors)>,
    network: BoundOutputs<SaturatedNeuralController>,
}

impl Participant for SaturatedNeuralParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let errors = self.inputs.errors(io);
        let command = self.controller.update(&errors, &self.inputs.position(io), &self.inputs.velocity(io));
        self.outputs.write(io, &(command, errors));
        self.network.write(io, &self.controller);
        self.controller.advance(step.dt, &command.sliding);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::vehicle::{Drive, Omni};

    /// Two steps by hand: nothing is estimated at first, then the network answers the sliding variable.
    #[test]
    fn the_network_learns_from_the_sliding_variable() {
        let vehicle = Omni { drive: Drive::Acceleration, radius: 0.2, mass: 3.0, inertia: 0.08, friction: 0.0 };
        let feedback = SlidingFeedback { gain: 2.0, slope: 2.0 };
        let nominal = SaturatedNominalController::new(feedback, vehicle, 1.0);
        let mut controller = SaturatedNeuralController::new(nominal, 10.0, 1.0, OutputLayer::default());
        let position = Vector3::new(0.5, 0.0, 0.0);
        let zero = Vector3::zeros();
        let errors = FormationErrors {
            position,
            velocity: zero,
            local_position: position,
            local_velocity: zero,
            acceleration: zero,
        };
        let first = controller.update(&errors, &position, &zero);
        assert_eq!(controller.disturbance, zero);
        assert_eq!(first.sliding.x, 1.0);
        controller.advance(0.1, &first.sliding);
        let second = controller.update(&errors, &position, &zero);
        let expected = 0.1 * 10.0 * libm::tanh(0.5) * libm::tanh(0.5);
        assert!((controller.disturbance.x - expected).abs() < 1e-15);
        assert!((second.demanded.x - first.demanded.x + expected).abs() < 1e-15);
        controller.advance(0.1, &zero);
        assert!((controller.layer.weights[(0, 0)] - 0.9 * libm::tanh(0.5)).abs() < 1e-15);
    }
}
