//! What the formation controllers of section 6.5 share: errors, sliding variable and the demanded acceleration.

use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, Outputs, Refusal};
use lockstep::{Field, In, Io};

use crate::LocalError;

/// What a controller knows of its agent, its neighbours and the reference at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormationErrors {
    /// δx, own position error, m and rad.
    pub position: Vector3<f64>,
    /// δv, own velocity error.
    pub velocity: Vector3<f64>,
    /// ex, position error relative to reference and neighbours.
    pub local_position: Vector3<f64>,
    /// ev, velocity error relative to reference and neighbours.
    pub local_velocity: Vector3<f64>,
    /// Second derivative of the reference.
    pub acceleration: Vector3<f64>,
}

/// Gains of the sliding mode formation feedback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingFeedback {
    /// c, gain of the sliding variable, 1/s.
    pub gain: f64,
    /// λ, slope of the sliding surface, 1/s.
    pub slope: f64,
}

impl SlidingFeedback {
    /// s.
    pub fn sliding(&self, errors: &FormationErrors) -> Vector3<f64> {
        errors.local_velocity + self.slope * errors.local_position // (6.21)
    }

    /// The acceleration that the nominal law asks of the vehicle, `disturbance` being the estimate ŵ. The last two terms are
    /// the agent's own errors, which the coupling of the errors turns into the neighbourhood's.
    pub fn acceleration(&self, errors: &FormationErrors, disturbance: &Vector3<f64>) -> Vector3<f64> {
        errors.acceleration
            - disturbance
            - self.gain * self.sliding(errors)
            - self.slope * errors.velocity
            - errors.position // (6.22)
    }
}

/// The signals that a controller of this family reads.
pub(crate) struct FormationInputs {
    position_error: LocalError,
    velocity_error: LocalError,
    reference_acceleration: In<3>,
    position: In<3>,
    velocity: In<3>,
}

impl FormationInputs {
    pub(crate) fn new(context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        Ok(Self {
            position_error: LocalError::new(context, agent, bind, "position")?,
            velocity_error: LocalError::new(context, agent, bind, "velocity")?,
            reference_acceleration: bind.reference(agent, "acceleration")?,
            position: bind.state(agent, "position")?,
            velocity: bind.state(agent, "velocity")?,
        })
    }

    pub(crate) fn errors(&self, io: &Io) -> FormationErrors {
        FormationErrors {
            position: self.position_error.own(io),
            velocity: self.velocity_error.own(io),
            local_position: self.position_error.local(io),
            local_velocity: self.velocity_error.local(io),
            acceleration: io.get(self.reference_acceleration).into(),
        }
    }

    pub(crate) fn position(&self, io: &Io) -> Vector3<f64> {
        io.get(self.position).into()
    }

    pub(crate) fn velocity(&self, io: &Io) -> Vector3<f64> {
        io.get(self.velocity).into()
    }
}

/// The planar vehicle of `agent` as its controller knows it, and the limit of its inputs.
pub(crate) fn vehicle<'a>(context: &'a Context, agent: usize, kind: &str) -> Result<(&'a Omni, f64), Refusal> {
    let omni = context.agents[agent].nominal.omni();
    let omni =
        omni.ok_or_else(|| Refusal(format!("the controller `{kind}` drives planar robots with three inputs")))?;
    Ok((omni, context.input_limit.unwrap_or(f64::INFINITY)))
}

/// What every controller of this family publishes, first of all: its command and the error that led to it.
pub(crate) fn published(context: &Context, agent: usize) -> Outputs<(Command, FormationErrors)> {
    let input = context.agents[agent].vehicle.input_field();
    let demanded = Field { name: "ucom".into(), ..input.clone() };
    Outputs::new()
        .field(input, |(command, _): &(Command, FormationErrors)| command.input)
        .field(demanded, |(command, _)| command.demanded)
        .vector("sliding", "m/s, m/s, rad/s", |(command, _)| command.sliding)
        .vector("error", "m, m, rad", |(_, errors)| errors.local_position)
}

/// An input with what led to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// What the actuators do.
    pub input: Vector3<f64>,
    /// What the law asked for, before any limit.
    pub demanded: Vector3<f64>,
    /// s.
    pub sliding: Vector3<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-10.0..10.0f64).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn errors_of_one_agent_decay_as_the_lyapunov_function_says(
            position in vector(), velocity in vector(), acceleration in vector(), disturbance in vector(),
            gain in 0.1..10.0f64, slope in 0.1..10.0f64,
        ) {
            let law = SlidingFeedback { gain, slope };
            let errors = FormationErrors {
                position, velocity, local_position: position, local_velocity: velocity, acceleration,
            };
            // The disturbance is estimated exactly, and the agent is the only one.
            let error_acceleration = law.acceleration(&errors, &disturbance) + disturbance - acceleration;
            let sliding = law.sliding(&errors);
            // V = (s² + δx²) / 2 along the motion.
            let change = sliding.dot(&(error_acceleration + slope * velocity)) + position.dot(&velocity);
            let expected = -gain * sliding.norm_squared() - slope * position.norm_squared();
            prop_assert!((change - expected).abs() <= 1e-9 * (1.0 + expected.abs()));
        }
    }

    #[test]
    fn the_agent_s_own_errors_and_those_of_its_neighbourhood_are_told_apart() {
        let unit = Vector3::x();
        let law = SlidingFeedback { gain: 2.0, slope: 3.0 };
        let zero = Vector3::zeros();
        let none = FormationErrors {
            position: zero,
            velocity: zero,
            local_position: zero,
            local_velocity: zero,
            acceleration: zero,
        };
        let acceleration = |errors: FormationErrors| law.acceleration(&errors, &zero).x;
        assert_eq!(acceleration(FormationErrors { position: unit, ..none }), -1.0);
        assert_eq!(acceleration(FormationErrors { velocity: unit, ..none }), -3.0);
        assert_eq!(acceleration(FormationErrors { local_position: unit, ..none }), -6.0);
        assert_eq!(acceleration(FormationErrors { local_velocity: unit, ..none }), -2.0);
    }
}
