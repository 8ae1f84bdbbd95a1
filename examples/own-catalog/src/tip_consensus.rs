//! A control law: the tips of carts reach a formation.
//!
//! A cart cannot move sideways, but the tip of a rod of length `l` ahead of its axle can go anywhere. With the tip
//! `h = p + l n`, `n = (cos θ, sin θ)`, and its deviation `δ_i = h_i - r_i` from its place in the formation, the local error is
//!
//! ```text
//! e_i = Σ_j a_ij (δ_i - δ_j) + b_i δ_i
//! ```
//!
//! and the tip is to have the acceleration `a_i = d²r_i/dt² - k_x e_i - k_v de_i/dt`. That of the tip of a cart without drag is
//! `(F/m - l ω²) n + (l τ/I + v ω) n⊥`, hence the inputs
//!
//! ```text
//! F = m (n·a + l ω²)          τ = I (n⊥·a - v ω) / l
//! ```
//!
//! The law does not know the drag, which therefore leaves an error.

use formation::math::NeighbourhoodSchedule;
use formation::nalgebra::{Vector2, Vector4};
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

/// `[controller]` of a scenario.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TipConsensus {
    /// Gain of the local error, 1/s².
    pub k_x: f64,
    /// Gain of its rate, 1/s.
    pub k_v: f64,
    /// From the axle to the tip, m.
    pub l: f64,
}

impl TipConsensus {
    /// The acceleration that the tip is to have.
    fn demand(&self, feedforward: Vector2<f64>, error: Vector2<f64>, rate: Vector2<f64>) -> Vector2<f64> {
        feedforward - self.k_x * error - self.k_v * rate
    }

    /// Force and torque that give it to the tip of a cart of this mass and moment of inertia.
    fn inputs(&self, demand: Vector2<f64>, cart: &Pose, mass: f64, inertia: f64) -> [f64; 2] {
        let along = cart.ahead.dot(&demand) + self.l * cart.turn * cart.turn;
        let across = cart.left.dot(&demand) - cart.speed * cart.turn;
        [mass * along, inertia * across / self.l]
    }
}

impl Component for TipConsensus {
    fn check(&self, context: &Context) -> Checks {
        let checks = Checks::default().positive("k_x", self.k_x).positive("k_v", self.k_v).positive("l", self.l);
        checks.strongly_connected(context)
    }

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        published().fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let body = context.agents[agent].nominal.omni().ok_or_else(|| {
            Refusal(
                "the controller `tip_consensus` drives carts, which in `[vehicle]` are `kind = \"integrator\"`".into(),
            )
        })?;
        let graph = context.topology.neighbourhood(agent);
        let others = graph.heard().iter().map(|&other| Sight::new(other, bind)).collect::<Result<_, _>>()?;
        Ok(Box::new(TipController {
            law: self.clone(),
            mass: body.mass,
            inertia: body.inertia,
            graph,
            own: Sight::new(agent, bind)?,
            others,
            feedforward: bind.reference(agent, "acceleration")?,
            outputs: published().bind(agent, bind)?,
        }))
    }
}

/// What a step results in.
struct Outcome {
    input: Vector2<f64>,
    /// δ.
    deviation: Vector2<f64>,
}

/// The outputs: name, unit and value of each.
fn published() -> Outputs<Outcome> {
    Outputs::new()
        .vector("input", "N, N m", |outcome: &Outcome| outcome.input)
        .vector("deviation", "m", |outcome| outcome.deviation)
}

/// The participant: the controller of one cart.
struct TipController {
    law: TipConsensus,
    mass: f64,
    inertia: f64,
    graph: NeighbourhoodSchedule,
    own: Sight,
    others: Vec<Sight>,
    feedforward: In<3>,
    outputs: BoundOutputs<Outcome>,
}

impl Participant for TipController {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let own = self.own.deviation(self.law.l, io);
        let error = self.graph.local_error(io.step(), &own, |place| self.others[place].deviation(self.law.l, io));
        let [x, y, _] = io.get(self.feedforward);
        let demand = self.law.demand(Vector2::new(x, y), error.xy(), Vector2::new(error.z, error.w));
        let input = self.law.inputs(demand, &self.own.pose(io), self.mass, self.inertia);
        self.outputs.write(io, &Outcome { input: input.into(), deviation: own.xy() });
        Ok(())
    }
}

/// What the law reads of one agent: where it is, and where its tip belongs.
struct Sight {
    position: In<3>,
    velocity: In<3>,
    place: In<3>,
    place_velocity: In<3>,
}

/// How a cart stands and moves.
struct Pose {
    axle: Vector2<f64>,
    /// n.
    ahead: Vector2<f64>,
    /// n⊥.
    left: Vector2<f64>,
    speed: f64,
    turn: f64,
}

impl Sight {
    fn new(agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        Ok(Self {
            position: bind.state(agent, "position")?,
            velocity: bind.state(agent, "velocity")?,
            place: bind.reference(agent, "position")?,
            place_velocity: bind.reference(agent, "velocity")?,
        })
    }

    fn pose(&self, io: &Io) -> Pose {
        let [x, y, heading] = io.get(self.position);
        let [vx, vy, turn] = io.get(self.velocity);
        let (sin, cos) = libm::sincos(heading);
        Pose {
            axle: Vector2::new(x, y),
            ahead: Vector2::new(cos, sin),
            left: Vector2::new(-sin, cos),
            speed: vx * cos + vy * sin,
            turn,
        }
    }

    /// δ and its rate, one above the other.
    fn deviation(&self, length: f64, io: &Io) -> Vector4<f64> {
        let cart = self.pose(io);
        let ([x, y, _], [vx, vy, _]) = (io.get(self.place), io.get(self.place_velocity));
        let tip = cart.axle + length * cart.ahead;
        let tip_velocity = cart.speed * cart.ahead + length * cart.turn * cart.left;
        Vector4::new(tip.x - x, tip.y - y, tip_velocity.x - vx, tip_velocity.y - vy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: TipConsensus = TipConsensus { k_x: 2.0, k_v: 3.0, l: 0.5 };

    #[test]
    fn errors_are_opposed() {
        let (x, y, zero) = (Vector2::x(), Vector2::y(), Vector2::zeros());
        assert_eq!(LAW.demand(zero, x, y), Vector2::new(-2.0, -3.0));
        assert_eq!(LAW.demand(x, zero, zero), x);
    }

    #[test]
    fn a_force_pushes_ahead_and_a_torque_moves_the_tip_to_the_side() {
        let rest = Pose { axle: Vector2::zeros(), ahead: Vector2::x(), left: Vector2::y(), speed: 0.0, turn: 0.0 };
        assert_eq!(LAW.inputs(Vector2::x(), &rest, 4.0, 0.25), [4.0, 0.0]);
        assert_eq!(LAW.inputs(Vector2::y(), &rest, 4.0, 0.25), [0.0, 0.5]);
    }
}
