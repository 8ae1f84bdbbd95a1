//! A vehicle: a cart on two driven wheels. It rolls where it heads, and never sideways.
//!
//! With the position `(x, y)` of its axle, the heading `θ`, the speed `v` and the turn rate `ω`, and with a force `F` along the
//! heading and a torque `τ` as inputs,
//!
//! ```text
//! dx/dt = v cos θ     dy/dt = v sin θ     dθ/dt = ω
//! m dv/dt = F - c v                       I dω/dt = τ - d ω
//! ```
//!
//! Mass `m` and moment of inertia `I` are those of the agents in the scenario, the drag `c` and `d` is a parameter of this plant.

use formation::math::Rk4;
use formation::nalgebra::Vector3;
use formation::scenario::{Context, Disturbance};
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal, Role};
use lockstep::{Fault, Field, In, Io, Participant, Step, Timing};
use plant::Actuators;
use schemars::JsonSchema;
use serde::Deserialize;

/// `[plant]` of a scenario.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Carts {
    /// Drag of rolling c, N s/m.
    pub c: f64,
    /// Drag of turning d, N m s.
    pub d: f64,
}

impl Component for Carts {
    fn check(&self, _: &Context) -> Checks {
        Checks::default().not_negative("c", self.c).not_negative("d", self.d)
    }

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        published().fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let carts = agents.iter().map(|&agent| Cart::new(self, context, agent, bind));
        Ok(Box::new(Fleet { carts: carts.collect::<Result<_, _>>()? }))
    }
}

/// How a cart stands and moves after a step.
struct Motion {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
}

/// The outputs: name, unit and value of each.
fn published() -> Outputs<Motion> {
    Outputs::new().vector("position", "m, m, rad", |motion: &Motion| motion.position).vector(
        "velocity",
        "m/s, m/s, rad/s",
        |motion| motion.velocity,
    )
}

/// The participant: all carts of the run, or one of them if the scenario says `per_agent = true`.
struct Fleet {
    carts: Vec<Cart>,
}

impl Participant for Fleet {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for cart in &mut self.carts {
            if !step.is_first() {
                cart.advance(step.time() - step.dt, step.dt, io);
            }
            cart.publish(io);
        }
        Ok(())
    }
}

/// One cart.
struct Cart {
    model: Model,
    /// What `[disturbance]` of the scenario adds to the accelerations.
    disturbance: Disturbance,
    /// Clips the inputs to the `UM` of the scenario.
    actuators: Actuators,
    integrator: Rk4,
    /// x, y, θ, v, ω.
    state: [f64; 5],
    input: In<2>,
    outputs: BoundOutputs<Motion>,
}

impl Cart {
    fn new(parameters: &Carts, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let row = &context.agents[agent];
        let body = row.vehicle.omni().ok_or_else(|| {
            Refusal("the plant `carts` moves in a plane, which in `[vehicle]` is `kind = \"integrator\"`".into())
        })?;
        let ([x, y, heading], [vx, vy, turn]) = (triple(&row.position), triple(&row.velocity));
        let (sin, cos) = libm::sincos(heading);
        Ok(Self {
            model: Model { mass: body.mass, inertia: body.inertia, c: parameters.c, d: parameters.d },
            disturbance: context.disturbance[agent].clone(),
            actuators: Actuators::new(context),
            integrator: Rk4::new(5),
            state: [x, y, heading, vx * cos + vy * sin, turn],
            // The command of the step before: it is in force until this step.
            input: bind.read(Role::Controller, agent, "input", Timing::Delayed)?,
            outputs: published().bind(agent, bind)?,
        })
    }

    fn advance(&mut self, time: f64, dt: f64, io: &Io) {
        self.actuators.apply(&io.get(self.input));
        let [force, torque, ..] = self.actuators.output;
        let Self { model, disturbance, integrator, state, .. } = self;
        integrator.step(time, dt, state, |t, x, slope| {
            let state = [x[0], x[1], x[2], x[3], x[4]];
            slope.copy_from_slice(&model.slope(&state, force, torque));
            let mut push = [0.0; 3];
            disturbance.matched_at(t, &x[..3], &model.velocity(&state), &mut push);
            let (sin, cos) = libm::sincos(x[2]);
            slope[3] += push[0] * cos + push[1] * sin; // the wheels bear what acts sideways
            slope[4] += push[2];
        });
    }

    fn publish(&self, io: &mut Io) {
        let [x, y, heading, ..] = self.state;
        let velocity = self.model.velocity(&self.state).into();
        self.outputs.write(io, &Motion { position: Vector3::new(x, y, heading), velocity });
    }
}

/// The equations at the top of this file.
struct Model {
    mass: f64,
    inertia: f64,
    c: f64,
    d: f64,
}

impl Model {
    fn slope(&self, state: &[f64; 5], force: f64, torque: f64) -> [f64; 5] {
        let [vx, vy, turn] = self.velocity(state);
        let speed = state[3];
        [vx, vy, turn, (force - self.c * speed) / self.mass, (torque - self.d * turn) / self.inertia]
    }

    /// Velocities of x, y and θ.
    fn velocity(&self, &[_, _, heading, speed, turn]: &[f64; 5]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(heading);
        [speed * cos, speed * sin, turn]
    }
}

fn triple(values: &[f64]) -> [f64; 3] {
    [values[0], values[1], values[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cart_rolls_where_it_heads_and_drag_slows_it() {
        let model = Model { mass: 2.0, inertia: 0.5, c: 1.0, d: 0.25 };
        let [vx, vy, turn, speeding, turning] =
            model.slope(&[7.0, 8.0, std::f64::consts::FRAC_PI_2, 3.0, 4.0], 5.0, 2.0);
        assert!(vx.abs() < 1e-12);
        assert_eq!([vy, turn, speeding, turning], [3.0, 4.0, 1.0, 2.0]);
    }
}
