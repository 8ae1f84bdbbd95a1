//! What a picture is made of. Lengths are points (1/72 inch); y points downwards.

use super::fonts::Font;
use super::outline::{Point, Segment};
use super::typeset::Typeset;

/// Red, green, blue.
pub(crate) type Colour = [u8; 3];

/// How an outline is drawn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stroke {
    pub(crate) colour: Colour,
    /// Points.
    pub(crate) width: f64,
    /// Lengths of dashes and gaps by turns, points; empty for a line without gaps.
    pub(crate) dashes: Vec<f64>,
}

/// One thing to draw.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    /// An outline, filled, drawn, or both.
    Path { segments: Vec<Segment>, stroke: Option<Stroke>, fill: Option<Colour> },
    /// A line of text in black; its baseline begins at `at` and goes to the right, or upwards.
    Text { text: Typeset, at: Point, upwards: bool },
}

/// A picture.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub(crate) width: f64,
    pub(crate) height: f64,
    /// What lies below comes first.
    pub(crate) shapes: Vec<Shape>,
    /// The font of its texts.
    pub(crate) font: Font,
}

impl Picture {
    /// A white picture.
    pub(crate) fn new(width: f64, height: f64, font: Font) -> Self {
        let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)];
        let mut picture = Self { width, height, shapes: Vec::new(), font };
        picture.polygon(&corners, None, Some([255; 3]));
        picture
    }

    /// Adds a line through these points.
    pub(crate) fn line(&mut self, points: &[Point], stroke: Stroke) {
        let segments = through(points).collect();
        self.shapes.push(Shape::Path { segments, stroke: Some(stroke), fill: None });
    }

    /// Adds a closed outline with these corners.
    pub(crate) fn polygon(&mut self, corners: &[Point], stroke: Option<Stroke>, fill: Option<Colour>) {
        let segments = through(corners).chain([Segment::Close]).collect();
        self.shapes.push(Shape::Path { segments, stroke, fill });
    }

    /// Adds a circle.
    pub(crate) fn circle(&mut self, (x, y): Point, radius: f64, stroke: Option<Stroke>, fill: Option<Colour>) {
        // Distance of the control points of a quarter of a circle from its ends, in radii.
        let c = 0.552_284_749_831 * radius;
        let r = radius;
        let segments = vec![
            Segment::Move((x + r, y)),
            Segment::Cubic((x + r, y + c), (x + c, y + r), (x, y + r)),
            Segment::Cubic((x - c, y + r), (x - r, y + c), (x - r, y)),
            Segment::Cubic((x - r, y - c), (x - c, y - r), (x, y - r)),
            Segment::Cubic((x + c, y - r), (x + r, y - c), (x + r, y)),
            Segment::Close,
        ];
        self.shapes.push(Shape::Path { segments, stroke, fill });
    }

    /// Adds a text, if there is any, whose baseline begins at `at`.
    pub(crate) fn text(&mut self, text: Typeset, at: Point) {
        if !text.is_empty() {
            self.shapes.push(Shape::Text { text, at, upwards: false });
        }
    }

    /// Adds a text that is read from below to above.
    pub(crate) fn upright(&mut self, text: Typeset, at: Point) {
        if !text.is_empty() {
            self.shapes.push(Shape::Text { text, at, upwards: true });
        }
    }
}

fn through(points: &[Point]) -> impl Iterator<Item = Segment> {
    points.iter().enumerate().map(|(index, &point)| match index {
        0 => Segment::Move(point),
        _ => Segment::Line(point),
    })
}
