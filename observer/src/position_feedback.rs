//! What observers that measure positions only have in common: their ports, and what they store from one step to the next.

use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::wiring::{Bind, Refusal};
use lockstep::{Field, In, Io, Out};

use crate::applied_input::AppliedInput;

/// The position of a planar robot of order 2 and the input that drives it.
#[derive(Clone, Debug)]
pub(crate) struct PositionFeedback {
    position: In<3>,
    input: AppliedInput,
    /// x at the last step.
    before: Vector3<f64>,
    outputs: [Out<3>; 3],
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
        vec![
            Field::vector("position", 3, "m, m, rad"),
            Field::vector("velocity", 3, "m/s, m/s, rad/s"),
            Field::vector("disturbance", 3, "m/s^2, m/s^2, rad/s^2"),
        ]
    }

    /// Binds the signals of `agent` for the observer called `name`.
    pub(crate) fn new(name: &str, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let vehicle = &context.agents[agent].nominal;
        if vehicle.omni().is_none() || vehicle.order() != 2 {
            let message = format!(
                "the observer `{name}` estimates the velocity of a planar robot whose inputs set accelerations (order 2); this vehicle is none"
            );
            return Err(Refusal(message));
        }
        let outputs = [bind.out(agent, "position")?, bind.out(agent, "velocity")?, bind.out(agent, "disturbance")?];
        Ok(Self {
            position: bind.state(agent, "position")?,
            input: AppliedInput::new(context, agent, bind)?,
            before: Vector3::zeros(),
            outputs,
        })
    }

    /// x of this step, and the interval of `dt` seconds that ends with it.
    pub(crate) fn read(&mut self, io: &Io, dt: f64) -> (Vector3<f64>, Interval) {
        let before = self.before;
        let acceleration = self.input.effect(io, &before);
        self.before = Vector3::from(io.get(self.position));
        (self.before, Interval { dt, position: before, acceleration })
    }

    /// Writes x̂, v̂ and ŵ.
    pub(crate) fn publish(&self, io: &mut Io, estimates: [Vector3<f64>; 3]) {
        for (port, value) in self.outputs.into_iter().zip(estimates) {
            io.set(port, value.into());
        }
    }
}
