//! The communication graph: which agents receive from which, and which know the reference.

use nalgebra::SVector;

/// A directed, weighted graph with a reference link per agent.
///
/// `a(i, j) > 0` means that agent i receives from agent j. All agents are numbered from 0 here. Only the links that exist take
/// memory, so that a ring of many agents is as cheap as it looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    rows: Vec<Neighbourhood>,
}

/// What one agent knows of the graph: the links over which it receives, and the weight of its link to the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbourhood {
    /// In-neighbours, ascending.
    neighbours: Vec<usize>,
    /// The weight of the link from each of them.
    weights: Vec<f64>,
    reference: f64,
}

impl Neighbourhood {
    /// That of an agent without neighbours that knows the reference with weight `reference`.
    pub fn alone(reference: f64) -> Self {
        Self { neighbours: Vec::new(), weights: Vec::new(), reference }
    }

    /// The neighbours with their weights, ascending; links of weight 0 are no links.
    fn new(links: impl Iterator<Item = (usize, f64)>, reference: f64) -> Self {
        let (neighbours, weights) = links.filter(|(_, weight)| *weight > 0.0).unzip();
        Self { neighbours, weights, reference }
    }

    /// The in-neighbours: those that the agent receives from, in ascending order.
    pub fn neighbours(&self) -> &[usize] {
        &self.neighbours
    }

    /// Weight of the link from agent `j`; 0 if there is none.
    pub fn weight(&self, j: usize) -> f64 {
        self.neighbours.binary_search(&j).map_or(0.0, |place| self.weights[place])
    }

    /// Weight of the reference link.
    pub fn b(&self) -> f64 {
        self.reference
    }

    /// The local error of the agent, `sum_j a_ij (own - other_j) + b_i own`: its row of `(L + B)` times the errors.
    ///
    /// `others` yields the error of each in-neighbour in the order of [`Neighbourhood::neighbours`].
    pub fn local_error<const D: usize>(
        &self,
        own: &SVector<f64, D>,
        others: impl IntoIterator<Item = SVector<f64, D>>,
    ) -> SVector<f64, D> {
        let mut sum = SVector::<f64, D>::zeros();
        for (&weight, other) in self.weights.iter().zip(others) {
            sum += weight * (own - other);
        }
        sum + self.reference * own
    }
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
        let row = |(row, b): (&Vec<f64>, f64)| Neighbourhood::new(row.iter().copied().enumerate(), b);
        Ok(Self { rows: rows.iter().zip(reference).map(row).collect() })
    }

    /// The directed ring 1 -> 2 -> ... -> N -> 1 with unit weights; `reference` are the weights of the reference links.
    pub fn ring(reference: Vec<f64>) -> Self {
        let size = reference.len();
        let before = |i: usize| (size > 1).then(|| ((i + size - 1) % size, 1.0)).into_iter();
        Self { rows: reference.into_iter().enumerate().map(|(i, b)| Neighbourhood::new(before(i), b)).collect() }
    }

    /// The ring 1 - 2 - ... - N - 1 with unit weights and links both ways.
    pub fn two_way_ring(reference: Vec<f64>) -> Self {
        let size = reference.len();
        let beside = |i: usize| {
            let mut both = if size > 1 { vec![(i + 1) % size, (i + size - 1) % size] } else { Vec::new() };
            both.sort_unstable();
            both.dedup();
            both.into_iter().map(|j| (j, 1.0))
        };
        Self { rows: reference.into_iter().enumerate().map(|(i, b)| Neighbourhood::new(beside(i), b)).collect() }
    }

    /// Number of agents.
    pub fn size(&self) -> usize {
        self.rows.len()
    }

    /// What agent `i` knows of the graph.
    pub fn neighbourhood(&self, i: usize) -> &Neighbourhood {
        &self.rows[i]
    }

    /// Weight of the link over which `i` receives from `j`; 0 if there is none.
    pub fn a(&self, i: usize, j: usize) -> f64 {
        self.rows[i].weight(j)
    }

    /// Weight of the reference link of agent `i`.
    pub fn b(&self, i: usize) -> f64 {
        self.rows[i].reference
    }

    /// The in-neighbours of `i`: those it receives from, in ascending order.
    pub fn neighbours(&self, i: usize) -> &[usize] {
        self.rows[i].neighbours()
    }

    /// The local error of agent i; see [`Neighbourhood::local_error`].
    pub fn local_error<const D: usize>(
        &self,
        i: usize,
        own: &SVector<f64, D>,
        others: impl IntoIterator<Item = SVector<f64, D>>,
    ) -> SVector<f64, D> {
        self.rows[i].local_error(own, others)
    }

    /// Row i of the matrix A, with a 0 where there is no link.
    pub fn dense_row(&self, i: usize) -> Vec<f64> {
        let mut row = vec![0.0; self.size()];
        self.rows[i].neighbours.iter().zip(&self.rows[i].weights).for_each(|(&j, &weight)| row[j] = weight);
        row
    }

    /// The first agent (from 0) that neither knows the reference nor hears, over any number of links, of one that does.
    ///
    /// `L + B` is invertible if there is none.
    pub fn unled_agent(&self) -> Option<usize> {
        let leaders = (0..self.size()).filter(|&i| self.b(i) > 0.0);
        reached(&self.receivers(), leaders).iter().position(|led| !led)
    }

    /// Whether every agent reaches every other along the links. If not, the first pair (from, to) without a path, from 0.
    pub fn unreachable_pair(&self) -> Option<(usize, usize)> {
        if self.rows.is_empty() {
            return None;
        }
        let receivers = self.receivers();
        let missed_by = |from: usize| reached(&receivers, [from]).iter().position(|reached| !reached);
        if let Some(missed) = missed_by(0) {
            return Some((0, missed));
        }
        // Agent 0 reaches all: exactly those that do not reach it miss some.
        let senders: Vec<&[usize]> = self.rows.iter().map(Neighbourhood::neighbours).collect();
        let from = reached(&senders, [0]).iter().position(|reaches| !reaches)?;
        missed_by(from).map(|missed| (from, missed))
    }

    /// By agent, those that receive from it: the links the other way round.
    fn receivers(&self) -> Vec<Vec<usize>> {
        let mut receivers = vec![Vec::new(); self.size()];
        for (i, row) in self.rows.iter().enumerate() {
            row.neighbours.iter().for_each(|&j| receivers[j].push(i));
        }
        receivers
    }
}

/// Whether each agent is among `start` or can be reached from there over `next`, which lists by agent where a link leads.
fn reached(next: &[impl AsRef<[usize]>], start: impl IntoIterator<Item = usize>) -> Vec<bool> {
    let mut reached = vec![false; next.len()];
    let mut waiting: Vec<usize> = start.into_iter().collect();
    while let Some(at) = waiting.pop() {
        if !std::mem::replace(&mut reached[at], true) {
            waiting.extend(next[at].as_ref().iter().filter(|&&to| !reached[to]));
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The matrix A.
    fn matrix(graph: &Topology) -> Vec<Vec<f64>> {
        (0..graph.size()).map(|i| graph.dense_row(i)).collect()
    }

    /// The matrix `L + B`.
    fn laplacian_plus_b(graph: &Topology) -> Vec<Vec<f64>> {
        let row = |i: usize| -> Vec<f64> {
            let degree: f64 = graph.dense_row(i).iter().sum();
            (0..graph.size()).map(|j| if i == j { degree + graph.b(i) } else { -graph.a(i, j) }).collect()
        };
        (0..graph.size()).map(row).collect()
    }

    fn rows() -> impl Strategy<Value = Vec<Vec<f64>>> {
        (2..7usize).prop_flat_map(|n| {
            proptest::collection::vec(prop_oneof![Just(0.0), 0.1..3.0f64], n * n).prop_map(move |weights| {
                (0..n).map(|i| (0..n).map(|j| if i == j { 0.0 } else { weights[i * n + j] }).collect()).collect()
            })
        })
    }

    /// As the definition has it: every agent from every other, and the reference from leader to leader.
    fn reaches(rows: &[Vec<f64>]) -> Vec<Vec<bool>> {
        let n = rows.len();
        let mut reaches: Vec<Vec<bool>> =
            (0..n).map(|i| (0..n).map(|j| i == j || rows[j][i] > 0.0).collect()).collect();
        for via in 0..n {
            for from in 0..n {
                for to in 0..n {
                    reaches[from][to] |= reaches[from][via] && reaches[via][to];
                }
            }
        }
        reaches
    }

    proptest! {
        #[test]
        fn a_graph_gives_its_matrix_back(rows in rows()) {
            prop_assert_eq!(matrix(&Topology::new(&rows, vec![1.0; rows.len()]).unwrap()), rows);
        }

        #[test]
        fn paths_are_found_where_there_are_any(rows in rows(), leaders in proptest::collection::vec(proptest::bool::ANY, 7)) {
            let n = rows.len();
            let b = leaders[..n].iter().map(|&leads| f64::from(u8::from(leads))).collect();
            let (graph, reaches) = (Topology::new(&rows, b).unwrap(), reaches(&rows));
            let mut pairs = (0..n).flat_map(|from| (0..n).map(move |to| (from, to)));
            prop_assert_eq!(graph.unreachable_pair(), pairs.find(|&(from, to)| !reaches[from][to]));
            let is_led = |to: usize| (0..n).any(|from| leaders[from] && reaches[from][to]);
            prop_assert_eq!(graph.unled_agent(), (0..n).find(|&agent| !is_led(agent)));
        }

        #[test]
        fn rows_of_the_laplacian_sum_to_b(rows in rows(), b in 0.1..3.0f64) {
            let graph = Topology::new(&rows, vec![b; rows.len()]).unwrap();
            for row in laplacian_plus_b(&graph) {
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
            let matrix = laplacian_plus_b(&graph);
            let form: f64 = (0..n).map(|i| (0..n).map(|j| x[i] * matrix[i][j] * x[j]).sum::<f64>()).sum();
            let norm: f64 = x[..n].iter().map(|v| v * v).sum();
            prop_assert!(form >= b * norm - 1e-9);
        }

        #[test]
        fn local_errors_are_the_rows_of_l_plus_b(rows in rows(), x in proptest::collection::vec(-5.0..5.0f64, 7)) {
            let n = rows.len();
            let graph = Topology::new(&rows, vec![1.5; n]).unwrap();
            let matrix = laplacian_plus_b(&graph);
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
        let ring = Topology::ring(vec![1.0; 4]);
        assert_eq!(ring.unreachable_pair(), None);
        assert_eq!(ring.neighbours(0), [3]);
        let mut rows = matrix(&ring);
        rows[2][1] = 0.0;
        let path = Topology::new(&rows, vec![1.0; 4]).unwrap();
        assert_eq!(path.unreachable_pair(), Some((0, 2)));
    }

    #[test]
    fn leaders_lead_those_who_hear_of_them() {
        let mut rows = matrix(&Topology::two_way_ring(vec![1.0; 4]));
        assert_eq!(rows, [[0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 1.0, 0.0]]);
        let led_by_last = |rows: &[Vec<f64>]| Topology::new(rows, vec![0.0, 0.0, 0.0, 1.0]).unwrap().unled_agent();
        assert_eq!(led_by_last(&rows), None);
        rows[0][3] = 0.0;
        assert_eq!(led_by_last(&rows), None);
        rows[2][3] = 0.0;
        assert_eq!(led_by_last(&rows), Some(0));
        assert_eq!(Topology::new(&vec![vec![0.0; 3]; 3], vec![1.0; 3]).unwrap().unled_agent(), None);
        assert_eq!(matrix(&Topology::two_way_ring(vec![1.0; 2])), [[0.0, 1.0], [1.0, 0.0]]);
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
