//! Outlines: those of letters, and all that is drawn. Lengths are points (1/72 inch); y points downwards.

/// Points of an inch.
pub(crate) const INCH: f64 = 72.0;

/// x and y, points.
pub(crate) type Point = (f64, f64);

/// Where a place of a text is in the picture: `x` along its baseline and `y` below it, from `at`. The baseline goes to the right, or
/// `upwards`.
pub(super) fn placed(at: Point, upwards: bool, x: f64, y: f64) -> Point {
    if upwards { (at.0 + y, at.1 - x) } else { (at.0 + x, at.1 + y) }
}

/// A part of an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Segment<P = Point> {
    /// The beginning.
    Move(P),
    /// A straight line to here.
    Line(P),
    /// A cubic Bézier curve: two control points and the end.
    Cubic(P, P, P),
    /// Back to the beginning.
    Close,
}

impl Segment {
    /// The same with the numbers of PDF and of pixels.
    pub(super) fn single(self) -> Segment<(f32, f32)> {
        let single = |(x, y): Point| (x as f32, y as f32);
        match self {
            Self::Move(end) => Segment::Move(single(end)),
            Self::Line(end) => Segment::Line(single(end)),
            Self::Cubic(first, second, end) => Segment::Cubic(single(first), single(second), single(end)),
            Self::Close => Segment::Close,
        }
    }
}
