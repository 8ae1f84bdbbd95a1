//! How curves look: each has a colour, dashes and a marker, so that they stay apart in grey.

use super::picture::{Colour, Label, Picture, Point, Stroke};
use crate::show::view::LoggedRun;

/// Okabe and Ito's colours, ordered so that neighbours differ in lightness too.
const COLOURS: [Colour; 8] = [
    [0x00, 0x72, 0xb2],
    [0xe6, 0x9f, 0x00],
    [0x00, 0x00, 0x00],
    [0x56, 0xb4, 0xe9],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0x8a, 0x7f, 0x00],
];
/// Lengths of dashes and gaps, points.
const DASHES: [&[f64]; 6] =
    [&[], &[5.0, 1.6], &[1.3, 1.3], &[6.0, 1.5, 1.3, 1.5], &[2.8, 1.4], &[6.0, 1.4, 1.2, 1.4, 1.2, 1.4]];
const MARKERS: [Marker; 7] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
    Marker::Cross,
    Marker::TriangleDown,
    Marker::Plus,
];
/// Width of curves, points.
pub(super) const CURVE: f64 = 0.8;

/// A sign on a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Marker {
    Circle,
    Square,
    Triangle,
    TriangleDown,
    Diamond,
    Cross,
    Plus,
}

/// How a curve looks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Style {
    pub(super) colour: Colour,
    pub(super) dashes: &'static [f64],
    pub(super) marker: Option<Marker>,
}

impl Style {
    /// A solid black line, for what belongs to all.
    pub(super) const BLACK: Self = Self { colour: [0; 3], dashes: &[], marker: None };
    /// A horizontal line that means something by itself.
    pub(super) const LIMIT: Self = Self { colour: [0x44; 3], dashes: &[3.5, 2.0], marker: None };

    /// The style of the agent, or of the compared run, at this place: unique up to 168 of them.
    pub(super) fn at(place: usize) -> Self {
        Self {
            colour: COLOURS[place % COLOURS.len()],
            dashes: DASHES[place % DASHES.len()],
            marker: Some(MARKERS[place % MARKERS.len()]),
        }
    }

    /// The style of a curve beside another one of the same agent.
    pub(super) fn second(self) -> Self {
        Self { dashes: &[0.9, 1.8], marker: None, ..self }
    }

    pub(super) fn stroke(&self, width: f64) -> Stroke {
        Stroke { colour: self.colour, width, dashes: self.dashes.to_vec() }
    }
}

impl Marker {
    /// Draws it around `at`; it is about twice `radius` wide.
    pub(super) fn draw(self, picture: &mut Picture, (x, y): Point, radius: f64, colour: Colour) {
        let stroke = Stroke { colour, width: 0.7, dashes: Vec::new() };
        let white = Some([255; 3]);
        let corners = |corners: &[(f64, f64)]| -> Vec<Point> {
            corners.iter().map(|(dx, dy)| (x + dx * radius, y + dy * radius)).collect()
        };
        match self {
            Self::Circle => picture.circle((x, y), 0.95 * radius, Some(stroke), white),
            Self::Square => {
                let square = corners(&[(-0.85, -0.85), (0.85, -0.85), (0.85, 0.85), (-0.85, 0.85)]);
                picture.polygon(&square, Some(stroke), white);
            }
            Self::Triangle => {
                picture.polygon(&corners(&[(0.0, -1.15), (1.05, 0.75), (-1.05, 0.75)]), Some(stroke), white);
            }
            Self::TriangleDown => {
                picture.polygon(&corners(&[(0.0, 1.15), (1.05, -0.75), (-1.05, -0.75)]), Some(stroke), white);
            }
            Self::Diamond => {
                picture.polygon(&corners(&[(0.0, -1.25), (1.1, 0.0), (0.0, 1.25), (-1.1, 0.0)]), Some(stroke), white);
            }
            Self::Cross | Self::Plus => {
                let arm = if self == Self::Cross { 0.9 } else { 1.2 };
                let bars = match self {
                    Self::Cross => [[(-arm, -arm), (arm, arm)], [(-arm, arm), (arm, -arm)]],
                    _ => [[(-arm, 0.0), (arm, 0.0)], [(0.0, -arm), (0.0, arm)]],
                };
                for bar in bars {
                    picture.line(&corners(&bar), Stroke { width: 1.0, ..stroke.clone() });
                }
            }
        }
    }

    /// What matplotlib calls it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Circle => "o",
            Self::Square => "s",
            Self::Triangle => "^",
            Self::TriangleDown => "v",
            Self::Diamond => "D",
            Self::Cross => "x",
            Self::Plus => "+",
        }
    }
}

/// What an entry of a legend shows beside its name.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Sample {
    /// A piece of a curve.
    Curve(Style),
    /// The sign at the beginning of a trajectory.
    Start,
    /// The sign at its end.
    End,
}

/// What a legend says of a line.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) name: Label,
    pub(super) sample: Sample,
}

impl Entry {
    /// An entry for a curve.
    pub(super) fn curve(name: &str, style: Style) -> Self {
        Self { name: Label::plain(name), sample: Sample::Curve(style) }
    }
}

/// Agents from which on a legend would take more room than the figure.
const MANY_AGENTS: usize = 24;

/// An entry for every agent; no entries for so many agents that a legend could not distinguish them.
pub(super) fn agents(run: &LoggedRun) -> Vec<Entry> {
    let count = run.agents.len();
    if count > MANY_AGENTS {
        return Vec::new();
    }
    (0..count).map(|place| Entry::curve(&run.agent_name(place), Style::at(place))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn styles_differ_in_grey_too() {
        let styles: Vec<Style> = (0..24).map(Style::at).collect();
        for (index, style) in styles.iter().enumerate() {
            let alike = |other: &&Style| (other.dashes, other.marker) == (style.dashes, style.marker);
            assert_eq!(styles.iter().filter(alike).count(), 1, "style {index} is unique without its colour");
        }
    }
}
