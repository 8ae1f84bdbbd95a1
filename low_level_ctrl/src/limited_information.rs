//! The formation controller of section 4.4.2: sliding mode on estimates, repulsion between robots, a graph that grows when
//! they come close. (4.28), (4.31)

use formation::math::PotentialField;
use formation::nalgebra::{Vector2, Vector3};
use formation::scenario::{AdjacencyRow, Context};
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

/// Gains of the controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitedInformation {
    /// c, gain of the sliding variable, 1/s.
    pub c: f64,
    /// λ, slope of the sliding surface, 1/s.
    pub lam: f64,
    /// Whether robots repel each other.
    pub apf: bool,
    /// α, strength of the potentials.
    pub apf_alpha: f64,
    /// ε1: a potential becomes infinite where the distance is ε1 times the sum of the radii.
    pub eps1: f64,
    /// ε2: it ends where the distance is ε2 times that sum.
    pub eps2: f64,
}

/// What is known of a robot: all that neighbours tell each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// x, m and rad.
    pub position: Vector3<f64>,
    /// x_d.
    pub reference: Vector3<f64>,
    /// v̂, m/s and rad/s.
    pub velocity: Vector3<f64>,
    /// γ2, the rebuilt velocity of the reference.
    pub reference_velocity: Vector3<f64>,
}

impl Motion {
    /// δx.
    fn position_error(&self) -> Vector3<f64> {
        self.position - self.reference
    }

    /// δ̂v. (4.28)
    fn velocity_error(&self) -> Vector3<f64> {
        self.velocity - self.reference_velocity
    }
}

/// The controller of one robot.
#[derive(Clone, Debug)]
pub struct LimitedInformationController {
    gains: LimitedInformation,
    vehicle: Omni,
    /// b_i.
    reference_weight: f64,
    /// The potentials around the robots that are heard, in that order; none if they are off.
    fields: Vec<PotentialField>,
    /// a_i1 ... a_iN of this instant.
    pub row: AdjacencyRow,
    /// (F1, F2, F3), N.
    pub input: Vector3<f64>,
    /// ŝ.
    pub sliding: Vector3<f64>,
    /// e_x.
    pub error: Vector3<f64>,
    /// ê_v.
    pub velocity_error: Vector3<f64>,
    /// f, the sum of the repulsive forces, m/s².
    pub force: Vector2<f64>,
}

impl LimitedInformationController {
    /// A controller for `vehicle` with the graph row `row`; `radii` are the sums of its radius and those of the robots that are
    /// heard, in their order, m.
    pub fn new(
        gains: LimitedInformation,
        vehicle: Omni,
        reference_weight: f64,
        row: AdjacencyRow,
        radii: impl IntoIterator<Item = f64>,
    ) -> Self {
        let field = |radii| PotentialField::of_discs(gains.apf_alpha, radii, gains.eps1, gains.eps2);
        let fields = if gains.apf { radii.into_iter().map(field).collect() } else { Vec::new() };
        let zero = Vector3::zeros();
        Self {
            gains,
            vehicle,
            reference_weight,
            fields,
            row,
            input: zero,
            sliding: zero,
            error: zero,
            velocity_error: zero,
            force: Vector2::zeros(),
        }
    }

    /// Computes the wheel forces. `others` yields the robots that are heard, in the order of [`AdjacencyRow::heard`].
    pub fn update(
        &mut self,
        own: &Motion,
        others: impl IntoIterator<Item = Motion>,
        disturbance: &Vector3<f64>,
        reference_acceleration: &Vector3<f64>,
    ) {
        let LimitedInformation { c, lam, .. } = self.gains;
        let (position_error, velocity_error) = (own.position_error(), own.velocity_error());
        self.meet(own, others);
        self.error += self.reference_weight * position_error;
        self.velocity_error += self.reference_weight * velocity_error; // (4.28)
        self.sliding = self.velocity_error + lam * self.error; // (4.28)
        let push = -c * self.sliding - disturbance - lam * velocity_error - position_error
            + reference_acceleration
            + Vector3::new(self.force.x, self.force.y, 0.0);
        self.input = self.vehicle.inverse(own.position.z) * push; // (4.31)
    }

    /// Sets the graph row, the parts of the local errors that are relative to others, and the repulsive force.
    fn meet(&mut self, own: &Motion, others: impl IntoIterator<Item = Motion>) {
        let (position_error, velocity_error) = (own.position_error(), own.velocity_error());
        self.error = Vector3::zeros();
        self.velocity_error = Vector3::zeros();
        self.force = Vector2::zeros();
        for (place, other) in others.into_iter().enumerate() {
            let index = self.row.heard()[place];
            let offset: Vector2<f64> = (own.position - other.position).xy();
            let weight = self.row.update(index, offset.norm()); // (4.5)
            if weight > 0.0 {
                self.error += weight * (position_error - other.position_error());
                self.velocity_error += weight * (velocity_error - other.velocity_error());
                if let Some(field) = self.fields.get(place) {
                    self.force += field.force(&offset); // (4.9)
                }
            }
        }
    }
}

impl Component for LimitedInformation {
    fn check(&self, context: &Context) -> Checks {
        Checks::default()
            .positive("c", self.c)
            .positive("lam", self.lam)
            .not_negative("apf_alpha", self.apf_alpha)
            .positive("eps1", self.eps1)
            .require(
                self.eps2.is_finite() && self.eps2 > self.eps1,
                "eps2",
                format!("expected a number > eps1 = {}, found {}", self.eps1, self.eps2),
            )
            .strongly_connected(context)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let vehicle = planar(context, agent)?;
        let row = AdjacencyRow::new(&context.topology, context.proximity.clone(), agent);
        let mut others = Vec::new();
        let mut radii = Vec::new();
        for &other in row.heard() {
            others.push(MotionPorts::new(other, bind)?);
            radii.push(planar(context, agent)?.radius + planar(context, other)?.radius);
        }
        let weight = row.reference();
        Ok(Box::new(LimitedInformationParticipant {
            controller: LimitedInformationController::new(self.clone(), vehicle.clone(), weight, row, radii),
            own: MotionPorts::new(agent, bind)?,
            others,
            disturbance: bind.estimate(agent, "disturbance")?,
            reference_acceleration: bind.estimate(agent, "reference_acceleration")?,
            outputs: published(context, agent).bind(agent, bind)?,
        }))
    }
}

fn published(context: &Context, agent: usize) -> Outputs<LimitedInformationController> {
    let input = context.agents[agent].vehicle.input_field();
    Outputs::new()
        .field(input, |controller: &LimitedInformationController| controller.input)
        .vector("sliding", "m/s, m/s, rad/s", |controller| controller.sliding)
        .vector("error", "m, m, rad", |controller| controller.error)
        .vector("velocity_error", "m/s, m/s, rad/s", |controller| controller.velocity_error)
        .vector("force", "m/s^2", |controller| controller.force)
        .slice("adjacency", context.agents.len(), "", |controller, place| {
            place.copy_from_slice(&controller.row.weights);
        })
}

fn planar(context: &Context, agent: usize) -> Result<&Omni, Refusal> {
    let vehicle = &context.agents[agent].nominal;
    vehicle.omni().filter(|omni| omni.order() == 2).ok_or_else(|| {
        Refusal(
            "the controller `limited_information` drives planar robots whose inputs set accelerations (order 2)".into(),
        )
    })
}

/// The signals that make up a [`Motion`].
struct MotionPorts {
    position: In<3>,
    reference: In<3>,
    velocity: In<3>,
    reference_velocity: In<3>,
}

impl MotionPorts {
    fn new(agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        Ok(Self {
            position: bind.state(agent, "position")?,
            reference: bind.reference(agent, "position")?,
            velocity: bind.estimate(agent, "velocity")?,
            reference_velocity: bind.estimate(agent, "reference_velocity")?,
        })
    }

    fn read(&self, io: &Io) -> Motion {
        Motion {
            position: io.get(self.position).into(),
            reference: io.get(self.reference).into(),
            velocity: io.get(self.velocity).into(),
            reference_velocity: io.get(self.reference_velocity).into(),
        }
    }
}

struct LimitedInformationParticipant {
    controller: LimitedInformationController,
    own: MotionPorts,
    others: Vec<MotionPorts>,
    disturbance: In<3>,
    reference_acceleration: In<3>,
    outputs: BoundOutputs<LimitedInformationController>,
}

impl Participant for LimitedInformationParticipant {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let controller = &mut self.controller;
        controller.row.follow(io.step());
        controller.reference_weight = controller.row.reference();
        controller.update(
            &self.own.read(io),
            self.others.iter().map(|ports| ports.read(io)),
            &io.get(self.disturbance).into(),
            &io.get(self.reference_acceleration).into(),
        );
        self.outputs.write(io, controller);
        Ok(())
    }
}

#[cfg(test)]
#[path = "limited_information/tests.rs"]
mod tests;
