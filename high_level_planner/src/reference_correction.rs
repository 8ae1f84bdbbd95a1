//! The planner that keeps references reachable: corrects what another source gives wherever an obstacle is in the way.

use formation::nalgebra::{Vector2, Vector3};
use formation::scenario::Context;
use formation::wiring::{Bind, Checks, Component, Refusal};
use lockstep::{Fault, Field, In, Io, Out, Participant, Step};
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
        checks
            .require(planar, "/planner", "corrects the references of ground robots only; this vehicle is none")
            .require(
                context.obstacles.is_some(),
                "/planner",
                "needs the section `[obstacles]`: p_obs, r_obs, eps1, eps2",
            )
    }

    /// What the agent has to track comes first, then whatever it was made from.
    fn outputs(&self, _: &Context, _: usize) -> Vec<Field> {
        let tracked = ["position", "velocity", "acceleration"];
        let given = ["desired_position", "desired_velocity", "desired_acceleration"];
        let source: &[&str] = match self.source {
            Source::Reference(_) => &["jerk"],
            _ => &["sliding", "virtual_position", "virtual_velocity"],
        };
        let names = tracked.iter().chain(&given).chain(source);
        names.map(|name| Field::vector(name, 3, "")).chain([Field::scalar("flag", "")]).collect()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let layer = self.source.layer(context);
        let seats = agents.iter().map(|&agent| Seat::new(self, context, agent, bind)).collect::<Result<Vec<_>, _>>()?;
        let given = seats.iter().map(|seat| seat.trajectory.at(0.0)).collect();
        Ok(Box::new(ReferenceCorrectionParticipant { layer, seats, given }))
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
    tracked: [Out<3>; 3],
    desired: [Out<3>; 3],
    source: SourcePorts,
    flag: Out<1>,
}

/// What is published about the source besides.
enum SourcePorts {
    Reference { jerk: Out<3> },
    Virtual { sliding: Out<3>, position: Out<3>, velocity: Out<3> },
}

impl Seat {
    fn new(planner: &ReferenceCorrection, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let radius = context.agents[agent].nominal.omni().map_or(0.0, |omni| omni.radius);
        let boundaries = || context.obstacles.as_ref().map_or_else(Vec::new, |obstacles| obstacles.boundaries(radius));
        let mut out = |name| bind.out(agent, name);
        Ok(Self {
            trajectory: Trajectory::new(context, agent),
            correction: planner.use_rca.then(|| Correction::new(boundaries())),
            tracked: [out("position")?, out("velocity")?, out("acceleration")?],
            desired: [out("desired_position")?, out("desired_velocity")?, out("desired_acceleration")?],
            source: match planner.source {
                Source::Reference(_) => SourcePorts::Reference { jerk: out("jerk")? },
                _ => SourcePorts::Virtual {
                    sliding: out("sliding")?,
                    position: out("virtual_position")?,
                    velocity: out("virtual_velocity")?,
                },
            },
            measured: bind.state(agent, "position")?,
            flag: bind.out(agent, "flag")?,
        })
    }

    /// Corrects `reference` where that is necessary and publishes it.
    fn publish(&self, mut reference: TrajectorySample, io: &mut Io) {
        let [x, y, _] = io.get(self.measured);
        let flag = match &self.correction {
            Some(correction) => correction.correct(&Vector2::new(x, y), &mut reference),
            None => 0,
        };
        put(io, self.tracked, [reference.position, reference.velocity, reference.acceleration]);
        if let SourcePorts::Reference { jerk } = self.source {
            io.set(jerk, reference.jerk.into());
        }
        io.set(self.flag, [flag as f64]);
    }
}

impl Participant for ReferenceCorrectionParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        for (given, seat) in self.given.iter_mut().zip(&self.seats) {
            *given = seat.trajectory.at(step.time());
            put(io, seat.desired, [given.position, given.velocity, given.acceleration]);
        }
        if let Some(layer) = &mut self.layer {
            if !step.is_first() {
                layer.advance(step.dt);
            }
            layer.update(&self.given);
        }
        for (i, seat) in self.seats.iter().enumerate() {
            let reference = match &self.layer {
                Some(layer) => TrajectorySample {
                    position: layer.position[i],
                    velocity: layer.velocity[i],
                    acceleration: layer.input[i],
                    jerk: Vector3::zeros(), // not published
                },
                None => self.given[i],
            };
            seat.publish(reference, io);
            if let (Some(layer), SourcePorts::Virtual { sliding, position, velocity }) = (&self.layer, &seat.source) {
                let values = [layer.sliding[i], layer.position[i], layer.velocity[i]];
                put(io, [*sliding, *position, *velocity], values);
            }
        }
        Ok(())
    }
}

fn put<const N: usize>(io: &mut Io, ports: [Out<3>; N], values: [Vector3<f64>; N]) {
    for (port, value) in ports.into_iter().zip(values) {
        io.set(port, value.into());
    }
}
