//! What the backend that draws pixels leaves out: the dashes of long lines, and cutting off what leaves a plot.

use kuva::render::render::{Primitive, Scene};

type Point = (f64, f64);
/// Left, top, right, bottom.
type Frame = [f64; 4];

/// Replaces every line by its dashes, as far as they lie within their plot.
pub(super) fn prepare(scene: &mut Scene) {
    let mut frames: Vec<Frame> = Vec::new();
    let mut prepared = Vec::with_capacity(scene.elements.len());
    for element in std::mem::take(&mut scene.elements) {
        match element {
            Primitive::PolyLine { points, stroke, stroke_width, stroke_dasharray } => {
                let pattern: Vec<f64> = stroke_dasharray.iter().flat_map(|text| numbers(text)).collect();
                for points in frames.last().map_or_else(|| vec![points.clone()], |frame| cut(&points, frame)) {
                    prepared.extend(dashes(&points, &pattern).into_iter().map(|points| Primitive::PolyLine {
                        points,
                        stroke: stroke.clone(),
                        stroke_width,
                        stroke_dasharray: None,
                    }));
                }
            }
            Primitive::Line { x1, y1, x2, y2, stroke, stroke_width, stroke_dasharray: Some(text) } => {
                let pattern: Vec<f64> = numbers(&text).collect();
                prepared.extend(dashes(&[(x1, y1), (x2, y2)], &pattern).into_iter().map(|points| {
                    Primitive::PolyLine { points, stroke: stroke.clone(), stroke_width, stroke_dasharray: None }
                }));
            }
            Primitive::ClipStart { x, y, width, height, .. } => frames.push([x, y, x + width, y + height]),
            Primitive::ClipEnd => drop(frames.pop()),
            other => prepared.push(other),
        }
    }
    scene.elements = prepared;
}

pub(super) fn numbers(text: &str) -> impl Iterator<Item = f64> {
    text.split([' ', ',']).filter_map(|number| number.parse().ok())
}

/// The pieces of a line that lie within `frame`.
fn cut(points: &[Point], frame: &Frame) -> Vec<Vec<Point>> {
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
fn visible(from: Point, to: Point, frame: &Frame) -> Option<[Point; 2]> {
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

/// Walks along the corners, pen down and up by turns; the whole line if there is no pattern.
fn dashes(points: &[Point], pattern: &[f64]) -> Vec<Vec<Point>> {
    if pattern.iter().sum::<f64>() <= 0.0 {
        return vec![points.to_vec()];
    }
    let mut result = Vec::new();
    let mut current: Vec<Point> = points.first().copied().into_iter().collect();
    let (mut index, mut left) = (0, pattern[0]);
    for pair in points.windows(2) {
        let [mut from, to] = [pair[0], pair[1]];
        loop {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            if length < left {
                left -= length;
                current.push(to);
                break;
            }
            let share = if length > 0.0 { left / length } else { 1.0 };
            from = (from.0 + (to.0 - from.0) * share, from.1 + (to.1 - from.1) * share);
            current.push(from);
            if index % 2 == 0 {
                result.push(std::mem::take(&mut current));
            }
            current = vec![from];
            index += 1;
            left = pattern[index % pattern.len()].max(1e-3);
        }
    }
    if index % 2 == 0 && current.len() > 1 {
        result.push(current);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_go_around_corners() {
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)];
        let expected = [vec![(0.0, 0.0), (3.0, 0.0)], vec![(4.0, 1.0), (4.0, 3.0)]];
        assert_eq!(dashes(&corners, &[3.0, 2.0]), expected);
        assert_eq!(dashes(&corners, &[]), [corners.to_vec()]);
    }

    #[test]
    fn what_leaves_the_plot_is_cut_off() {
        let zigzag = [(0.0, 0.0), (2.0, 4.0), (4.0, 0.0), (5.0, 0.0)];
        let frame = [0.0, -1.0, 10.0, 2.0];
        assert_eq!(cut(&zigzag, &frame), [vec![(0.0, 0.0), (1.0, 2.0)], vec![(3.0, 2.0), (4.0, 0.0), (5.0, 0.0)]]);
        assert!(cut(&[(0.0, 5.0), (9.0, 5.0)], &frame).is_empty());
    }
}
