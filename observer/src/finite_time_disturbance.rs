//! The finite-time disturbance observer of section 2.4: estimates the uncertainty of a vehicle of order 2, and its rate. (2.11)

use formation::math::{Differentiator, DifferentiatorGains};
use formation::nalgebra::SVector;
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::applied_input::AppliedInput;

/// Gains of the observer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FiniteTimeDisturbance {
    /// α1, gain of the velocity error.
    pub alpha1: f64,
    /// α2, gain of the estimate.
    pub alpha2: f64,
    /// α3, gain of its rate.
    pub alpha3: f64,
    /// βw, Lipschitz constant of the rate of the uncertainty, m/s⁴ or rad/s⁴.
    pub beta_w: f64,
}

impl FiniteTimeDisturbance {
    /// The observer of a vehicle with `D` coordinates that moves at `velocity` when it starts. Its states are γ1, which follows
    /// the velocity, γ2, the estimate of the uncertainty, and γ3, the estimate of its rate.
    pub fn observer<const D: usize>(&self, velocity: SVector<f64, D>) -> Differentiator<3, D> {
        let gains = DifferentiatorGains { alpha: [self.alpha1, self.alpha2, self.alpha3], beta: self.beta_w };
        Differentiator::new(gains, velocity)
    }
}

impl Component for FiniteTimeDisturbance {
    fn check(&self, _: &Context) -> Checks {
        Checks::default()
            .positive("alpha1", self.alpha1)
            .positive("alpha2", self.alpha2)
            .positive("alpha3", self.alpha3)
            .positive("beta_w", self.beta_w)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        match context.agents[agent].vehicle.coordinates() {
            6 => published::<6>().fields(),
            _ => published::<3>().fields(),
        }
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        match context.agents[agent].vehicle.coordinates() {
            6 => Ok(Box::new(FiniteTimeDisturbanceParticipant::<6>::new(self, context, agent, bind)?)),
            _ => Ok(Box::new(FiniteTimeDisturbanceParticipant::<3>::new(self, context, agent, bind)?)),
        }
    }
}

/// γ1, γ2 and γ3.
fn published<const D: usize>() -> Outputs<Differentiator<3, D>> {
    Outputs::new()
        .vector("velocity", "", |observer: &Differentiator<3, D>| observer.states[0])
        .vector("disturbance", "", |observer| observer.states[1])
        .vector("disturbance_rate", "", |observer| observer.states[2])
}

struct FiniteTimeDisturbanceParticipant<const D: usize> {
    observer: Differentiator<3, D>,
    applied: AppliedInput,
    /// Coordinates and velocities of the step before: the equations are advanced with the values at the start of the interval.
    position_before: SVector<f64, D>,
    velocity_before: SVector<f64, D>,
    position: In<D>,
    velocity: In<D>,
    outputs: BoundOutputs<Differentiator<3, D>>,
}

impl<const D: usize> FiniteTimeDisturbanceParticipant<D> {
    fn new(gains: &FiniteTimeDisturbance, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let row = &context.agents[agent];
        let start = SVector::from_column_slice(&row.velocity);
        Ok(Self {
            observer: gains.observer(start),
            applied: AppliedInput::new(context, agent, bind)?,
            position_before: SVector::from_column_slice(&row.position),
            velocity_before: start,
            position: bind.state(agent, "position")?,
            velocity: bind.state(agent, "velocity")?,
            outputs: published().bind(agent, bind)?,
        })
    }
}

impl<const D: usize> Participant for FiniteTimeDisturbanceParticipant<D> {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        if !step.is_first() {
            let known = self.applied.effect(io, &self.position_before);
            self.observer.advance(step.dt, &self.velocity_before, &known); // (2.11)
        }
        self.position_before = io.get(self.position).into();
        self.velocity_before = io.get(self.velocity).into();
        self.outputs.write(io, &self.observer);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::nalgebra::Vector1;

    /// A vehicle under `w = 2 + sin t` and a known input: estimate and rate are there within a second, and stay.
    #[test]
    fn the_uncertainty_and_its_rate_are_found_in_finite_time() {
        let gains = FiniteTimeDisturbance { alpha1: 3.0, alpha2: 6.0, alpha3: 3.0, beta_w: 10.0 };
        let mut observer = gains.observer(Vector1::new(0.3));
        let (dt, mut velocity) = (1e-3, 0.3);
        for k in 0..8000 {
            let time = k as f64 * dt;
            let known = libm::cos(3.0 * time);
            observer.advance(dt, &Vector1::new(velocity), &Vector1::new(known));
            velocity += dt * (known + 2.0 + libm::sin(time));
            let [_, estimate, rate] = observer.states;
            if k > 1000 {
                let now = time + dt;
                assert!((estimate[0] - 2.0 - libm::sin(now)).abs() < 0.01, "{time}: {estimate}");
                assert!((rate[0] - libm::cos(now)).abs() < 0.2, "{time}: {rate}");
            }
        }
    }
}
