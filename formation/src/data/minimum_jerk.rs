//! A curve through waypoints that starts and ends at rest.

use crate::formula::Curve;

/// A vector and a matrix for the unknowns of a waypoint: velocity and acceleration.
type Pair = [f64; 2];
type Square = [Pair; 2];

/// The curve through the points `y` at the times `x` with velocity and acceleration 0 at both ends that has the least integral of
/// its squared third derivative: polynomials of degree five with four continuous derivatives (Flash and Hogan, 1985, for the
/// criterion). Held at its ends, it has two continuous derivatives everywhere.
pub(super) fn minimum_jerk(x: Vec<f64>, y: &[f64]) -> Curve {
    let states = states(&x, y);
    let mut coefficients = Vec::with_capacity(6 * (x.len() - 1));
    for k in 0..x.len() - 1 {
        let h = x[k + 1] - x[k];
        let ([v0, a0], [v1, a1]) = (states[k], states[k + 1]);
        // What is left for the higher powers at the end of the piece, in units of h.
        let place = (y[k + 1] - y[k]) - v0 * h - a0 * h * h / 2.0;
        let velocity = (v1 - v0) * h - a0 * h * h;
        let acceleration = (a1 - a0) * h * h;
        let cubic = 10.0 * place - 4.0 * velocity + acceleration / 2.0;
        let quartic = -15.0 * place + 7.0 * velocity - acceleration;
        let quintic = 6.0 * place - 3.0 * velocity + acceleration / 2.0;
        let cube = h * h * h;
        coefficients.extend([y[k], v0, a0 / 2.0, cubic / cube, quartic / (cube * h), quintic / (cube * h * h)]);
    }
    let end = y[y.len() - 1];
    Curve::new(x, 6, coefficients, end)
}

/// Velocity and acceleration at every point. Where two pieces meet, third and fourth derivatives are equal: a block tridiagonal
/// system with a positive definite matrix, solved by elimination from the first row on.
fn states(x: &[f64], y: &[f64]) -> Vec<Pair> {
    let n = x.len();
    let mut states = vec![[0.0; 2]; n];
    let mut upper = vec![[[0.0; 2]; 2]; n];
    for k in 1..n - 1 {
        let (l, r) = (x[k] - x[k - 1], x[k + 1] - x[k]);
        let (from, to) = (y[k] - y[k - 1], y[k + 1] - y[k]);
        let (l2, r2) = (l * l, r * r);
        let before = [[168.0 / (l2 * l), 24.0 / l2], [-24.0 / l2, -3.0 / l]];
        let middle = [
            [192.0 * (1.0 / (l2 * l) + 1.0 / (r2 * r)), 36.0 * (1.0 / r2 - 1.0 / l2)],
            [36.0 * (1.0 / r2 - 1.0 / l2), 9.0 * (1.0 / l + 1.0 / r)],
        ];
        let after = [[168.0 / (r2 * r), -24.0 / r2], [24.0 / r2, -3.0 / r]];
        let right = [360.0 * (from / (l2 * l2) + to / (r2 * r2)), 60.0 * (to / (r2 * r) - from / (l2 * l))];
        let pivot = inverse(difference(middle, product(before, upper[k - 1])));
        upper[k] = product(pivot, after);
        let known = image(before, states[k - 1]);
        states[k] = image(pivot, [right[0] - known[0], right[1] - known[1]]);
    }
    for k in (1..n - 1).rev() {
        let known = image(upper[k], states[k + 1]);
        states[k] = [states[k][0] - known[0], states[k][1] - known[1]];
    }
    states
}

fn image(a: Square, b: Pair) -> Pair {
    [a[0][0] * b[0] + a[0][1] * b[1], a[1][0] * b[0] + a[1][1] * b[1]]
}

fn product(a: Square, b: Square) -> Square {
    let column = |j: usize| image(a, [b[0][j], b[1][j]]);
    let (first, second) = (column(0), column(1));
    [[first[0], second[0]], [first[1], second[1]]]
}

fn difference(a: Square, b: Square) -> Square {
    [[a[0][0] - b[0][0], a[0][1] - b[0][1]], [a[1][0] - b[1][0], a[1][1] - b[1][1]]]
}

fn inverse(a: Square) -> Square {
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    [[a[1][1] / determinant, -a[0][1] / determinant], [-a[1][0] / determinant, a[0][0] / determinant]]
}
