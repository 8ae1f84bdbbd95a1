//! Metrics that concern several agents or obstacles: how close things come.

use std::sync::Arc;

use formation::wiring::Assembly;
use lockstep::ChannelId;

use super::fold::{Fold, on_circle};
use super::span::Span;
use crate::judge::metrics::norm_between;

/// What an assertion may name as its `metric`, or use within a signal; with its meaning. Distances are in m.
pub const METRICS: [(&str, &str); 13] = [
    ("distance", "from the centre of the agent to that of the nearest other one"),
    ("gap", "the same, less the radii of both; below 0 they collide"),
    ("obstacle_gap", "from the edge of the agent to that of the nearest obstacle"),
    ("obstacle_margin", "from the centre of the agent to the inner boundary of the nearest obstacle"),
    ("tracking", "from the position of the agent to its place in the formation"),
    ("formation", "from the position relative to another agent to that of the references; the largest over the others"),
    ("edge_longest", "distance to the farthest of the in-neighbours"),
    ("edge_shortest", "distance to the nearest of the in-neighbours"),
    ("edge_error", "distance to an in-neighbour against that of the references; the largest over the in-neighbours"),
    (
        "bearing_error",
        "direction of an in-neighbour against that of the references, rad; the largest over the in-neighbours",
    ),
    ("link_age", "age of what the agent has received, s; the largest over its links"),
    ("link_loss", "share of the messages to the agent that were lost so far"),
    ("link_messages", "messages that were sent to the agent so far"),
];

/// Where an agent is, without the heading of a planar robot, and its size.
#[derive(Clone, Debug)]
pub(super) struct Body {
    own: Span,
    /// Radius, m.
    radius: f64,
    /// Which coordinates are angles.
    angles: Vec<bool>,
}

/// Where an agent is, without the heading of a planar robot, and its place in the formation.
#[derive(Clone, Debug)]
pub(super) struct Place {
    own: Span,
    reference: Span,
    /// Which coordinates are angles.
    angles: Vec<bool>,
}

/// What is asked of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Edge {
    Longest,
    Shortest,
    /// The length against that of the references.
    Error,
    /// The direction against that of the references, rad.
    Bearing,
}

impl Edge {
    fn of<'s>(self, here: &Place, there: &Place, sample: &impl Fn(ChannelId) -> &'s [f64]) -> f64 {
        let edge = |from: Span, to: Span| from.of(sample).iter().zip(to.of(sample)).map(|(from, to)| to - from);
        let length = |from: Span, to: Span| Fold::Norm.of(on_circle(edge(from, to), &here.angles));
        let own = length(here.own, there.own);
        match self {
            Edge::Longest | Edge::Shortest => own,
            Edge::Error => (own - length(here.reference, there.reference)).abs(),
            Edge::Bearing => {
                let product = edge(here.own, there.own).zip(edge(here.reference, there.reference));
                let product: f64 = product.map(|(a, b)| a * b).sum();
                let cosine = product / (own * length(here.reference, there.reference));
                // Two agents in one place have no direction.
                if cosine.is_nan() { std::f64::consts::PI } else { libm::acos(cosine.clamp(-1.0, 1.0)) }
            }
        }
    }
}

/// Where all agents are and how large they are; known once for all assertions.
pub(in crate::judge) struct Geometry {
    /// All agents as bodies; or why that is not known.
    agents: Result<Arc<[Body]>, String>,
    /// The shape of the formation as it is and as it should be; or why that is not known.
    places: Result<Arc<[Place]>, String>,
}

impl Geometry {
    pub(in crate::judge) fn new(assembly: &Assembly) -> Self {
        let count = assembly.scenario.context.agents.len();
        let agent = |agent: usize| {
            let angles = assembly.scenario.context.agents[agent].angles.clone();
            Ok(Body { own: position(assembly, agent)?, radius: radius(assembly, agent), angles })
        };
        let place = |agent| {
            let (own, place) = (position(assembly, agent)?, place(assembly, agent)?);
            let length = own.length.min(place.length);
            let angles = assembly.scenario.context.agents[agent].angles.clone();
            Ok(Place { own: own.first(length), reference: place.first(length), angles })
        };
        Self { agents: (0..count).map(agent).collect(), places: (0..count).map(place).collect() }
    }
}

/// The place of an agent in the formation, which the planner publishes.
pub(super) fn place(assembly: &Assembly, agent: usize) -> Result<Span, String> {
    let find = |field| Span::find(assembly, agent, "reference", field);
    find("desired_position").or_else(|_| find("position"))
}

/// How far an agent is from the nearest of some bodies.
#[derive(Clone, Debug)]
pub(super) enum Nearest {
    /// From other agents, at this place in the list; less the radii of both, or not.
    Agent(usize, Arc<[Body]>, bool),
    /// From the shape of the formation: the agent at this place in the list, and all of them.
    Shape(usize, Arc<[Place]>),
    /// Along the edges of the graph: the agent at this place in the list, its in-neighbours at any time, and all of them.
    Edges(Edge, usize, Vec<usize>, Arc<[Place]>),
    /// From obstacles: own position, and of each the centre and the distance that is to be kept.
    Obstacle(Span, Vec<([f64; 2], f64)>),
}

impl Nearest {
    /// The metric called `name` of the agent at this place; a reason if the scenario does not have what it needs, `None` if it
    /// is none of these.
    pub(super) fn named(
        name: &str,
        assembly: &Assembly,
        geometry: &Geometry,
        agent: usize,
    ) -> Option<Result<Self, String>> {
        let agents = |with_radii| match &geometry.agents {
            Ok(agents) => Ok(Self::Agent(agent, agents.clone(), with_radii)),
            Err(why) => Err(why.clone()),
        };
        match name {
            "formation" => Some(match &geometry.places {
                Ok(places) => Ok(Self::Shape(agent, places.clone())),
                Err(why) => Err(why.clone()),
            }),
            "edge_longest" => Some(Self::edges(Edge::Longest, assembly, geometry, agent)),
            "edge_shortest" => Some(Self::edges(Edge::Shortest, assembly, geometry, agent)),
            "edge_error" => Some(Self::edges(Edge::Error, assembly, geometry, agent)),
            "bearing_error" => Some(Self::edges(Edge::Bearing, assembly, geometry, agent)),
            "distance" => Some(agents(false)),
            "gap" => Some(agents(true)),
            "obstacle_gap" => Some(Self::obstacles(assembly, agent, false)),
            "obstacle_margin" => Some(Self::obstacles(assembly, agent, true)),
            _ => None,
        }
    }

    /// Whether it is a distance to other agents where there are none.
    pub(super) fn is_alone(&self) -> bool {
        match self {
            Nearest::Agent(_, agents, _) => agents.len() < 2,
            Nearest::Shape(_, places) => places.len() < 2,
            Nearest::Edges(..) | Nearest::Obstacle(..) => false,
        }
    }

    fn edges(what: Edge, assembly: &Assembly, geometry: &Geometry, agent: usize) -> Result<Self, String> {
        let places = match what {
            // The lengths need no references.
            Edge::Longest | Edge::Shortest => {
                let bodies = geometry.agents.as_ref().map_err(Clone::clone)?;
                let place = |body: &Body| Place { own: body.own, reference: body.own, angles: body.angles.clone() };
                bodies.iter().map(place).collect()
            }
            Edge::Error | Edge::Bearing => Arc::clone(geometry.places.as_ref().map_err(Clone::clone)?),
        };
        let neighbours = assembly.scenario.context.topology.neighbourhood(agent).heard().to_vec();
        Ok(Self::Edges(what, agent, neighbours, places))
    }

    fn obstacles(assembly: &Assembly, agent: usize, inner: bool) -> Result<Self, String> {
        let obstacles = assembly.scenario.context.obstacles.as_ref().filter(|obstacles| !obstacles.centres.is_empty());
        let obstacles = obstacles.ok_or("a distance to obstacles needs a section `[obstacles]` with obstacles")?;
        let own_radius = radius(assembly, agent);
        let boundaries = obstacles.boundaries(own_radius);
        let discs = boundaries.iter().zip(&obstacles.radii).map(|(boundary, r)| {
            let keep_out = if inner { boundary.inner } else { own_radius + r };
            (boundary.centre.into(), keep_out)
        });
        Ok(Self::Obstacle(position(assembly, agent)?.first(2), discs.collect()))
    }

    /// The distance of this step, less what has to be kept free.
    pub(super) fn value<'s>(&self, sample: &impl Fn(ChannelId) -> &'s [f64]) -> f64 {
        // Positions are finite, so no comparison is undecided.
        let least = f64::min;
        match self {
            Nearest::Agent(agent, agents, with_radii) => {
                let (here, own) = (&agents[*agent], agents[*agent].own.of(sample));
                let others = agents.iter().enumerate().filter(|(index, _)| index != agent);
                let keep_out = |radius: f64| if *with_radii { here.radius + radius } else { 0.0 };
                let free = others.map(|(_, other)| {
                    let differences = own.iter().zip(other.own.of(sample)).map(|(a, b)| a - b);
                    Fold::Norm.of(on_circle(differences, &here.angles)) - keep_out(other.radius)
                });
                free.fold(f64::INFINITY, least)
            }
            Nearest::Shape(agent, places) => {
                let deviation = |place: &Place| {
                    let (own, reference) = (place.own.of(sample), place.reference.of(sample));
                    own.iter().zip(reference).map(|(own, reference)| own - reference)
                };
                let apart = |other: usize| {
                    let (here, there) = (&places[*agent], &places[other]);
                    let differences = deviation(here).zip(deviation(there)).map(|(here, there)| here - there);
                    Fold::Norm.of(on_circle(differences, &here.angles))
                };
                (0..places.len()).filter(|other| other != agent).map(apart).fold(0.0, f64::max)
            }
            Nearest::Edges(what, agent, neighbours, places) => {
                let here = &places[*agent];
                let each = neighbours.iter().map(|&other| what.of(here, &places[other], sample));
                match what {
                    Edge::Shortest => each.fold(f64::INFINITY, least),
                    _ => each.fold(0.0, f64::max),
                }
            }
            Nearest::Obstacle(own, discs) => {
                let own = own.of(sample);
                discs.iter().map(|(centre, keep_out)| norm_between(own, centre) - keep_out).fold(f64::INFINITY, least)
            }
        }
    }
}

/// Where an agent is, without its angles.
fn position(assembly: &Assembly, agent: usize) -> Result<Span, String> {
    let span = Span::find(assembly, agent, "state", "position")?;
    Ok(span.first(assembly.scenario.context.agents[agent].vehicle.dimensions()))
}

/// Radius of an agent's body in m; 0 if it has none.
fn radius(assembly: &Assembly, agent: usize) -> f64 {
    assembly.scenario.context.agents[agent].vehicle.radius().unwrap_or(0.0)
}
