//! Metrics that concern several agents or obstacles: how close things come.

use formation::wiring::Assembly;
use lockstep::ChannelId;

use super::signal::Span;

/// What an assertion may name as its `metric`, or use within a signal; with its meaning. All in m.
pub const METRICS: [(&str, &str); 5] = [
    ("distance", "from the centre of the agent to that of the nearest other one"),
    ("gap", "the same, less the radii of both; below 0 they collide"),
    ("obstacle_gap", "from the edge of the agent to that of the nearest obstacle"),
    ("obstacle_margin", "from the centre of the agent to the inner boundary of the nearest obstacle"),
    ("tracking", "from the position of the agent to its place in the formation"),
];

/// How far an agent is from the nearest of some bodies.
#[derive(Clone, Debug)]
pub(super) struct Nearest {
    own: Span,
    bodies: Vec<(Body, f64)>,
}

/// Where a body is.
#[derive(Clone, Debug)]
enum Body {
    Agent(Span),
    Fixed([f64; 2]),
}

impl Nearest {
    /// The metric called `name` of the agent at this place; a reason if the scenario does not have what it needs, `None` if it
    /// is none of these.
    pub(super) fn named(name: &str, assembly: &Assembly, agent: usize) -> Option<Result<Self, String>> {
        match name {
            "distance" => Some(Self::agents(assembly, agent, |_| 0.0)),
            "gap" => Some(Self::agents(assembly, agent, |other| radius(assembly, agent) + radius(assembly, other))),
            "obstacle_gap" => Some(Self::obstacles(assembly, agent, false)),
            "obstacle_margin" => Some(Self::obstacles(assembly, agent, true)),
            _ => None,
        }
    }

    fn agents(assembly: &Assembly, agent: usize, keep_out: impl Fn(usize) -> f64) -> Result<Self, String> {
        let count = assembly.scenario.context.agents.len();
        let others = (0..count).filter(|other| *other != agent);
        let bodies: Vec<_> = others
            .map(|other| Ok((Body::Agent(position(assembly, other)?), keep_out(other))))
            .collect::<Result<_, String>>()?;
        if bodies.is_empty() {
            return Err("a distance between agents needs at least two agents".into());
        }
        Ok(Self { own: position(assembly, agent)?, bodies })
    }

    fn obstacles(assembly: &Assembly, agent: usize, inner: bool) -> Result<Self, String> {
        let obstacles = assembly.scenario.context.obstacles.as_ref().filter(|obstacles| !obstacles.centres.is_empty());
        let obstacles = obstacles.ok_or("a distance to obstacles needs a section `[obstacles]` with obstacles")?;
        let own_radius = radius(assembly, agent);
        let boundaries = obstacles.boundaries(own_radius);
        let bodies = boundaries.iter().zip(&obstacles.radii).map(|(boundary, r)| {
            let keep_out = if inner { boundary.inner } else { own_radius + r };
            (Body::Fixed(boundary.centre.into()), keep_out)
        });
        Ok(Self { own: position(assembly, agent)?.first(2), bodies: bodies.collect() })
    }

    /// The distance of this step, less what has to be kept free.
    pub(super) fn value<'s>(&self, sample: &impl Fn(ChannelId) -> &'s [f64]) -> f64 {
        let own = self.own.of(sample);
        let distance = |body: &Body| {
            let squares = |other: &[f64]| own.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            match body {
                Body::Agent(span) => squares(span.of(sample)),
                Body::Fixed(centre) => squares(centre),
            }
            .sqrt()
        };
        // Positions are finite, so no comparison is undecided.
        self.bodies.iter().map(|(body, keep_out)| distance(body) - keep_out).fold(f64::INFINITY, f64::min)
    }
}

/// Where an agent is, without its angles.
fn position(assembly: &Assembly, agent: usize) -> Result<Span, String> {
    let planar = assembly.scenario.context.agents[agent].vehicle.quadcopter().is_none();
    let span = Span::find(assembly, agent, "state", "position")?;
    Ok(span.first(if planar { 2 } else { 3 }))
}

/// Radius of an agent's body in m: that of a planar robot, or the arm of a quadcopter.
fn radius(assembly: &Assembly, agent: usize) -> f64 {
    let vehicle = &assembly.scenario.context.agents[agent].vehicle;
    let arm = || vehicle.quadcopter().map(|quadcopter| quadcopter.arm);
    vehicle.omni().map(|omni| omni.radius).or_else(arm).unwrap_or(0.0)
}
