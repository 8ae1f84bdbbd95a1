//! The neural observer of section 5.2: estimates the lumped uncertainty of a vehicle of order 1 with a three-layer network.

use formation::config::Diagonal;
use formation::math::sig_vector;
use formation::nalgebra::{SVector, Vector3, Vector6};
use formation::networks::{HiddenRate, ThreeLayer, ThreeLayerRates};
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::applied_input::AppliedInput;

/// More hidden neurons than this are taken for a mistake.
const MAX_NEURONS: usize = 1000;

/// Gains of the observer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThreeLayerNeural {
    /// η1 to η4: learning rate and leakage of Ŵ, learning rate and leakage of Ĵ.
    pub eta: [f64; 4],
    /// Γ, gain of the observation error, one number or one per coordinate.
    pub gamma: Diagonal,
    /// β, exponent of the observation error.
    pub beta: f64,
    /// n̄, number of hidden neurons.
    pub n_hidden: usize,
}

/// The observer of one vehicle.
#[derive(Clone, Debug)]
pub struct ThreeLayerObserver {
    rates: ThreeLayerRates,
    gamma: Vector3<f64>,
    beta: f64,
    /// The network; its inputs are coordinates and wheel speeds.
    pub network: ThreeLayer<6, 3>,
    /// x̂.
    pub position: Vector3<f64>,
    /// Ê, the output of the network: the estimate of the lumped uncertainty.
    pub estimate: Vector3<f64>,
    /// The measurement that was taken in last.
    measured: Vector3<f64>,
}

impl ThreeLayerObserver {
    /// An observer that starts at `position`, with the random weights of its network.
    pub fn new(
        gains: &ThreeLayerNeural,
        gamma: Vector3<f64>,
        network: ThreeLayer<6, 3>,
        position: Vector3<f64>,
    ) -> Self {
        let [outer, outer_leak, hidden, hidden_leak] = gains.eta;
        Self {
            rates: ThreeLayerRates { outer, outer_leak, hidden: HiddenRate::Normalised(hidden), hidden_leak },
            gamma,
            beta: gains.beta,
            network,
            position,
            estimate: Vector3::zeros(),
            measured: position,
        }
    }

    /// Advances over the last `dt` seconds, in which the input had the effect `driven` (ĝu). Measurement, network input and
    /// weights are those of the start of the interval.
    pub fn advance(&mut self, dt: f64, driven: &Vector3<f64>) {
        let error = self.measured - self.position; // x̃
        let correction = self.gamma.component_mul(&sig_vector(&error, self.beta));
        self.position += dt * (driven + self.estimate + correction);
        self.network.learn(dt, &self.rates, &error); // (5.20), (5.21)
    }

    /// Forms the estimate from the measurement of now and the input that acted until now.
    ///
    /// The input of now depends on the estimate; taking the last one instead breaks that loop.
    pub fn update(&mut self, measured: &Vector3<f64>, input: &Vector3<f64>) {
        self.measured = *measured;
        let [x, y, heading] = (*measured).into();
        self.estimate = self.network.respond(&Vector6::new(x, y, heading, input.x, input.y, input.z)); // (5.6)
    }
}

impl Component for ThreeLayerNeural {
    fn check(&self, context: &Context) -> Checks {
        let names = ["eta.1", "eta.2", "eta.3", "eta.4"];
        let checks =
            self.eta.iter().zip(names).fold(Checks::default(), |checks, (rate, name)| checks.not_negative(name, *rate));
        let neurons = format!("expected 1 to {MAX_NEURONS} neurons, found {}", self.n_hidden);
        let gamma = self.gamma.problem(3);
        let unfit = context.agents.iter().find(|agent| agent.vehicle.order() != 1);
        checks
            .positive("beta", self.beta)
            .require((1..=MAX_NEURONS).contains(&self.n_hidden), "n_hidden", neurons)
            .require(gamma.is_none(), "gamma", gamma.unwrap_or_default())
            .require(unfit.is_none(), "kind", "this observer is made for vehicles of order 1 (wheel speeds)")
    }

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        published().fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let network = ThreeLayer::seeded(context.seed, agent, self.n_hidden);
        let gamma = self.gamma.vector().map_err(Refusal)?;
        let start = Vector3::from_column_slice(&context.agents[agent].estimate);
        Ok(Box::new(ThreeLayerParticipant {
            observer: ThreeLayerObserver::new(self, gamma, network, start),
            applied: AppliedInput::new(context, agent, bind)?,
            position: bind.state(agent, "position")?,
            outputs: published().bind(agent, bind)?,
        }))
    }
}

fn published() -> Outputs<ThreeLayerObserver> {
    Outputs::new()
        .vector("position", "m, m, rad", |observer: &ThreeLayerObserver| observer.position)
        .vector("disturbance", "m/s, m/s, rad/s", |observer| observer.estimate)
        .scalar("weight_norm", "", |observer| observer.network.outer_norm())
        .scalar("hidden_weight_norm", "", |observer| observer.network.hidden_norm())
}

struct ThreeLayerParticipant {
    observer: ThreeLayerObserver,
    applied: AppliedInput,
    position: In<3>,
    outputs: BoundOutputs<ThreeLayerObserver>,
}

impl Participant for ThreeLayerParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let observer = &mut self.observer;
        if !step.is_first() {
            let driven: SVector<f64, 3> = self.applied.effect(io, &observer.measured);
            observer.advance(step.dt, &driven);
        }
        let [u1, u2, u3, _] = self.applied.values(io);
        observer.update(&io.get(self.position).into(), &Vector3::new(u1, u2, u3));
        self.outputs.write(io, observer);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observer(seed: u64) -> ThreeLayerObserver {
        let gains = ThreeLayerNeural {
            eta: [15.0, 0.1, 0.1, 0.06],
            gamma: Diagonal::from([12.0, 12.0, 18.0]),
            beta: 0.9,
            n_hidden: 5,
        };
        let gamma = gains.gamma.vector().unwrap();
        ThreeLayerObserver::new(&gains, gamma, ThreeLayer::seeded(seed, 0, gains.n_hidden), Vector3::new(0.1, 0.2, 0.0))
    }

    /// Whatever the random weights, a slow disturbance ends up in the output of the network.
    #[test]
    fn a_slow_disturbance_is_found() {
        for seed in 1..20 {
            let dt = 1e-3;
            let mut observer = observer(seed);
            let mut position = Vector3::new(1.0, -0.5, 0.3);
            let input = Vector3::new(0.2, -0.1, 0.05);
            observer.update(&position, &input);
            let mut worst: f64 = 0.0;
            for k in 0..20_000 {
                let time = k as f64 * dt;
                let disturbance = Vector3::new(0.05 * libm::cos(0.2 * time), -0.04, 0.03);
                position += dt * disturbance;
                observer.advance(dt, &Vector3::zeros());
                observer.update(&position, &input);
                if time > 15.0 {
                    worst = worst.max((disturbance - observer.estimate).norm());
                }
            }
            assert!(worst < 0.02, "seed {seed}: {worst}");
        }
    }

    #[test]
    fn one_step_of_the_state() {
        let mut observer = observer(17);
        observer.update(&Vector3::new(0.5, 0.2, -0.3), &Vector3::zeros());
        observer.estimate = Vector3::new(1.0, 2.0, 3.0);
        observer.advance(0.01, &Vector3::new(0.2, 0.0, -0.1));
        let expected = Vector3::new(
            0.1 + 0.01 * (1.2 + 12.0 * libm::pow(0.4, 0.9)),
            0.2 + 0.01 * 2.0,
            0.01 * (2.9 - 18.0 * libm::pow(0.3, 0.9)),
        );
        assert!((observer.position - expected).norm() < 1e-14, "{}", observer.position);
    }
}
