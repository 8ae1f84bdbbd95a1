//! Rebuilds the time derivatives of a reference of which only the position is known. (4.27)

use formation::math::{Differentiator, DifferentiatorGains};
use formation::nalgebra::Vector3;
use formation::wiring::{Bind, BoundOutputs, Checks, Outputs, Refusal};
use lockstep::{Field, In, Io, Step};

/// The differentiator of one agent's reference, with its ports.
pub(crate) struct ReferenceRates {
    gains: DifferentiatorGains<4>,
    differentiator: Differentiator<4, 3>,
    reference: In<3>,
    /// x_d at the last step.
    before: Vector3<f64>,
    outputs: BoundOutputs<Differentiator<4, 3>>,
}

/// γ2 and γ3.
fn published() -> Outputs<Differentiator<4, 3>> {
    Outputs::new()
        .vector("reference_velocity", "m/s, m/s, rad/s", |rates: &Differentiator<4, 3>| rates.states[1])
        .vector("reference_acceleration", "m/s^2, m/s^2, rad/s^2", |rates| rates.states[2])
}

impl ReferenceRates {
    /// What it publishes.
    pub(crate) fn outputs() -> Vec<Field> {
        published().fields()
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
            outputs: published().bind(agent, bind)?,
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
        self.outputs.write(io, &self.differentiator);
    }
}
