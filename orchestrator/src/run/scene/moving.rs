//! What changes its shape: links of the communication graph, and the trails of the agents.

use std::collections::VecDeque;

use super::actors::{Actor, Link};
use super::message::{Figure, Marker, marker, markers};
use recording::Cdr;

/// Width of a link, m.
const LINK_WIDTH: f64 = 0.015;
/// Links of the graph of the scenario, and links that exist while agents are close: name and colour.
const KINDS: [(&str, [f32; 4]); 2] = [("graph", [0.45, 0.55, 0.65, 0.7]), ("proximity", [0.9, 0.62, 0.0, 0.9])];
/// Width of a trail, m.
const TRAIL_WIDTH: f64 = 0.02;
/// Time between two points of a trail, ns ...
const TRAIL_STEP_NS: u64 = 500_000_000;
/// ... and between two drawings of it.
const TRAIL_NS: u64 = 1_000_000_000;
/// Points of a trail: 20 s of a run.
const TRAIL_POINTS: usize = 41;

/// A link that has come or gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Change {
    /// The sender.
    pub(super) from: usize,
    /// The receiver.
    pub(super) to: usize,
    /// Whether it exists now.
    pub(super) exists: bool,
}

/// All links, and which of them exist.
#[derive(Debug)]
pub(super) struct Links {
    links: Vec<(Link, bool)>,
    points: Vec<[f64; 3]>,
}

impl Links {
    pub(super) fn new(links: Vec<Link>) -> Self {
        Self { links: links.into_iter().map(|link| (link, false)).collect(), points: Vec::new() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// Asks again which links exist; returns those that came or went since it was asked last.
    pub(super) fn update(&mut self, exists: impl Fn(&Link) -> bool) -> Vec<Change> {
        let mut changes = Vec::new();
        for (link, known) in &mut self.links {
            let found = exists(link);
            if std::mem::replace(known, found) != found {
                changes.push(Change { from: link.from, to: link.to, exists: found });
            }
        }
        changes
    }

    /// The links that exist, between agents at these places, one `MarkerArray`.
    pub(super) fn draw(&mut self, cdr: &mut Cdr, time_ns: u64, places: &[[f64; 3]]) {
        let has = |fixed: bool| self.links.iter().any(|(link, _)| link.fixed == fixed);
        let kinds = [has(true), has(false)];
        markers(cdr, kinds.iter().filter(|has| **has).count());
        for ((namespace, colour), fixed) in
            KINDS.into_iter().zip([true, false]).filter(|(_, fixed)| kinds[usize::from(!fixed)])
        {
            self.points.clear();
            for (link, _) in self.links.iter().filter(|(link, exists)| *exists && link.fixed == fixed) {
                self.points.extend([places[link.from], places[link.to]]);
            }
            marker(
                cdr,
                time_ns,
                &Marker {
                    // A list of lines without a line is an error to some viewers.
                    gone: self.points.is_empty(),
                    scale: [LINK_WIDTH, 0.0, 0.0],
                    colour,
                    points: &self.points,
                    ..Marker::new(namespace, 0, Figure::LineList)
                },
            );
        }
    }
}

/// Where the agents came from, up to 20 s back.
#[derive(Debug)]
pub(super) struct Trails {
    /// Frames between two points, and between two drawings.
    every: [u64; 2],
    trails: Vec<VecDeque<[f64; 3]>>,
}

impl Trails {
    /// Trails of so many agents; `frames` says how many frames there are in a time in ns.
    pub(super) fn new(agents: usize, frames: impl Fn(u64) -> u64) -> Self {
        let every = [TRAIL_STEP_NS, TRAIL_NS].map(frames);
        Self { every, trails: vec![VecDeque::with_capacity(TRAIL_POINTS); agents] }
    }

    /// Takes the places of this frame; says whether it is time to draw.
    pub(super) fn update(&mut self, frame: u64, places: &[[f64; 3]]) -> bool {
        let [step, drawing] = self.every;
        if frame.is_multiple_of(step) {
            for (trail, place) in self.trails.iter_mut().zip(places) {
                if trail.len() == TRAIL_POINTS {
                    trail.pop_front();
                }
                // Half of the digits are enough to look at, and need half of the room.
                trail.push_back(place.map(|value| f64::from(value as f32)));
            }
        }
        frame.is_multiple_of(drawing) && self.trails.first().is_some_and(|trail| trail.len() > 1)
    }

    /// All trails, one `MarkerArray`.
    pub(super) fn draw(&mut self, cdr: &mut Cdr, time_ns: u64, actors: &[Actor]) {
        markers(cdr, self.trails.len());
        for (trail, actor) in self.trails.iter_mut().zip(actors) {
            let [red, green, blue, _] = actor.colour;
            marker(
                cdr,
                time_ns,
                &Marker {
                    scale: [TRAIL_WIDTH, 0.0, 0.0],
                    colour: [red, green, blue, 0.6],
                    points: trail.make_contiguous(),
                    ..Marker::new("trail", actor.number as i32, Figure::LineStrip)
                },
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trail_keeps_twenty_seconds() {
        let mut trails = Trails::new(1, |time_ns| time_ns / 20_000_000);
        let drawn: Vec<u64> = (0..2000).filter(|frame| trails.update(*frame, &[[*frame as f64, 0.0, 0.0]])).collect();
        assert_eq!((drawn[0], drawn[1], drawn.len()), (50, 100, 39));
        let trail = &trails.trails[0];
        assert_eq!((trail.len(), trail[0], trail[40]), (41, [975.0, 0.0, 0.0], [1975.0, 0.0, 0.0]));
    }
}
