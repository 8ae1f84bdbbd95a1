//! What keeps its shape: the bodies of the agents, each in a frame of its own, and the obstacles.

use formation::scenario::Obstacles;

use super::actors::Actor;
use super::message::{Figure, Marker, Pose, marker, markers};
use recording::Cdr;

/// Corners of a circle.
const CORNERS: usize = 48;
/// Thickness of a rotor, and of a line of a body, in arms of the drone.
const ROTOR: f64 = 0.06;
/// Boundaries of the potential fields of obstacles.
const BOUNDARY: [f32; 4] = [0.84, 0.37, 0.0, 0.9];

/// The bodies of all agents, one `MarkerArray`.
pub(super) fn bodies(cdr: &mut Cdr, time_ns: u64, actors: &[Actor]) {
    let parts = |actor: &Actor| if actor.planar { 3 } else { 6 };
    markers(cdr, actors.iter().map(parts).sum());
    for actor in actors {
        match actor.planar {
            true => robot(cdr, time_ns, actor),
            false => drone(cdr, time_ns, actor),
        }
        let height = (0.8 * actor.radius).max(0.15);
        marker(
            cdr,
            time_ns,
            &Marker {
                pose: Pose::at([0.0, 0.0, actor.radius + height]),
                scale: [height; 3],
                text: &actor.number.to_string(),
                ..part(actor, "number", 0, Figure::Text)
            },
        );
    }
}

/// A part of an agent's body, in its frame and colour.
fn part<'a>(actor: &'a Actor, namespace: &'static str, index: i32, figure: Figure) -> Marker<'a> {
    let id = 10 * actor.number as i32 + index;
    Marker { frame: &actor.frame, colour: actor.colour, ..Marker::new(namespace, id, figure) }
}

/// A disc, and an arrow where it heads.
fn robot(cdr: &mut Cdr, time_ns: u64, actor: &Actor) {
    let radius = actor.radius;
    let height = 0.6 * radius;
    marker(
        cdr,
        time_ns,
        &Marker {
            pose: Pose::at([0.0, 0.0, height / 2.0]),
            scale: [2.0 * radius, 2.0 * radius, height],
            ..part(actor, "body", 0, Figure::Cylinder)
        },
    );
    let above = 1.2 * height;
    marker(
        cdr,
        time_ns,
        &Marker {
            points: &[[0.0, 0.0, above], [1.8 * radius, 0.0, above]],
            // Diameter of the shaft, of the head, length of the head.
            scale: [0.18 * radius, 0.4 * radius, 0.5 * radius],
            ..part(actor, "heading", 0, Figure::Arrow)
        },
    );
}

/// Two crossed arms with four rotors, of which the one in front is solid.
fn drone(cdr: &mut Cdr, time_ns: u64, actor: &Actor) {
    let arm = actor.radius;
    marker(
        cdr,
        time_ns,
        &Marker {
            points: &[[-arm, 0.0, 0.0], [arm, 0.0, 0.0], [0.0, -arm, 0.0], [0.0, arm, 0.0]],
            scale: [ROTOR * arm, 0.0, 0.0],
            ..part(actor, "body", 0, Figure::LineList)
        },
    );
    for (index, [x, y]) in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].into_iter().enumerate() {
        let [red, green, blue, _] = actor.colour;
        marker(
            cdr,
            time_ns,
            &Marker {
                pose: Pose::at([x * arm, y * arm, 0.0]),
                scale: [1.1 * arm, 1.1 * arm, ROTOR * arm],
                colour: [red, green, blue, if index == 0 { 0.95 } else { 0.45 }],
                ..part(actor, "body", 1 + index as i32, Figure::Cylinder)
            },
        );
    }
}

/// The obstacles and the two boundaries of their potential fields for an agent of `radius` m, one `MarkerArray`.
pub(super) fn obstacles(cdr: &mut Cdr, time_ns: u64, obstacles: &Obstacles, radius: f64) {
    /// Height of an obstacle, which has none in the scenario, m.
    const HEIGHT: f64 = 0.3;
    let boundaries = obstacles.boundaries(radius);
    markers(cdr, 3 * boundaries.len());
    for (index, (boundary, own)) in boundaries.iter().zip(&obstacles.radii).enumerate() {
        let (id, [x, y]) = (index as i32 + 1, [boundary.centre.x, boundary.centre.y]);
        marker(
            cdr,
            time_ns,
            &Marker {
                pose: Pose::at([x, y, HEIGHT / 2.0]),
                scale: [2.0 * own, 2.0 * own, HEIGHT],
                colour: [0.5, 0.5, 0.5, 0.9],
                ..Marker::new("obstacle", id, Figure::Cylinder)
            },
        );
        for (namespace, radius, width) in
            [("inner boundary", boundary.inner, 0.02), ("outer boundary", boundary.outer, 0.01)]
        {
            marker(
                cdr,
                time_ns,
                &Marker {
                    pose: Pose::at([x, y, 0.01]),
                    scale: [width, 0.0, 0.0],
                    colour: BOUNDARY,
                    points: &circle(radius),
                    ..Marker::new(namespace, id, Figure::LineStrip)
                },
            );
        }
    }
}

/// A closed circle about the origin, on the ground.
fn circle(radius: f64) -> Vec<[f64; 3]> {
    let corner = |index: usize| {
        let angle = std::f64::consts::TAU * index as f64 / CORNERS as f64;
        [radius * libm::cos(angle), radius * libm::sin(angle), 0.0]
    };
    (0..=CORNERS).map(corner).collect()
}
