//! The communication graph: who receives from whom, and who knows the reference.

use nalgebra::SVector;

/// A directed, weighted graph with a reference link per agent.
///
/// `a(i, j) > 0` means that agent i receives from agent j. All agents are numbered from 0 here.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    size: usize,
    adjacency: Vec<f64>,
    reference: Vec<f64>,
    neighbours: Vec<Vec<usize>>,
}

impl Topology {
    /// A graph from the rows of its adjacency matrix and the weights b of the reference links.
    ///
    /// # Errors
    /// Says what is wrong if the matrix is not N x N with N = `reference.len()`, if an entry is negative or not finite, or if
    /// an agent is its own neighbour.
    pub fn new(rows: &[Vec<f64>], reference: Vec<f64>) -> Result<Self, String> {
        let size = reference.len();
        if rows.len() != size {
            return Err(format!("expected {size} rows, one per agent, found {}", rows.len()));
        }
        for (i, row) in rows.iter().enumerate() {
            if row.len() != size {
                return Err(format!("expected {size} x {size} values, found {} in row {}", row.len(), i + 1));
            }
            if let Some(j) = row.iter().position(|a| !(a.is_finite() && *a >= 0.0)) {
                return Err(format!("row {}, column {}: a weight is a number >= 0, found {}", i + 1, j + 1, row[j]));
            }
            if row[i] != 0.0 {
                return Err(format!("row {0}, column {0}: an agent is not its own neighbour, expected 0", i + 1));
            }
        }
        let adjacency: Vec<f64> = rows.iter().flatten().copied().collect();
        let neighbours = rows.iter().map(|row| (0..size).filter(|&j| row[j] > 0.0).collect()).collect();
        Ok(Self { size, adjacency, reference, neighbours })
    }

    /// The directed ring 1 -> 2 -> ... -> N -> 1 with unit weights.
    pub fn ring_rows(size: usize) -> Vec<Vec<f64>> {
        let weight = |i: usize, j: usize| if i != j && (j + 1) % size == i { 1.0 } else { 0.0 };
        (0..size).map(|i| (0..size).map(|j| weight(i, j)).collect()).collect()
    }

    /// The directed ring with unit weights, all agents knowing the reference.
    pub fn ring(size: usize) -> Self {
        let adjacency: Vec<f64> = Self::ring_rows(size).into_iter().flatten().collect();
        let neighbours = (0..size).map(|i| (0..size).filter(|&j| adjacency[i * size + j] > 0.0).collect()).collect();
        Self { size, adjacency, reference: vec![1.0; size], neighbours }
    }

    /// The ring 1 - 2 - ... - N - 1 with unit weights and links both ways.
    pub fn two_way_ring_rows(size: usize) -> Vec<Vec<f64>> {
        let one_way = Self::ring_rows(size);
        (0..size).map(|i| (0..size).map(|j| one_way[i][j].max(one_way[j][i])).collect()).collect()
    }

    /// Number of agents.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Weight of the link over which `i` receives from `j`; 0 if there is none.
    pub fn a(&self, i: usize, j: usize) -> f64 {
        self.adjacency[i * self.size + j]
    }

    /// Weight of the reference link of agent `i`.
    pub fn b(&self, i: usize) -> f64 {
        self.reference[i]
    }

    /// The in-neighbours of `i`: those it receives from, in ascending order.
    pub fn neighbours(&self, i: usize) -> &[usize] {
        &self.neighbours[i]
    }

    /// The local error of agent i, `sum_j a_ij (own - other_j) + b_i own`: row i of `(L + B)` times the errors.
    ///
    /// `others` yields the error of each in-neighbour in the order of [`Topology::neighbours`].
    pub fn local_error<const D: usize>(
        &self,
        i: usize,
        own: &SVector<f64, D>,
        others: impl IntoIterator<Item = SVector<f64, D>>,
    ) -> SVector<f64, D> {
        let mut sum = SVector::<f64, D>::zeros();
        for (&j, other) in self.neighbours[i].iter().zip(others) {
            sum += self.a(i, j) * (own - other);
        }
        sum + self.b(i) * own
    }

    /// The matrix `L + B`, row by row.
    #[cfg(test)]
    fn laplacian_plus_b(&self) -> Vec<Vec<f64>> {
        let row = |i: usize| -> Vec<f64> {
            let degree: f64 = (0..self.size).map(|j| self.a(i, j)).sum();
            (0..self.size).map(|j| if i == j { degree + self.b(i) } else { -self.a(i, j) }).collect()
        };
        (0..self.size).map(row).collect()
    }

    /// The first agent (from 0) that neither knows the reference nor hears, over any number of links, of one who does.
    ///
    /// `L + B` is invertible if there is none.
    pub fn unled_agent(&self) -> Option<usize> {
        let mut led: Vec<bool> = self.reference.iter().map(|weight| *weight > 0.0).collect();
        // Each round leads at least one more agent, or is the last that matters.
        for _ in 0..self.size {
            for i in 0..self.size {
                led[i] |= self.neighbours[i].iter().any(|&j| led[j]);
            }
        }
        led.iter().position(|led| !led)
    }

    /// Whether every agent reaches every other along the links. If not, the first pair (from, to) without a path, from 0.
    pub fn unreachable_pair(&self) -> Option<(usize, usize)> {
        for start in 0..self.size {
            let mut reached = vec![false; self.size];
            let mut stack = vec![start];
            reached[start] = true;
            while let Some(from) = stack.pop() {
                for to in (0..self.size).filter(|&to| self.a(to, from) > 0.0) {
                    if !std::mem::replace(&mut reached[to], true) {
                        stack.push(to);
                    }
                }
            }
            if let Some(missed) = reached.iter().position(|r| !r) {
                return Some((start, missed));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rows() -> impl Strategy<Value = Vec<Vec<f64>>> {
        (2..7usize).prop_flat_map(|n| {
            proptest::collection::vec(prop_oneof![Just(0.0), 0.1..3.0f64], n * n).prop_map(move |weights| {
                (0..n).map(|i| (0..n).map(|j| if i == j { 0.0 } else { weights[i * n + j] }).collect()).collect()
            })
        })
    }

    proptest! {
        #[test]
        fn rows_of_the_laplacian_sum_to_b(rows in rows(), b in 0.1..3.0f64) {
            let graph = Topology::new(&rows, vec![b; rows.len()]).unwrap();
            for row in graph.laplacian_plus_b() {
                prop_assert!((row.iter().sum::<f64>() - b).abs() < 1e-12);
            }
        }

        /// L + B is strictly row diagonally dominant, hence every real part of its spectrum is positive; for a symmetric
        /// graph that makes it positive definite.
        #[test]
        fn symmetric_graphs_give_positive_definite_matrices(rows in rows(), b in 0.1..3.0f64, x in proptest::collection::vec(-1.0..1.0f64, 7)) {
            let n = rows.len();
            let symmetric: Vec<Vec<f64>> =
                (0..n).map(|i| (0..n).map(|j| rows[i][j] + rows[j][i]).collect()).collect();
            let graph = Topology::new(&symmetric, vec![b; n]).unwrap();
            let matrix = graph.laplacian_plus_b();
            let form: f64 = (0..n).map(|i| (0..n).map(|j| x[i] * matrix[i][j] * x[j]).sum::<f64>()).sum();
            let norm: f64 = x[..n].iter().map(|v| v * v).sum();
            prop_assert!(form >= b * norm - 1e-9);
        }

        #[test]
        fn local_errors_are_the_rows_of_l_plus_b(rows in rows(), x in proptest::collection::vec(-5.0..5.0f64, 7)) {
            let n = rows.len();
            let graph = Topology::new(&rows, vec![1.5; n]).unwrap();
            let matrix = graph.laplacian_plus_b();
            for i in 0..n {
                let others = graph.neighbours(i).iter().map(|&j| SVector::<f64, 1>::new(x[j]));
                let local = graph.local_error(i, &SVector::<f64, 1>::new(x[i]), others)[0];
                let expected: f64 = (0..n).map(|j| matrix[i][j] * x[j]).sum();
                prop_assert!((local - expected).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn strong_connection() {
        let ring = Topology::new(&Topology::ring_rows(4), vec![1.0; 4]).unwrap();
        assert_eq!(ring.unreachable_pair(), None);
        assert_eq!(ring.neighbours(0), [3]);
        let mut rows = Topology::ring_rows(4);
        rows[2][1] = 0.0;
        let path = Topology::new(&rows, vec![1.0; 4]).unwrap();
        assert_eq!(path.unreachable_pair(), Some((0, 2)));
    }

    #[test]
    fn leaders_lead_those_who_hear_of_them() {
        let mut rows = Topology::two_way_ring_rows(4);
        assert_eq!(rows, [[0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 1.0, 0.0]]);
        let led_by_last = |rows: &[Vec<f64>]| Topology::new(rows, vec![0.0, 0.0, 0.0, 1.0]).unwrap().unled_agent();
        assert_eq!(led_by_last(&rows), None);
        rows[0][3] = 0.0;
        assert_eq!(led_by_last(&rows), None);
        rows[2][3] = 0.0;
        assert_eq!(led_by_last(&rows), Some(0));
        assert_eq!(Topology::new(&vec![vec![0.0; 3]; 3], vec![1.0; 3]).unwrap().unled_agent(), None);
        assert_eq!(Topology::two_way_ring_rows(2), [[0.0, 1.0], [1.0, 0.0]]);
    }

    #[test]
    fn malformed_matrices_are_refused_with_the_place() {
        let refuse = |rows: &[Vec<f64>]| Topology::new(rows, vec![1.0; 2]).unwrap_err();
        assert_eq!(refuse(&[vec![0.0, 1.0]]), "expected 2 rows, one per agent, found 1");
        assert_eq!(refuse(&[vec![0.0, 1.0], vec![1.0]]), "expected 2 x 2 values, found 1 in row 2");
        assert!(refuse(&[vec![0.0, -1.0], vec![1.0, 0.0]]).contains("row 1, column 2"));
        assert!(refuse(&[vec![1.0, 1.0], vec![1.0, 0.0]]).contains("not its own neighbour"));
    }
}
