//! Virtual agents: double integrators that do all the talking and form up on the reference, one per agent. (7.10), (7.53)

use formation::math::{Projection, TopologySchedule, clip_vector};
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{Trajectory, TrajectorySample};

/// Virtual agents whose acceleration is bounded. (7.13) to (7.18)
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct SaturatedVirtualAgents {
    /// Bound of the virtual acceleration, m/s².
    pub UM: f64,
    /// End of the linear range of the projection of the local error, m.
    pub tau_e: f64,
    /// Softness of that projection, m.
    pub psi_e: f64,
    /// Gain of the sliding variable, 1/s.
    pub c_bar: f64,
    /// Slope of the sliding surface, 1/s.
    pub lam_bar: f64,
    /// Gain of the position error, 1/s².
    pub k_bar: f64,
    /// End of the linear range of the projection of the virtual input, m/s².
    pub tau_u: f64,
    /// Softness of that projection, m/s².
    pub psi_u: f64,
}

/// Virtual agents without bounds. (7.55) to (7.58)
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VirtualAgents {
    /// Gain of the sliding variable, 1/s.
    pub c_bar: f64,
    /// Slope of the sliding surface, 1/s.
    pub lam_bar: f64,
    /// Weight of the reference acceleration: 1, or 0 to leave it out.
    pub feedforward: f64,
}

/// Gains of a layer of virtual agents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualLayerGains {
    /// c̄, 1/s.
    pub c: f64,
    /// λ̄, 1/s.
    pub lambda: f64,
    /// k̄, 1/s².
    pub k: f64,
    /// Weight of the reference acceleration.
    pub feedforward: f64,
    /// P(ē; τ̄e, ψ̄e), if the local error is projected.
    pub error: Option<Projection>,
    /// P(ū; τ̄u, ψ̄u) and the hard limit ŪM behind it, if the input is bounded.
    pub input: Option<(Projection, f64)>,
}

/// The states of all virtual agents.
#[derive(Clone, Debug)]
pub struct VirtualLayer {
    gains: VirtualLayerGains,
    topology: TopologySchedule,
    /// The step, which says which graph holds.
    step: u64,
    /// x̄, m and rad.
    pub position: Vec<Vector3<f64>>,
    /// v̄.
    pub velocity: Vec<Vector3<f64>>,
    /// ū, as applied.
    pub input: Vec<Vector3<f64>>,
    /// s̄, the sliding variables.
    pub sliding: Vec<Vector3<f64>>,
    position_error: Vec<Vector3<f64>>,
    velocity_error: Vec<Vector3<f64>>,
}

impl VirtualLayer {
    /// Virtual agents at rest at `start`.
    pub fn new(gains: VirtualLayerGains, topology: TopologySchedule, start: Vec<Vector3<f64>>) -> Self {
        let zeros = vec![Vector3::zeros(); start.len()];
        Self {
            gains,
            topology,
            step: 0,
            position: start,
            velocity: zeros.clone(),
            input: zeros.clone(),
            sliding: zeros.clone(),
            position_error: zeros.clone(),
            velocity_error: zeros,
        }
    }

    /// Moves every agent over `dt` seconds under the input it has; exact for a held input. (7.10), (7.53)
    pub fn advance(&mut self, dt: f64) {
        for i in 0..self.position.len() {
            self.position[i] += dt * self.velocity[i] + 0.5 * dt * dt * self.input[i];
            self.velocity[i] += dt * self.input[i];
        }
    }

    /// Takes the graph of this step.
    pub fn follow(&mut self, step: u64) {
        self.step = step;
    }

    /// Computes every agent's input at the references of this instant.
    pub fn update(&mut self, references: &[TrajectorySample]) {
        for (i, reference) in references.iter().enumerate() {
            self.position_error[i] = self.position[i] - reference.position; // (7.13), (7.55)
            self.velocity_error[i] = self.velocity[i] - reference.velocity;
        }
        for (i, reference) in references.iter().enumerate() {
            let gains = &self.gains;
            let error = self.local_error(i, &self.position_error); // (7.14), (7.56)
            let error_rate = self.local_error(i, &self.velocity_error);
            let (projected, slope) = match &gains.error {
                Some(projection) => (projection.vector(&error), projection.slopes(&error)), // (7.16)
                None => (error, Vector3::repeat(1.0)),
            };
            self.sliding[i] = error_rate + gains.lambda * projected; // (7.15), (7.57)
            let nominal = gains.feedforward * reference.acceleration
                - gains.c * self.sliding[i]
                - gains.lambda * slope.component_mul(&self.velocity_error[i])
                - gains.k * self.position_error[i]; // (7.17), (7.58)
            self.input[i] = match &gains.input {
                Some((projection, limit)) => clip_vector(&projection.vector(&nominal), *limit), // (7.18), (7.11)
                None => nominal,
            };
        }
    }

    fn local_error(&self, i: usize, errors: &[Vector3<f64>]) -> Vector3<f64> {
        let graph = self.topology.at(self.step);
        let others = graph.neighbours(i).iter().map(|&j| errors[j]);
        graph.local_error(i, &errors[i], others)
    }
}

impl SaturatedVirtualAgents {
    pub(crate) fn gains(&self) -> VirtualLayerGains {
        VirtualLayerGains {
            c: self.c_bar,
            lambda: self.lam_bar,
            k: self.k_bar,
            feedforward: 1.0,
            error: Some(Projection::new(self.tau_e, self.psi_e)),
            input: Some((Projection::new(self.tau_u, self.psi_u), self.UM)),
        }
    }
}

impl VirtualAgents {
    pub(crate) fn gains(&self) -> VirtualLayerGains {
        VirtualLayerGains {
            c: self.c_bar,
            lambda: self.lam_bar,
            k: 1.0,
            feedforward: self.feedforward,
            error: None,
            input: None,
        }
    }
}

impl Component for SaturatedVirtualAgents {
    fn check(&self, context: &Context) -> Checks {
        let bound = format!("tau_u + psi_u = {} exceeds the bound UM = {}", self.tau_u + self.psi_u, self.UM);
        Checks::default()
            .positive("UM", self.UM)
            .positive("tau_e", self.tau_e)
            .not_negative("psi_e", self.psi_e)
            .positive("c_bar", self.c_bar)
            .positive("lam_bar", self.lam_bar)
            .positive("k_bar", self.k_bar)
            .positive("tau_u", self.tau_u)
            .not_negative("psi_u", self.psi_u)
            .require(self.tau_u + self.psi_u <= self.UM * (1.0 + 1e-12), "tau_u", bound)
            .strongly_connected(context)
    }

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        published().fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        Ok(Box::new(VirtualAgentsParticipant::new(self.gains(), context, agents, bind)?))
    }
}

impl Component for VirtualAgents {
    fn check(&self, context: &Context) -> Checks {
        Checks::default()
            .positive("c_bar", self.c_bar)
            .positive("lam_bar", self.lam_bar)
            .finite("feedforward", self.feedforward)
            .strongly_connected(context)
    }

    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        published().fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        Ok(Box::new(VirtualAgentsParticipant::new(self.gains(), context, agents, bind)?))
    }
}

/// A virtual agent, which is what the agent tracks, and where it should be itself.
struct VirtualAgent {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    sliding: Vector3<f64>,
    desired: TrajectorySample,
}

fn published() -> Outputs<VirtualAgent> {
    Outputs::new()
        .vector("position", "", |agent: &VirtualAgent| agent.position)
        .vector("velocity", "", |agent| agent.velocity)
        .vector("acceleration", "", |agent| agent.acceleration)
        .vector("sliding", "", |agent| agent.sliding)
        .vector("desired_position", "", |agent| agent.desired.position)
        .vector("desired_velocity", "", |agent| agent.desired.velocity)
}

struct VirtualAgentsParticipant {
    layer: VirtualLayer,
    trajectories: Vec<Trajectory>,
    references: Vec<TrajectorySample>,
    outputs: Vec<BoundOutputs<VirtualAgent>>,
}

impl VirtualAgentsParticipant {
    fn new(gains: VirtualLayerGains, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Self, Refusal> {
        let start = agents.iter().map(|&agent| Vector3::from_column_slice(&context.agents[agent].position[..3]));
        let trajectories: Vec<Trajectory> = agents.iter().map(|&agent| Trajectory::new(context, agent)).collect();
        let outputs = agents.iter().map(|&agent| published().bind(agent, bind));
        Ok(Self {
            layer: VirtualLayer::new(gains, context.topology.clone(), start.collect()),
            references: trajectories.iter().map(|trajectory| trajectory.at(0.0)).collect(),
            trajectories,
            outputs: outputs.collect::<Result<_, Refusal>>()?,
        })
    }
}

impl Participant for VirtualAgentsParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        if !step.is_first() {
            self.layer.advance(step.dt);
        }
        for (reference, trajectory) in self.references.iter_mut().zip(&self.trajectories) {
            *reference = trajectory.at(step.time());
        }
        self.layer.follow(step.index);
        self.layer.update(&self.references);
        for (i, outputs) in self.outputs.iter().enumerate() {
            let agent = VirtualAgent {
                position: self.layer.position[i],
                velocity: self.layer.velocity[i],
                acceleration: self.layer.input[i],
                sliding: self.layer.sliding[i],
                desired: self.references[i],
            };
            outputs.write(io, &agent);
        }
        Ok(())
    }
}
