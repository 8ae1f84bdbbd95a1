//! The linear adaptive observer of section 5.4: estimates the lumped uncertainty without a network and without a compact set.

use formation::config::Diagonal;
use formation::nalgebra::SVector;
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::applied_input::AppliedInput;

/// Gains of the observer, each a number or one per coordinate.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Adaptive {
    /// η5, adaptation rate, 1/s².
    pub eta5: Diagonal,
    /// η6, leakage, 1/s.
    pub eta6: Diagonal,
    /// K̃, gain of the observation error, 1/s.
    pub ktilde: Diagonal,
}

/// The gains as vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveGains<const D: usize> {
    /// η5.
    pub adaptation: SVector<f64, D>,
    /// η6.
    pub leakage: SVector<f64, D>,
    /// K̃.
    pub correction: SVector<f64, D>,
}

/// The observer of a state of `D` numbers that the input drives: the coordinates of a vehicle of order 1, the velocities of
/// one of order 2. Measurements may come at any interval.
#[derive(Clone, Debug)]
pub struct AdaptiveObserver<const D: usize> {
    gains: AdaptiveGains<D>,
    /// x̂ (or v̂).
    pub state: SVector<f64, D>,
    /// Ê, the adapted part of the estimate.
    pub adapted: SVector<f64, D>,
    /// û = Ê + K̃ x̃, the estimate of the lumped uncertainty.
    pub estimate: SVector<f64, D>,
    /// The measurement that was taken in last.
    measured: SVector<f64, D>,
}

impl<const D: usize> AdaptiveObserver<D> {
    /// An observer at the state `start` that has seen the measurement `measured` and no disturbance.
    pub fn new(gains: AdaptiveGains<D>, start: SVector<f64, D>, measured: SVector<f64, D>) -> Self {
        Self { gains, state: start, adapted: SVector::zeros(), estimate: SVector::zeros(), measured }
    }

    /// Advances over the last `dt` seconds, in which the input had the effect `driven` (ĝu and drift), and takes in the
    /// measurement of now. All right-hand sides are those of the start of the interval. (5.39) to (5.41)
    pub fn advance(&mut self, dt: f64, driven: &SVector<f64, D>, measured: &SVector<f64, D>) {
        let AdaptiveGains { adaptation, leakage, correction } = &self.gains;
        let error = self.measured - self.state;
        let estimate = self.adapted + correction.component_mul(&error);
        self.state += dt * (driven + estimate);
        self.adapted += dt * (adaptation.component_mul(&error) - leakage.component_mul(&self.adapted));
        self.measured = *measured;
        self.estimate = self.adapted + correction.component_mul(&(measured - self.state));
    }
}

impl Component for Adaptive {
    fn check(&self, context: &Context) -> Checks {
        let channels = context.agents.iter().map(|agent| agent.vehicle.coordinates());
        channels.fold(Checks::default(), |checks, channels| {
            [("eta5", &self.eta5), ("eta6", &self.eta6), ("ktilde", &self.ktilde)].into_iter().fold(
                checks,
                |checks, (field, gain)| match gain.problem(channels) {
                    Some(problem) => checks.require(false, field, problem),
                    None => checks,
                },
            )
        })
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        let vehicle = &context.agents[agent].vehicle;
        match vehicle.coordinates() {
            6 => published::<6>(vehicle.order()).fields(),
            _ => published::<3>(vehicle.order()).fields(),
        }
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        match context.agents[agent].vehicle.coordinates() {
            6 => Ok(Box::new(AdaptiveParticipant::<6>::new(self, context, agent, bind)?)),
            _ => Ok(Box::new(AdaptiveParticipant::<3>::new(self, context, agent, bind)?)),
        }
    }
}

/// The signal of the plant whose derivative the input sets, and the name of its estimate.
fn state_signal(order: usize) -> &'static str {
    if order == 1 { "position" } else { "velocity" }
}

fn published<const D: usize>(order: usize) -> Outputs<AdaptiveObserver<D>> {
    Outputs::new()
        .vector(state_signal(order), "", |observer: &AdaptiveObserver<D>| observer.state)
        .vector("disturbance", "", |observer| observer.estimate)
        .vector("adapted", "", |observer| observer.adapted)
}

struct AdaptiveParticipant<const D: usize> {
    /// Made at the first step, from the first measurement.
    observer: Option<AdaptiveObserver<D>>,
    gains: AdaptiveGains<D>,
    start: SVector<f64, D>,
    applied: AppliedInput,
    /// Coordinates of the step before, at which the input of the last interval acted.
    position_before: SVector<f64, D>,
    position: In<D>,
    measured: In<D>,
    outputs: BoundOutputs<AdaptiveObserver<D>>,
}

impl<const D: usize> AdaptiveParticipant<D> {
    fn new(gains: &Adaptive, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let order = context.agents[agent].vehicle.order();
        let row = &context.agents[agent];
        let start = if order == 1 { &row.estimate } else { &row.estimate_velocity };
        Ok(Self {
            observer: None,
            gains: AdaptiveGains {
                adaptation: gains.eta5.vector().map_err(Refusal)?,
                leakage: gains.eta6.vector().map_err(Refusal)?,
                correction: gains.ktilde.vector().map_err(Refusal)?,
            },
            start: SVector::from_column_slice(start),
            applied: AppliedInput::new(context, agent, bind)?,
            position_before: SVector::zeros(),
            position: bind.state(agent, "position")?,
            measured: bind.state(agent, state_signal(order))?,
            outputs: published(order).bind(agent, bind)?,
        })
    }
}

impl<const D: usize> Participant for AdaptiveParticipant<D> {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let measured = SVector::from(io.get(self.measured));
        let observer = match &mut self.observer {
            Some(observer) => {
                let driven = self.applied.effect(io, &self.position_before);
                observer.advance(step.dt, &driven, &measured);
                observer
            }
            None => self.observer.insert(AdaptiveObserver::new(self.gains, self.start, measured)),
        };
        self.position_before = SVector::from(io.get(self.position));
        self.outputs.write(io, observer);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::nalgebra::{Vector1, Vector3};

    fn gains() -> AdaptiveGains<3> {
        AdaptiveGains {
            adaptation: Vector3::new(15.0, 15.0, 6.0),
            leakage: Vector3::repeat(0.8),
            correction: Vector3::new(8.0, 8.0, 2.0),
        }
    }

    /// The leak leaves an offset: in rest Ê = η5/η6 x̃ and û = w.
    #[test]
    fn a_constant_disturbance_is_found() {
        let disturbance = Vector3::new(0.1, -0.2, 0.05);
        let driven = Vector3::new(0.3, 0.0, -0.1);
        let dt = 1e-3;
        let mut state = Vector3::zeros();
        let mut observer = AdaptiveObserver::new(gains(), state, state);
        for _ in 0..30_000 {
            state += dt * (driven + disturbance);
            observer.advance(dt, &driven, &state);
        }
        assert!((observer.estimate - disturbance).norm() < 1e-9, "{}", observer.estimate);
        let error = (state - observer.state).component_div(&disturbance);
        let expected = Vector3::new(1.0 / (8.0 + 15.0 / 0.8), 1.0 / (8.0 + 15.0 / 0.8), 1.0 / (2.0 + 6.0 / 0.8));
        assert!((error - expected).norm() < 1e-9, "{error}");
    }

    #[test]
    fn one_step_uses_the_start_of_the_interval() {
        let gains =
            AdaptiveGains { adaptation: Vector1::new(15.0), leakage: Vector1::new(0.8), correction: Vector1::new(8.0) };
        let mut observer = AdaptiveObserver::new(gains, Vector1::new(0.1), Vector1::new(0.4));
        observer.adapted[0] = 0.5;
        observer.advance(0.01, &Vector1::new(2.0), &Vector1::new(0.6));
        let state = 0.1 + 0.01 * (2.0 + 0.5 + 8.0 * 0.3);
        let adapted = 0.5 + 0.01 * (15.0 * 0.3 - 0.8 * 0.5);
        assert!((observer.state[0] - state).abs() < 1e-15);
        assert!((observer.adapted[0] - adapted).abs() < 1e-15);
        assert!((observer.estimate[0] - (adapted + 8.0 * (0.6 - state))).abs() < 1e-15);
    }
}
