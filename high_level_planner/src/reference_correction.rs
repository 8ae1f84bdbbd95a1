//! The planner that keeps references reachable: corrects what another source gives wherever an obstacle is in the way.

use formation::nalgebra::{Vector2, Vector3};
use formation::scenario::Context;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{Correction, Reference, SaturatedVirtualAgents, Trajectory, TrajectorySample, VirtualAgents, VirtualLayer};

/// Parameters of the planner. Obstacles and their boundaries are the scenario's `[obstacles]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceCorrection {
    /// Whether the correction is applied at all.
    pub use_rca: bool,
    /// What is corrected; by default the reference of the scenario.
    #[serde(default = "Source::reference")]
    pub source: Source,
}

/// Where the references come from that are corrected.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The reference of the scenario.
    Reference(Reference),
    /// Virtual agents that form up on it without bounds. The robots give way, their virtual agents do not.
    VirtualAgents(VirtualAgents),
    /// Virtual agents with bounded acceleration.
    SaturatedVirtualAgents(SaturatedVirtualAgents),
}

impl Source {
    fn reference() -> Self {
        Source::Reference(Reference {})
    }

    fn component(&self) -> &dyn Component {
        match self {
            Source::Reference(component) => component,
            Source::VirtualAgents(component) => component,
            Source::SaturatedVirtualAgents(component) => component,
        }
    }

    /// The virtual agents of all agents, if there are any.
    fn layer(&self, context: &Context) -> Option<VirtualLayer> {
        let gains = match self {
            Source::Reference(_) => return None,
            Source::VirtualAgents(component) => component.gains(),
            Source::SaturatedVirtualAgents(component) => component.gains(),
        };
        let start = context.agents.iter().map(|agent| Vector3::from_column_slice(&agent.position[..3]));
        Some(VirtualLayer::new(gains, context.topology.clone(), start.collect()))
    }
}

impl Component for ReferenceCorrection {
    fn check(&self, context: &Context) -> Checks {
        let mut checks = Checks::default();
        for (field, message) in self.source.component().check(context).findings {
            let place = if field.starts_with('/') { field } else { format!("source.{field}") };
            checks = checks.require(false, &place, message);
        }
        let planar = context.agents.iter().all(|agent| agent.nominal.omni().is_some());
        checks.require(planar, "/planner", "corrects the references of ground robots only").require(
            context.obstacles.is_some(),
            "/planner",
            "needs the section `[obstacles]`: p_obs, r_obs, eps1, eps2",
        )
    }

    /// What the agent has to track comes first, then whatever it was made from.
    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        self.published().fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let layer = self.source.layer(context);
        let seats = agents.iter().map(|&agent| Seat::new(self, context, agent, bind)).collect::<Result<Vec<_>, _>>()?;
        let given = seats.iter().map(|seat| seat.trajectory.at(0.0)).collect();
        Ok(Box::new(ReferenceCorrectionParticipant { layer, seats, given }))
    }
}

/// What a step results in for one agent.
struct Outcome {
    /// The corrected reference.
    tracked: TrajectorySample,
    /// The reference of the scenario.
    given: TrajectorySample,
    /// The agent of the virtual layer, where there is one: sliding variable, position, velocity.
    source: VirtualState,
    /// Number of the obstacle that is avoided, 0 for none.
    flag: f64,
}

#[derive(Default)]
struct VirtualState {
    sliding: Vector3<f64>,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
}

impl ReferenceCorrection {
    fn published(&self) -> Outputs<Outcome> {
        let outputs = Outputs::new()
            .vector("position", "", |outcome: &Outcome| outcome.tracked.position)
            .vector("velocity", "", |outcome| outcome.tracked.velocity)
            .vector("acceleration", "", |outcome| outcome.tracked.acceleration)
            .vector("desired_position", "", |outcome| outcome.given.position)
            .vector("desired_velocity", "", |outcome| outcome.given.velocity)
            .vector("desired_acceleration", "", |outcome| outcome.given.acceleration);
        let outputs = match self.source {
            Source::Reference(_) => outputs.vector("jerk", "", |outcome| outcome.tracked.jerk),
            _ => outputs
                .vector("sliding", "", |outcome| outcome.source.sliding)
                .vector("virtual_position", "", |outcome| outcome.source.position)
                .vector("virtual_velocity", "", |outcome| outcome.source.velocity),
        };
        outputs.scalar("flag", "", |outcome| outcome.flag)
    }
}

struct ReferenceCorrectionParticipant {
    layer: Option<VirtualLayer>,
    seats: Vec<Seat>,
    /// The reference of the scenario for every agent, at this step.
    given: Vec<TrajectorySample>,
}

/// What belongs to one agent.
struct Seat {
    trajectory: Trajectory,
    /// `None`: switched off.
    correction: Option<Correction>,
    measured: In<3>,
    outputs: BoundOutputs<Outcome>,
}

impl Seat {
    fn new(planner: &ReferenceCorrection, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let radius = context.agents[agent].nominal.omni().map_or(0.0, |omni| omni.radius);
        let boundaries = || context.obstacles.as_ref().map_or_else(Vec::new, |obstacles| obstacles.boundaries(radius));
        Ok(Self {
            trajectory: Trajectory::new(context, agent),
            correction: planner.use_rca.then(|| Correction::new(boundaries())),
            measured: bind.state(agent, "position")?,
            outputs: planner.published().bind(agent, bind)?,
        })
    }

    /// Corrects `reference` where that is necessary; the number of the obstacle that is avoided, 0 for none.
    fn correct(&self, reference: &mut TrajectorySample, io: &Io) -> f64 {
        let [x, y, _] = io.get(self.measured);
        let flag = match &self.correction {
            Some(correction) => correction.correct(&Vector2::new(x, y), reference),
            None => 0,
        };
        flag as f64
    }
}

impl Participant for ReferenceCorrectionParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for (given, seat) in self.given.iter_mut().zip(&self.seats) {
            *given = seat.trajectory.at(step.time());
        }
        if let Some(layer) = &mut self.layer {
            if !step.is_first() {
                layer.advance(step.dt);
            }
            layer.follow(step.index);
            layer.update(&self.given);
        }
        for (i, seat) in self.seats.iter().enumerate() {
            let given = self.given[i];
            let (mut tracked, source) = match &self.layer {
                Some(layer) => {
                    let (position, velocity) = (layer.position[i], layer.velocity[i]);
                    let jerk = Vector3::zeros(); // not published
                    let tracked = TrajectorySample { position, velocity, acceleration: layer.input[i], jerk };
                    (tracked, VirtualState { sliding: layer.sliding[i], position, velocity })
                }
                None => (given, VirtualState::default()),
            };
            let flag = seat.correct(&mut tracked, io);
            seat.outputs.write(io, &Outcome { tracked, given, source, flag });
        }
        Ok(())
    }
}
