//! Distances: between agents, and to what stands in their way.

use formation::config::Node;

use super::panel::{Curve, Kind, Limit, Panel, View};
use super::{Grid, LoggedRun};
use recording::Series;

/// A round obstacle at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Centre, m.
    pub centre: [f64; 2],
    /// Radius, m.
    pub radius: f64,
    /// Radii of its potential field in sums of the radii of agent and obstacle: the inner boundary, which must not be
    /// reached, and the outer one, where attention begins.
    pub rings: Option<[f64; 2]>,
}

impl Obstacle {
    /// Inner and outer boundary for an agent of this radius, m.
    pub fn boundaries(&self, agent_radius: f64) -> Option<[f64; 2]> {
        self.rings.map(|rings| rings.map(|ring| ring * (agent_radius + self.radius)))
    }
}

impl LoggedRun {
    /// The obstacles of the scenario, from its section `[obstacles]`.
    pub fn obstacles(&self) -> Vec<Obstacle> {
        let section = |path: &str| self.scenario.as_ref().and_then(|scenario| scenario.section(path));
        let list = |path| section(path).and_then(Node::as_array).unwrap_or_default();
        let rings = match (section("obstacles.eps1"), section("obstacles.eps2")) {
            (Some(inner), Some(outer)) => inner.as_f64().zip(outer.as_f64()).map(|(inner, outer)| [inner, outer]),
            _ => None,
        };
        let centres = list("obstacles.p_obs").iter().filter_map(|node| match node.as_array()? {
            [x, y, ..] => Some([x.as_f64()?, y.as_f64()?]),
            _ => None,
        });
        let radii = list("obstacles.r_obs").iter().filter_map(Node::as_f64);
        centres.zip(radii).map(|(centre, radius)| Obstacle { centre, radius, rings }).collect()
    }

    /// Where an agent is and, for a vehicle in the plane whose position does not have it, its heading: one signal after the other.
    pub fn pose(&self, place: usize) -> Option<Vec<Series<'_>>> {
        let position = self.signal(place, "state", "position")?;
        let heading = self.vehicle(place).and_then(|vehicle| self.signal(place, "state", vehicle.heading()?));
        Some(std::iter::once(position).chain(heading).collect())
    }

    /// Positions of all agents; `None` if one has none.
    fn positions(&self) -> Option<Vec<Series<'_>>> {
        (0..self.agents.len()).map(|place| self.signal(place, "state", "position")).collect()
    }
}

fn distance(space: usize, a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).take(space).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Smallest of some values; NaN if there are none.
fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NAN, f64::min)
}

pub(super) fn distances(run: &LoggedRun, grid: &Grid) -> Option<Panel> {
    let positions = run.positions().filter(|positions| positions.len() > 1)?;
    let space = run.space();
    let to_nearest = |place: usize, sample: usize| {
        let own = positions[place].row(sample);
        let others = positions.iter().enumerate().filter(|(other, _)| *other != place);
        least(others.map(|(_, other)| distance(space, own, other.row(sample))))
    };
    let each = (0..positions.len())
        .map(|place| Curve {
            label: String::new(),
            agent: Some(place),
            second: false,
            values: grid.curve(|sample| to_nearest(place, sample)),
        })
        .collect();
    let smallest = Curve {
        label: "smallest of all".into(),
        agent: None,
        second: false,
        values: grid.curve(|sample| least((0..positions.len()).map(|place| to_nearest(place, sample)))),
    };
    let radii: Option<Vec<f64>> = (0..positions.len()).map(|place| run.radius(place)).collect();
    let contact = radii.map(|mut radii| {
        radii.sort_by(f64::total_cmp);
        radii.iter().rev().take(2).sum::<f64>()
    });
    let limits: Vec<Limit> =
        contact.map(|value| Limit { label: "largest sum of two radii".into(), value }).into_iter().collect();
    let view = |name: &str, curves| View {
        name: name.into(),
        axis: "distance".into(),
        unit: "m".into(),
        curves,
        limits: limits.clone(),
        ..View::default()
    };
    let views = vec![view("to the nearest agent", each), view("smallest of all", vec![smallest])];
    Some(Panel { id: "distances", title: "Distance between agents", kind: Kind::Lines, views })
}

pub(super) fn clearances(run: &LoggedRun, grid: &Grid) -> Option<Panel> {
    let obstacles = run.obstacles();
    let positions = run.positions().filter(|_| !obstacles.is_empty())?;
    let radii: Vec<f64> = (0..positions.len()).map(|place| run.radius(place).unwrap_or(0.0)).collect();
    // The distance of centres minus `keep`, for the obstacle where that is smallest.
    let view = |name: &str, limit: &str, keep: &dyn Fn(&Obstacle, f64) -> f64| View {
        name: name.into(),
        axis: "gap".into(),
        unit: "m".into(),
        curves: (0..positions.len())
            .map(|place| Curve {
                label: String::new(),
                agent: Some(place),
                second: false,
                values: grid.curve(|sample| {
                    let own = positions[place].row(sample);
                    least(obstacles.iter().map(|o| distance(2, own, &o.centre) - keep(o, radii[place])))
                }),
            })
            .collect(),
        limits: vec![Limit { label: limit.into(), value: 0.0 }],
        ..View::default()
    };
    let body = |obstacle: &Obstacle, radius: f64| obstacle.radius + radius;
    let inner = |obstacle: &Obstacle, radius: f64| match obstacle.boundaries(radius) {
        Some([inner, _]) => inner,
        None => body(obstacle, radius),
    };
    let mut views = vec![view("between the bodies", "contact", &body)];
    if obstacles.iter().any(|obstacle| obstacle.rings.is_some()) {
        views.insert(0, view("to the inner boundary", "inner boundary", &inner));
    }
    Some(Panel { id: "obstacles", title: "Distance to the nearest obstacle", kind: Kind::Lines, views })
}
