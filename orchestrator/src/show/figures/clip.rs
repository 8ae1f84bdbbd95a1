//! What of a line lies within its plot.

use super::picture::Point;

/// Left, top, right, bottom.
pub(super) type Bounds = [f64; 4];

/// The pieces of a line that lie within `frame`.
pub(super) fn cut(points: &[Point], frame: &Bounds) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for pair in points.windows(2) {
        let Some([from, to]) = visible(pair[0], pair[1], frame) else { continue };
        match pieces.last_mut().filter(|piece| piece.last() == Some(&from)) {
            Some(piece) => piece.push(to),
            None => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// The part of a segment within `frame`. (Liang and Barsky)
fn visible(from: Point, to: Point, frame: &Bounds) -> Option<[Point; 2]> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for (step, room) in
        [(-dx, from.0 - frame[0]), (dx, frame[2] - from.0), (-dy, from.1 - frame[1]), (dy, frame[3] - from.1)]
    {
        if step == 0.0 && room < 0.0 {
            return None;
        }
        if step < 0.0 {
            start = start.max(room / step);
        } else if step > 0.0 {
            end = end.min(room / step);
        }
    }
    let at = |share: f64| (from.0 + share * dx, from.1 + share * dy);
    // The ends as they are, so that pieces join.
    let first = if start > 0.0 { at(start) } else { from };
    let last = if end < 1.0 { at(end) } else { to };
    (start <= end).then_some([first, last])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leaves_the_plot_is_cut_off() {
        let zigzag = [(0.0, 0.0), (2.0, 4.0), (4.0, 0.0), (5.0, 0.0)];
        let frame = [0.0, -1.0, 10.0, 2.0];
        assert_eq!(cut(&zigzag, &frame), [vec![(0.0, 0.0), (1.0, 2.0)], vec![(3.0, 2.0), (4.0, 0.0), (5.0, 0.0)]]);
        assert!(cut(&[(0.0, 5.0), (9.0, 5.0)], &frame).is_empty());
    }
}
