//! Two finite-time observers side by side: one finds the mismatched disturbance d, the other the matched one w. (3.7)

use formation::config::PerAgent;
use formation::math::{Differentiator, DifferentiatorGains, clip};
use formation::nalgebra::SVector;
use formation::scenario::Context;
use formation::vehicle::{MAX_COORDINATES, MAX_INPUTS, Vehicle};
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal, Role};
use lockstep::{Fault, Field, In, Io, Participant, Slice, Step, Timing};
use schemars::JsonSchema;
use serde::Deserialize;

/// Gains of both observers, one number for all agents or one each.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DualDisturbance {
    /// α1, first gain of the observer of d.
    pub alpha1: PerAgent,
    /// α2.
    pub alpha2: PerAgent,
    /// α3.
    pub alpha3: PerAgent,
    /// α4, first gain of the observer of w.
    pub alpha4: PerAgent,
    /// α5.
    pub alpha5: PerAgent,
    /// α6.
    pub alpha6: PerAgent,
    /// βd, bound of the second derivative of d.
    pub beta_d: PerAgent,
    /// βw, bound of the second derivative of w.
    pub beta_w: PerAgent,
}

/// What acts on a vehicle whose position and velocity are measured, `dx/dt = v + d` and `dv/dt = a + w`.
#[derive(Clone, Debug, PartialEq)]
pub struct DualDisturbanceObserver<const D: usize> {
    /// γ1 follows x, γ2 is d̂, γ3 its rate.
    pub mismatched: Differentiator<3, D>,
    /// γ4 follows v, γ5 is ŵ, γ6 its rate.
    pub matched: Differentiator<3, D>,
}

impl<const D: usize> DualDisturbanceObserver<D> {
    /// An observer that knows the state it starts from, and of no disturbance.
    pub fn new(
        [mismatched, matched]: [DifferentiatorGains<3>; 2],
        position: SVector<f64, D>,
        velocity: SVector<f64, D>,
    ) -> Self {
        Self { mismatched: Differentiator::new(mismatched, position), matched: Differentiator::new(matched, velocity) }
    }

    /// Advances over `dt` seconds. All arguments are those of the start of the interval; `acceleration` is what the input causes.
    pub fn advance(
        &mut self,
        dt: f64,
        position: &SVector<f64, D>,
        velocity: &SVector<f64, D>,
        acceleration: &SVector<f64, D>,
    ) {
        self.mismatched.advance(dt, position, velocity); // (3.7), γ1 to γ3
        self.matched.advance(dt, velocity, acceleration); // (3.7), γ4 to γ6
    }
}

impl DualDisturbance {
    fn named(&self) -> [(&'static str, &PerAgent); 8] {
        [
            ("alpha1", &self.alpha1),
            ("alpha2", &self.alpha2),
            ("alpha3", &self.alpha3),
            ("alpha4", &self.alpha4),
            ("alpha5", &self.alpha5),
            ("alpha6", &self.alpha6),
            ("beta_d", &self.beta_d),
            ("beta_w", &self.beta_w),
        ]
    }

    /// The gains of `agent` (from 0): those of d, then those of w.
    fn gains(&self, context: &Context, agent: usize) -> Result<[DifferentiatorGains<3>; 2], Refusal> {
        let of = |rule: &PerAgent| context.value(rule, agent).map_err(Refusal);
        let mismatched = [of(&self.alpha1)?, of(&self.alpha2)?, of(&self.alpha3)?];
        let matched = [of(&self.alpha4)?, of(&self.alpha5)?, of(&self.alpha6)?];
        Ok([
            DifferentiatorGains { alpha: mismatched, beta: of(&self.beta_d)? },
            DifferentiatorGains { alpha: matched, beta: of(&self.beta_w)? },
        ])
    }
}

impl Component for DualDisturbance {
    fn check(&self, context: &Context) -> Checks {
        self.named().iter().fold(Checks::default(), |checks, (field, rule)| checks.positive_each(field, rule, context))
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
            6 => Ok(Box::new(DualDisturbanceParticipant::<6>::new(self, context, agent, bind)?)),
            _ => Ok(Box::new(DualDisturbanceParticipant::<3>::new(self, context, agent, bind)?)),
        }
    }
}

/// γ1, γ2, γ3, γ4, γ5, γ6.
fn published<const D: usize>() -> Outputs<DualDisturbanceObserver<D>> {
    Outputs::new()
        .vector("position", "", |observer: &DualDisturbanceObserver<D>| observer.mismatched.states[0])
        .vector("mismatched", "", |observer| observer.mismatched.states[1])
        .vector("mismatched_rate", "", |observer| observer.mismatched.states[2])
        .vector("velocity", "", |observer| observer.matched.states[0])
        .vector("disturbance", "", |observer| observer.matched.states[1])
        .vector("disturbance_rate", "", |observer| observer.matched.states[2])
}

struct DualDisturbanceParticipant<const D: usize> {
    observer: DualDisturbanceObserver<D>,
    vehicle: Vehicle,
    input_limit: Option<f64>,
    /// Measurements of the step before, at which the last interval started.
    before: [SVector<f64, D>; 2],
    measured: [In<D>; 2],
    input: Slice,
    outputs: BoundOutputs<DualDisturbanceObserver<D>>,
}

impl<const D: usize> DualDisturbanceParticipant<D> {
    fn new(parameters: &DualDisturbance, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let row = &context.agents[agent];
        let start = [&row.position, &row.velocity].map(|values| SVector::from_column_slice(values));
        let [position, velocity] = start;
        Ok(Self {
            observer: DualDisturbanceObserver::new(parameters.gains(context, agent)?, position, velocity),
            vehicle: row.nominal.clone(),
            input_limit: context.input_limit,
            before: start,
            measured: [bind.state(agent, "position")?, bind.state(agent, "velocity")?],
            input: bind.slice(Role::Controller, agent, "input", row.nominal.inputs(), Timing::Delayed)?,
            outputs: published().bind(agent, bind)?,
        })
    }

    /// g(x) u + drift at the start of the last interval, with u as the actuators applied it.
    fn acceleration(&self, command: &[f64]) -> SVector<f64, D> {
        let mut input = [0.0; MAX_INPUTS];
        for (input, command) in input.iter_mut().zip(command) {
            *input = self.input_limit.map_or(*command, |limit| clip(*command, limit));
        }
        let mut effect = [0.0; MAX_COORDINATES];
        self.vehicle.effect(self.before[0].as_slice(), &input[..command.len()], &mut effect);
        SVector::from_fn(|j, _| effect[j] + self.vehicle.drift(j))
    }
}

impl<const D: usize> Participant for DualDisturbanceParticipant<D> {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        if !step.is_first() {
            let acceleration = self.acceleration(io.slice(self.input));
            let [position, velocity] = &self.before;
            self.observer.advance(step.dt, position, velocity, &acceleration);
        }
        self.before = self.measured.map(|signal| SVector::from(io.get(signal)));
        self.outputs.write(io, &self.observer);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use formation::nalgebra::Vector1;
    use proptest::prelude::*;

    use super::*;

    const GAINS: [DifferentiatorGains<3>; 2] = [
        DifferentiatorGains { alpha: [4.0, 8.0, 4.0], beta: 0.7 },
        DifferentiatorGains { alpha: [6.0, 12.0, 6.0], beta: 5.0 },
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        /// Each disturbance is found by the observer that is meant for it, with its sign, whatever the known input does.
        #[test]
        fn both_disturbances_are_found_with_their_rates(bias_d in -0.5..0.5f64, bias_w in -2.0..2.0f64, phase in 0.0..6.2f64, push in -3.0..3.0f64) {
            let dt = 1e-4;
            let (mut position, mut velocity) = (Vector1::new(0.4), Vector1::new(-0.1));
            let mut observer = DualDisturbanceObserver::new(GAINS, position, velocity);
            let mismatched = |t: f64| bias_d + 0.3 * libm::sin(t + phase);
            let matched = |t: f64| bias_w + 0.5 * libm::sin(1.5 * t + phase);
            let mut time = 0.0;
            for k in 0..40_000 {
                time = f64::from(k) * dt;
                let acceleration = Vector1::new(push * libm::cos(2.0 * time));
                observer.advance(dt, &position, &velocity, &acceleration);
                position += dt * (velocity + Vector1::new(mismatched(time)));
                velocity += dt * (acceleration + Vector1::new(matched(time)));
            }
            time += dt;
            let [_, d, d_rate] = observer.mismatched.states.map(|state| state.x);
            let [_, w, w_rate] = observer.matched.states.map(|state| state.x);
            prop_assert!((d - mismatched(time)).abs() < 2e-3, "{d} {}", mismatched(time));
            prop_assert!((w - matched(time)).abs() < 5e-3, "{w} {}", matched(time));
            prop_assert!((d_rate - 0.3 * libm::cos(time + phase)).abs() < 0.05);
            prop_assert!((w_rate - 0.75 * libm::cos(1.5 * time + phase)).abs() < 0.15);
        }
    }

    #[test]
    fn a_known_state_without_disturbances_stays_known() {
        let mut observer = DualDisturbanceObserver::new(GAINS, Vector1::new(1.0), Vector1::new(0.5));
        observer.advance(0.01, &Vector1::new(1.0), &Vector1::new(0.5), &Vector1::new(-2.0));
        assert_eq!(observer.mismatched.states.map(|state| state.x), [1.005, 0.0, 0.0]);
        assert_eq!(observer.matched.states.map(|state| state.x), [0.48, 0.0, 0.0]);
    }
}
