//! Rebuilds the time derivatives of a reference of which only the position is known. (4.27)

use formation::math::{Differentiator, DifferentiatorGains};
use formation::nalgebra::Vector3;
use formation::wiring::{Bind, Checks, Refusal};
use lockstep::{Field, In, Io, Out, Step};

/// The differentiator of one agent's reference, with its ports.
#[derive(Clone, Debug)]
pub(crate) struct ReferenceRates {
    gains: DifferentiatorGains<4>,
    differentiator: Differentiator<4, 3>,
    reference: In<3>,
    /// x_d at the last step.
    before: Vector3<f64>,
    velocity: Out<3>,
    acceleration: Out<3>,
}

impl ReferenceRates {
    /// What it publishes.
    pub(crate) fn outputs() -> [Field; 2] {
        [
            Field::vector("reference_velocity", 3, "m/s, m/s, rad/s"),
            Field::vector("reference_acceleration", 3, "m/s^2, m/s^2, rad/s^2"),
        ]
    }

    /// Gains have to be positive.
    pub(crate) fn check(checks: Checks, gains: &DifferentiatorGains<4>) -> Checks {
        gains
            .alpha
            .iter()
            .fold(checks, |checks, alpha| checks.positive("diff_alpha", *alpha))
            .positive("diff_beta", gains.beta)
    }

    /// Binds the signals of `agent`.
    pub(crate) fn new(gains: DifferentiatorGains<4>, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        Ok(Self {
            gains,
            differentiator: Differentiator::new(gains, Vector3::zeros()),
            reference: bind.reference(agent, "position")?,
            before: Vector3::zeros(),
            velocity: bind.out(agent, "reference_velocity")?,
            acceleration: bind.out(agent, "reference_acceleration")?,
        })
    }

    /// Advances over the last interval with the reference at its start, and publishes γ2 and γ3.
    pub(crate) fn step(&mut self, step: &Step, io: &mut Io) {
        let reference = Vector3::from(io.get(self.reference));
        if step.is_first() {
            self.differentiator = Differentiator::new(self.gains, reference);
        } else {
            self.differentiator.advance(step.dt, &self.before, &Vector3::zeros());
        }
        self.before = reference;
        let [_, velocity, acceleration, _] = self.differentiator.states;
        io.set(self.velocity, velocity.into());
        io.set(self.acceleration, acceleration.into());
    }
}
