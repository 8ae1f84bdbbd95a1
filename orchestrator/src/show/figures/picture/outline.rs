//! Outlines: those of letters, and all that is drawn. Lengths are points (1/72 inch); y points downwards.

/// x and y, points.
pub(crate) type Point = (f64, f64);

/// A part of an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Segment {
    /// The beginning.
    Move(Point),
    /// A straight line to here.
    Line(Point),
    /// A cubic Bézier curve: two control points and the end.
    Cubic(Point, Point, Point),
    /// Back to the beginning.
    Close,
}
