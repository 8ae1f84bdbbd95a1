//! What observers that measure positions only have in common: their ports, and what they store from one step to the next.

use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Outputs, Refusal};
use lockstep::{Field, In, Io};

use crate::applied_input::AppliedInput;

/// The position of a planar robot of order 2 and the input that drives it.
pub(crate) struct PositionFeedback {
    position: In<3>,
    input: AppliedInput,
    /// x at the last step.
    before: Vector3<f64>,
    outputs: BoundOutputs<Estimates>,
}

/// What every such observer estimates.
pub(crate) struct Estimates {
    /// x̂, m and rad.
    pub(crate) position: Vector3<f64>,
    /// v̂, m/s and rad/s.
    pub(crate) velocity: Vector3<f64>,
    /// ŵ, m/s² and rad/s².
    pub(crate) disturbance: Vector3<f64>,
}

fn published() -> Outputs<Estimates> {
    Outputs::new()
        .vector("position", "m, m, rad", |estimates: &Estimates| estimates.position)
        .vector("velocity", "m/s, m/s, rad/s", |estimates| estimates.velocity)
        .vector("disturbance", "m/s^2, m/s^2, rad/s^2", |estimates| estimates.disturbance)
}

/// The start of an interval: the measurement, and the acceleration by the input that acted from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its length, s.
    pub dt: f64,
    /// x at its start, m and rad.
    pub position: Vector3<f64>,
    /// g(θ) u there, m/s² and rad/s².
    pub acceleration: Vector3<f64>,
}

impl PositionFeedback {
    /// Outputs of every such observer.
    pub(crate) fn outputs() -> Vec<Field> {
        published().fields()
    }

    /// Binds the signals of `agent` for the observer called `name`.
    pub(crate) fn new(name: &str, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let vehicle = &context.agents[agent].nominal;
        if vehicle.omni().is_none() || vehicle.order() != 2 {
            let message = format!(
                "the observer `{name}` estimates the velocity of a planar robot whose inputs set accelerations (order 2); this vehicle is not one"
            );
            return Err(Refusal(message));
        }
        Ok(Self {
            position: bind.state(agent, "position")?,
            input: AppliedInput::new(context, agent, bind)?,
            before: Vector3::zeros(),
            outputs: published().bind(agent, bind)?,
        })
    }

    /// x of this step, and the interval of `dt` seconds that ends with it.
    pub(crate) fn read(&mut self, io: &Io, dt: f64) -> (Vector3<f64>, Interval) {
        let before = self.before;
        let acceleration = self.input.effect(io, &before);
        self.before = Vector3::from(io.get(self.position));
        (self.before, Interval { dt, position: before, acceleration })
    }

    /// Writes the estimates of this step.
    pub(crate) fn publish(&self, io: &mut Io, estimates: &Estimates) {
        self.outputs.write(io, estimates);
    }
}
