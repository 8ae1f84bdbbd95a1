//! Curves through the points of a table.

use crate::formula::Curve;

/// The value of each point up to the next one.
pub(super) fn hold(x: Vec<f64>, y: &[f64]) -> Curve {
    let end = y[y.len() - 1];
    Curve::new(x, 1, y[..y.len() - 1].to_vec(), end)
}

/// Straight lines from point to point.
pub(super) fn linear(x: Vec<f64>, y: &[f64]) -> Curve {
    let lines = x.windows(2).zip(y.windows(2)).flat_map(|(x, y)| [y[0], (y[1] - y[0]) / (x[1] - x[0])]).collect();
    Curve::new(x, 2, lines, y[y.len() - 1])
}

/// The cubic spline without knots at the second and the second last point ("not a knot"): two continuous derivatives, and the
/// polynomial itself through points of a cubic. de Boor, A Practical Guide to Splines (1978), chapter IV.
pub(super) fn cubic(x: Vec<f64>, y: &[f64]) -> Curve {
    let slopes = slopes(&x, y);
    let mut coefficients = Vec::with_capacity(4 * (x.len() - 1));
    for k in 0..x.len() - 1 {
        let h = x[k + 1] - x[k];
        let chord = (y[k + 1] - y[k]) / h;
        let bend = (slopes[k] + slopes[k + 1] - 2.0 * chord) / h;
        coefficients.extend([y[k], slopes[k], (chord - slopes[k]) / h - bend, bend / h]);
    }
    let end = y[y.len() - 1];
    Curve::new(x, 4, coefficients, end)
}

/// The slopes of the cubic spline at its points: a tridiagonal system, solved by elimination from the first row on.
fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let h: Vec<f64> = x.windows(2).map(|x| x[1] - x[0]).collect();
    let chord: Vec<f64> = y.windows(2).zip(&h).map(|(y, h)| (y[1] - y[0]) / h).collect();
    match n {
        2 => return vec![chord[0]; 2],
        3 => {
            // All that is left of three points is the parabola through them.
            let middle = (h[1] * chord[0] + h[0] * chord[1]) / (h[0] + h[1]);
            return vec![2.0 * chord[0] - middle, middle, 2.0 * chord[1] - middle];
        }
        _ => {}
    }
    let mut upper = vec![0.0; n];
    let mut slopes = vec![0.0; n];
    // The third derivative is continuous at the second point.
    let both = h[0] + h[1];
    upper[0] = both / h[1];
    slopes[0] = ((h[0] + 2.0 * both) * h[1] * chord[0] + h[0] * h[0] * chord[1]) / both / h[1];
    for k in 1..n - 1 {
        let (before, after) = (h[k], h[k - 1]);
        let pivot = 2.0 * (before + after) - before * upper[k - 1];
        upper[k] = after / pivot;
        let right = 3.0 * (before * chord[k - 1] + after * chord[k]);
        slopes[k] = (right - before * slopes[k - 1]) / pivot;
    }
    let (last, other) = (h[n - 2], h[n - 3]);
    let both = last + other;
    let right = (last * last * chord[n - 3] + (2.0 * both + last) * other * chord[n - 2]) / both;
    let pivot = other - both * upper[n - 2];
    slopes[n - 1] = (right - both * slopes[n - 2]) / pivot;
    for k in (0..n - 1).rev() {
        slopes[k] -= upper[k] * slopes[k + 1];
    }
    slopes
}
