//! The neural sliding mode observer of section 6.4: an imaginary vehicle of order 2 that is made to follow the real one; the
//! input that this takes estimates the lumped uncertainty. What it slides on is a [`Surface`].

use formation::nalgebra::SVector;
use formation::networks::{InitialWeights, Leak, OutputLayer, tanh_of_state};
use formation::scenario::Context;
use formation::vehicle::{MAX_COORDINATES, Vehicle};
use formation::wiring::{Bind, BoundOutputs, Checks, Outputs, Refusal, Role};
use lockstep::{Fault, Field, In, Io, Participant, Slice, Step, Timing};
use schemars::JsonSchema;
use serde::Deserialize;

/// What the errors of the imaginary vehicle slide on, and what drives them there, element by element.
pub trait Surface: Clone + Send {
    /// s̃ from x̃ and ṽ.
    fn sliding<const D: usize>(&self, position: &SVector<f64, D>, velocity: &SVector<f64, D>) -> SVector<f64, D>;

    /// The part of the imaginary input û that does not come from the network, from x̃, ṽ and s̃.
    fn correction<const D: usize>(
        &self,
        position: &SVector<f64, D>,
        velocity: &SVector<f64, D>,
        sliding: &SVector<f64, D>,
    ) -> SVector<f64, D>;
}

/// What is published as the estimate of the uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Published {
    /// The output of the network alone, ŴᵀT.
    Network,
    /// The whole imaginary input û.
    Input,
}

/// How the network is tuned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// η1, learning rate.
    pub rate: f64,
    /// η2, leakage, 1/s.
    pub leak: f64,
}

/// The observer of one vehicle with `D` coordinates; the network has `P = 2 D` regressors.
#[derive(Clone, Debug)]
pub struct NeuralSurfaceObserver<S, const P: usize, const D: usize> {
    surface: S,
    tuning: Tuning,
    /// x̂.
    pub position: SVector<f64, D>,
    /// v̂.
    pub velocity: SVector<f64, D>,
    /// Ŵ.
    pub layer: OutputLayer<P, D>,
    /// T, the regressors at the last update.
    regressor: SVector<f64, P>,
    /// s̃ at the last update.
    pub sliding: SVector<f64, D>,
    /// ŴᵀT at the last update.
    pub network: SVector<f64, D>,
    /// û at the last update.
    pub input: SVector<f64, D>,
}

impl<S: Surface, const P: usize, const D: usize> NeuralSurfaceObserver<S, P, D> {
    /// An observer that starts at `position` and `velocity` with the weights of `layer`.
    pub fn new(
        surface: S,
        tuning: Tuning,
        position: SVector<f64, D>,
        velocity: SVector<f64, D>,
        layer: OutputLayer<P, D>,
    ) -> Self {
        let zero = SVector::zeros();
        let regressor = SVector::zeros();
        Self { surface, tuning, position, velocity, layer, regressor, sliding: zero, network: zero, input: zero }
    }

    /// Advances by `dt` seconds, in which `acceleration` (g u) acted, from the errors and the input of the last update.
    ///
    /// The position moves along a parabola. A tangent would make it lag by ½ dt of the acceleration, an error that the
    /// infinite slope of a terminal surface at zero turns into spikes of the estimate.
    pub fn advance(&mut self, dt: f64, acceleration: &SVector<f64, D>) {
        let total = acceleration + self.input;
        self.position += dt * self.velocity + 0.5 * dt * dt * total; // (6.9)
        self.velocity += dt * total;
        let Tuning { rate, leak } = self.tuning;
        self.layer.learn(dt, rate, &self.regressor, &self.sliding, Leak::Constant(leak)); // (6.13)
    }

    /// Takes in the measurements of now and forms the imaginary input.
    pub fn update(&mut self, position: &SVector<f64, D>, velocity: &SVector<f64, D>) {
        self.regressor = tanh_of_state(position, velocity);
        let position_error = position - self.position; // (6.10)
        let velocity_error = velocity - self.velocity;
        self.sliding = self.surface.sliding(&position_error, &velocity_error);
        self.network = self.layer.output(&self.regressor); // (6.6)
        self.input = self.network + self.surface.correction(&position_error, &velocity_error, &self.sliding);
    }
}

/// What an observer of this family publishes; `estimate` is the disturbance.
fn published<S, const P: usize, const D: usize>(estimate: Published) -> Outputs<NeuralSurfaceObserver<S, P, D>> {
    Outputs::new()
        .vector("position", "", |observer: &NeuralSurfaceObserver<S, P, D>| observer.position)
        .vector("velocity", "", |observer| observer.velocity)
        .vector("disturbance", "", move |observer| match estimate {
            Published::Network => observer.network,
            Published::Input => observer.input,
        })
        .vector("imaginary_input", "", |observer| observer.input)
        .vector("network", "", |observer| observer.network)
        .vector("sliding", "", |observer| observer.sliding)
        .scalar("weight_norm", "", |observer| observer.layer.weights.norm())
}

/// Everything of a component of this family but its surface.
pub(crate) struct Family<'a> {
    pub(crate) tuning: Tuning,
    pub(crate) initial_weights: &'a InitialWeights,
    pub(crate) published: Published,
}

impl Family<'_> {
    /// What is published of a vehicle.
    pub(crate) fn outputs<S: Surface>(&self, vehicle: &Vehicle) -> Vec<Field> {
        match vehicle.coordinates() {
            6 => published::<S, 12, 6>(self.published).fields(),
            _ => published::<S, 6, 3>(self.published).fields(),
        }
    }

    /// Adds what is wrong with the initial weights to the findings.
    pub(crate) fn check(&self, checks: Checks, context: &Context) -> Checks {
        let agents = context.agents.len();
        let problem = context.agents.iter().enumerate().find_map(|(agent, row)| match row.vehicle.coordinates() {
            6 => self.initial_weights.resolve::<12, 6>(agents, agent).err(),
            _ => self.initial_weights.resolve::<6, 3>(agents, agent).err(),
        });
        checks.require(problem.is_none(), "What0", problem.unwrap_or_default())
    }

    /// The participant that observes `agent`.
    pub(crate) fn build<S: Surface + 'static>(
        &self,
        surface: S,
        context: &Context,
        agent: usize,
        bind: &mut Bind,
    ) -> Result<Box<dyn Participant>, Refusal> {
        Ok(match context.agents[agent].vehicle.coordinates() {
            6 => Box::new(self.participant::<S, 12, 6>(surface, context, agent, bind)?),
            _ => Box::new(self.participant::<S, 6, 3>(surface, context, agent, bind)?),
        })
    }

    fn participant<S: Surface, const P: usize, const D: usize>(
        &self,
        surface: S,
        context: &Context,
        agent: usize,
        bind: &mut Bind,
    ) -> Result<NeuralSurfaceParticipant<S, P, D>, Refusal> {
        let row = &context.agents[agent];
        let weights = self.initial_weights.resolve(context.agents.len(), agent);
        let observer = NeuralSurfaceObserver::new(
            surface,
            self.tuning,
            SVector::from_column_slice(&row.estimate),
            SVector::from_column_slice(&row.estimate_velocity),
            OutputLayer::new(weights.map_err(|message| Refusal(format!("What0: {message}")))?),
        );
        Ok(NeuralSurfaceParticipant {
            observer,
            vehicle: row.nominal.clone(),
            position_before: SVector::zeros(),
            outputs: published(self.published).bind(agent, bind)?,
            position: bind.state(agent, "position")?,
            velocity: bind.state(agent, "velocity")?,
            input: bind.slice(Role::Controller, agent, "input", row.nominal.inputs(), Timing::Delayed)?,
        })
    }
}

struct NeuralSurfaceParticipant<S, const P: usize, const D: usize> {
    observer: NeuralSurfaceObserver<S, P, D>,
    vehicle: Vehicle,
    /// Coordinates of the step before, at which the input of the last interval acted.
    position_before: SVector<f64, D>,
    position: In<D>,
    velocity: In<D>,
    input: Slice,
    outputs: BoundOutputs<NeuralSurfaceObserver<S, P, D>>,
}

impl<S, const P: usize, const D: usize> NeuralSurfaceParticipant<S, P, D> {
    /// g(x) u + drift of the last interval.
    fn acceleration(&self, input: &[f64]) -> SVector<f64, D> {
        let mut effect = [0.0; MAX_COORDINATES];
        self.vehicle.effect(self.position_before.as_slice(), input, &mut effect);
        SVector::from_fn(|j, _| effect[j] + self.vehicle.drift(j))
    }
}

impl<S: Surface, const P: usize, const D: usize> Participant for NeuralSurfaceParticipant<S, P, D> {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let position = SVector::from(io.get(self.position));
        let velocity = SVector::from(io.get(self.velocity));
        if !step.is_first() {
            let acceleration = self.acceleration(io.slice(self.input));
            self.observer.advance(step.dt, &acceleration);
        }
        self.observer.update(&position, &velocity);
        self.position_before = position;
        self.outputs.write(io, &self.observer);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::nalgebra::{Vector1, Vector2};

    /// s̃ = ṽ + 2 x̃, corrected by 3 s̃ + 5 x̃ + 2 ṽ.
    #[derive(Clone)]
    struct Line;

    impl Surface for Line {
        fn sliding<const D: usize>(&self, position: &SVector<f64, D>, velocity: &SVector<f64, D>) -> SVector<f64, D> {
            velocity + 2.0 * position
        }

        fn correction<const D: usize>(
            &self,
            position: &SVector<f64, D>,
            velocity: &SVector<f64, D>,
            sliding: &SVector<f64, D>,
        ) -> SVector<f64, D> {
            3.0 * sliding + 5.0 * position + 2.0 * velocity
        }
    }

    fn observer(tuning: Tuning, weights: [f64; 2]) -> NeuralSurfaceObserver<Line, 2, 1> {
        let (position, velocity) = (Vector1::new(1.0), Vector1::new(-0.5));
        NeuralSurfaceObserver::new(Line, tuning, position, velocity, OutputLayer::new(Vector2::from(weights)))
    }

    #[test]
    fn the_imaginary_vehicle_moves_along_a_parabola() {
        let mut observer = observer(Tuning { rate: 0.0, leak: 0.0 }, [0.0; 2]);
        for _ in 0..8 {
            observer.advance(0.25, &Vector1::new(3.0));
        }
        assert_eq!((observer.position.x, observer.velocity.x), (1.0 - 0.5 * 2.0 + 0.5 * 3.0 * 4.0, -0.5 + 3.0 * 2.0));
    }

    #[test]
    fn the_input_is_the_network_s_output_and_the_correction_of_the_errors() {
        let mut observer = observer(Tuning { rate: 0.0, leak: 0.0 }, [0.2, -0.4]);
        observer.update(&Vector1::new(1.5), &Vector1::new(0.25));
        let network = 0.2 * libm::tanh(1.5) - 0.4 * libm::tanh(0.25);
        // x̃ = 0.5, ṽ = 0.75, s̃ = 1.75
        assert_eq!(observer.sliding.x, 1.75);
        assert!((observer.network.x - network).abs() < 1e-15);
        assert!((observer.input.x - (network + 3.0 * 1.75 + 5.0 * 0.5 + 2.0 * 0.75)).abs() < 1e-12);
    }

    #[test]
    fn weights_follow_the_sliding_variable_of_the_last_update_and_leak() {
        let mut observer = observer(Tuning { rate: 2.0, leak: 0.5 }, [0.2, -0.4]);
        observer.update(&Vector1::new(1.5), &Vector1::new(0.25));
        observer.advance(0.1, &Vector1::new(0.0));
        let expected = [(0.2, 1.5), (-0.4, 0.25)]
            .map(|(weight, state)| weight + 0.1 * (2.0 * libm::tanh(state) * 1.75 - 0.5 * weight));
        assert!((observer.layer.weights - Vector2::from(expected)).norm() < 1e-12);
    }

    #[test]
    fn a_constant_uncertainty_is_estimated() {
        let mut observer = observer(Tuning { rate: 1.0, leak: 0.0 }, [0.0; 2]);
        let (dt, input, uncertainty) = (0.001, 0.3, -1.7);
        let (mut position, mut velocity) = (Vector1::new(1.0), Vector1::new(-0.5));
        for _ in 0..20_000 {
            observer.update(&position, &velocity);
            let total = Vector1::new(input + uncertainty);
            position += dt * velocity + 0.5 * dt * dt * total;
            velocity += dt * total;
            observer.advance(dt, &Vector1::new(input));
        }
        assert!((observer.input.x - uncertainty).abs() < 0.01, "{}", observer.input.x);
    }
}
