//! Regulation of an input beyond its limits by a linear program. Algorithm 3, (6.25) to (6.28)
//!
//! Clipping an input element by element may push a coupled vehicle where no law asked it to go (the reverse effect). The
//! regulated input does as much as possible of what was demanded of every coordinate, and never more nor the opposite:
//! with `y = g ucom` and `σ_j = sign(y_j)`,
//!
//! ```text
//! maximise   Σ_j σ_j g_j·u
//! subject to -UM <= u_k <= UM  and  0 <= σ_j g_j·u <= |y_j|        for k, j = 1..3
//! ```
//!
//! `u = 0` is admissible and the box bounds the rest, so there always is an optimum, and a vertex is among the optima. With
//! three unknowns between six pairs of planes there are at most 160 vertices, and looking at all of them takes some
//! microseconds, always the same number of operations, without allocating.

#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, Vector3};

use super::clip_vector;

/// Pairs of parallel planes: three of the box, three of the rows of g.
const SLABS: usize = 6;

/// Vertices that three slabs each out of six can have.
const VERTICES: usize = 20 * 8;

/// Three planes whose normals have a smaller determinant are taken for parallel to one line.
const PARALLEL: f64 = 1e-12;

/// How much a vertex may lie outside a slab, relative to its upper bound where that is larger than 1.
const FEASIBILITY: f64 = 1e-9;

/// Vertices whose objectives, or squared distances, differ by less are equally good.
const TIE: f64 = 1e-9;

/// The input within `[-limit, limit]` that does most of what `commanded` asks for, where `effect` (g) tells what an input does.
///
/// A command within the limits comes back as it is. Where several vertices are optimal, the one nearest to `commanded` is
/// taken, and the first of those in the order of enumeration, so that the result does not depend on round-off. The result is
/// not a number if `commanded` is not finite.
///
/// ```
/// use formation::math::regulate;
/// use nalgebra::{Matrix3, Vector3};
/// let uncoupled = regulate(&Matrix3::identity(), &Vector3::new(7.0, -0.5, -3.0), 1.0);
/// assert_eq!(uncoupled, Vector3::new(1.0, -0.5, -1.0));
/// ```
pub fn regulate(effect: &Matrix3<f64>, commanded: &Vector3<f64>, limit: f64) -> Vector3<f64> {
    if clip_vector(commanded, limit) == *commanded {
        return *commanded;
    }
    clip_vector(&Program::new(effect, commanded, limit).solve(commanded), limit)
}

/// The linear program of one command: six slabs `low <= normal·u <= high`, and the objective.
struct Program {
    normal: [Vector3<f64>; SLABS],
    low: [f64; SLABS],
    high: [f64; SLABS],
    objective: Vector3<f64>,
}

impl Program {
    fn new(effect: &Matrix3<f64>, commanded: &Vector3<f64>, limit: f64) -> Self {
        let mut normal =
            [Vector3::x(), Vector3::y(), Vector3::z(), Vector3::zeros(), Vector3::zeros(), Vector3::zeros()];
        let mut low = [-limit; SLABS];
        let mut high = [limit; SLABS];
        let mut objective = Vector3::zeros();
        for j in 0..3 {
            let row = effect.row(j).transpose();
            let demanded = row.dot(commanded);
            normal[3 + j] = if demanded < 0.0 { -row } else { row };
            low[3 + j] = 0.0;
            high[3 + j] = demanded.abs();
            objective += normal[3 + j]; // (6.27)
        }
        Self { normal, low, high, objective }
    }

    /// The optimal vertex nearest to `commanded`.
    fn solve(&self, commanded: &Vector3<f64>) -> Vector3<f64> {
        let mut vertices = [Vector3::zeros(); VERTICES];
        let vertices = self.vertices(&mut vertices);
        let best = vertices.iter().map(|vertex| self.objective.dot(vertex)).fold(f64::NEG_INFINITY, f64::max);
        let mut nearest = Vector3::repeat(f64::NAN);
        let mut distance = f64::INFINITY;
        for vertex in vertices.iter().filter(|vertex| self.objective.dot(vertex) >= best - TIE) {
            let found = (vertex - commanded).norm_squared();
            if found < distance - TIE {
                (nearest, distance) = (*vertex, found);
            }
        }
        nearest
    }

    /// Writes the admissible intersections of three planes into `found`: slabs in lexicographic order, and the eight choices
    /// of their bounds counted in binary with the first slab as the lowest digit, an upper bound as 1.
    fn vertices<'a>(&self, found: &'a mut [Vector3<f64>; VERTICES]) -> &'a [Vector3<f64>] {
        let mut count = 0;
        for first in 0..SLABS {
            for second in first + 1..SLABS {
                for third in second + 1..SLABS {
                    let slabs = [first, second, third];
                    let Some(inverse) = self.inverse(slabs) else { continue };
                    for choice in 0..8 {
                        let bounds = [0, 1, 2].map(|digit| {
                            let side = if choice >> digit & 1 == 1 { &self.high } else { &self.low };
                            side[slabs[digit]]
                        });
                        let vertex = inverse[0] * bounds[0] + inverse[1] * bounds[1] + inverse[2] * bounds[2];
                        if self.admits(&vertex, slabs) {
                            found[count] = vertex;
                            count += 1;
                        }
                    }
                }
            }
        }
        &found[..count]
    }

    /// Columns of the inverse of the matrix whose rows are the normals of three slabs, by Cramer's rule.
    fn inverse(&self, [first, second, third]: [usize; 3]) -> Option<[Vector3<f64>; 3]> {
        let [a, b, c] = [&self.normal[first], &self.normal[second], &self.normal[third]];
        let across = b.cross(c);
        let determinant = a.dot(&across);
        (determinant.abs() >= PARALLEL).then(|| [across, c.cross(a), a.cross(b)].map(|column| column / determinant))
    }

    /// Whether `vertex` lies in the slabs other than those that it was made of.
    fn admits(&self, vertex: &Vector3<f64>, slabs: [usize; 3]) -> bool {
        (0..SLABS).filter(|slab| !slabs.contains(slab)).all(|slab| {
            let value = self.normal[slab].dot(vertex);
            let tolerance = FEASIBILITY * self.high[slab].max(1.0);
            self.low[slab] - tolerance <= value && value <= self.high[slab] + tolerance
        })
    }
}
