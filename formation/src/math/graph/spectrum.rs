//! Numbers that describe a graph as a whole: its Laplacian, eigenvalues, connectivity and diameter.

use nalgebra::{DMatrix, DVector, Schur};

use super::{Link, Topology, reached};

/// The eigenvalues of a graph.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// The real parts of the eigenvalues of the Laplacian, ascending; all of each for a graph with links both ways.
    pub eigenvalues: Vec<f64>,
    /// Algebraic connectivity: the least value of `x' L x` over the vectors x of length 1 whose sum is 0. For a graph with links both
    /// ways it is the second smallest eigenvalue (Fiedler 1973), and above 0 just where the graph is connected. For a directed graph
    /// it is that of Wu (Linear and Multilinear Algebra 53, 2005), which for a balanced one is the second smallest eigenvalue of
    /// its mirror graph (Olfati-Saber and Murray 2004); it may be below 0.
    pub algebraic_connectivity: f64,
}

/// An eigenvalue takes about two of these steps; more mean that none is found.
const STEPS_PER_EIGENVALUE: usize = 300;

impl Topology {
    /// The Laplacian `L = D - A` with the sums of the rows of A in the diagonal of D; links to the reference are not in it.
    pub fn laplacian(&self) -> DMatrix<f64> {
        let size = self.size();
        let mut matrix = DMatrix::zeros(size, size);
        for Link { from, to, weight } in self.links() {
            matrix[(to, to)] += weight;
            matrix[(to, from)] -= weight;
        }
        matrix
    }

    /// The agents in groups in which each reaches every other. The eigenvalues of the Laplacian are those of its blocks for these groups.
    fn strong_components(&self) -> Vec<Vec<usize>> {
        let receivers = self.receivers();
        let senders: Vec<&[usize]> = self.rows.iter().map(|row| row.neighbours()).collect();
        let mut is_known = vec![false; self.size()];
        let mut components = Vec::new();
        for agent in 0..self.size() {
            if !is_known[agent] {
                let (to, from) = (reached(&receivers, [agent]), reached(&senders, [agent]));
                let component: Vec<usize> = (agent..self.size()).filter(|&other| to[other] && from[other]).collect();
                component.iter().for_each(|&member| is_known[member] = true);
                components.push(component);
            }
        }
        components
    }

    /// The eigenvalues; takes time in proportion to the cube of the number of agents. Nothing if there are no agents, or if the
    /// iteration does not find them.
    pub fn spectrum(&self) -> Option<Spectrum> {
        let size = self.size();
        if size == 0 {
            return None;
        }
        let laplacian = self.laplacian();
        let symmetric_part = (&laplacian + laplacian.transpose()) * 0.5;
        let mut eigenvalues = Vec::with_capacity(size);
        for component in self.strong_components() {
            let block =
                DMatrix::from_fn(component.len(), component.len(), |i, j| laplacian[(component[i], component[j])]);
            eigenvalues.extend(real_parts(block)?);
        }
        eigenvalues.sort_by(f64::total_cmp);
        Some(Spectrum { eigenvalues, algebraic_connectivity: least_across(symmetric_part) })
    }

    /// The largest number of links on the shortest way from one agent to another; `None` if some agent does not reach every other. Takes
    /// time in proportion to the number of agents times that of links.
    pub fn diameter(&self) -> Option<usize> {
        let receivers = self.receivers();
        let farthest = |from: usize| {
            let mut distance = vec![None; self.size()];
            distance[from] = Some(0);
            let mut waiting = std::collections::VecDeque::from([from]);
            while let Some(at) = waiting.pop_front() {
                let next = distance[at].map(|links| links + 1);
                for &to in &receivers[at] {
                    if distance[to].is_none() {
                        distance[to] = next;
                        waiting.push_back(to);
                    }
                }
            }
            distance.into_iter().try_fold(0_usize, |most, links| links.map(|links: usize| most.max(links)))
        };
        (0..self.size()).map(farthest).try_fold(0, |most, links| links.map(|links| most.max(links)))
    }

    /// Whether every agent reaches every other if links may be used against their direction.
    pub fn is_weakly_connected(&self) -> bool {
        let mut beside = self.receivers();
        for Link { from, to, .. } in self.links() {
            beside[to].push(from);
        }
        beside.is_empty() || reached(&beside, [0]).iter().all(|reached| *reached)
    }
}

/// The real parts of the eigenvalues of a matrix; `None` if the iteration does not find them.
fn real_parts(matrix: DMatrix<f64>) -> Option<Vec<f64>> {
    if matrix == matrix.transpose() {
        return Some(matrix.symmetric_eigenvalues().iter().copied().collect());
    }
    let steps = STEPS_PER_EIGENVALUE * matrix.nrows();
    let schur = Schur::try_new(matrix, f64::EPSILON, steps)?;
    Some(schur.complex_eigenvalues().iter().map(|value| value.re).collect())
}

/// The least value of `x' S x` over the vectors x of length 1 whose sum is 0; 0 if there are none.
fn least_across(symmetric: DMatrix<f64>) -> f64 {
    let size = symmetric.nrows();
    if size < 2 {
        return 0.0;
    }
    // A Householder reflection takes the vector of ones to the first axis, and what is orthogonal to it to the others.
    let mut normal = DVector::from_element(size, 1.0 / (size as f64).sqrt());
    normal[0] += 1.0;
    let scale = 2.0 / normal.norm_squared();
    let reflection = DMatrix::identity(size, size) - (&normal * normal.transpose()) * scale;
    let reflected = &reflection * symmetric * &reflection;
    let rest = reflected.view((1, 1), (size - 1, size - 1)).into_owned();
    rest.symmetric_eigenvalues().min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Family, Orientation};
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn graph(family: Family, size: usize) -> Topology {
        Topology::from_links(&family.links(size, 1.0).unwrap(), vec![1.0; size]).unwrap()
    }

    /// The eigenvalues that a formula of k gives, ascending.
    fn sorted(size: usize, value: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut values: Vec<f64> = (0..size).map(|k| value(k as f64)).collect();
        values.sort_by(f64::total_cmp);
        values
    }

    fn close(found: &[f64], expected: &[f64]) -> bool {
        found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn eigenvalues_of_known_graphs() {
        let undirected = Orientation::Undirected;
        for size in [1, 2, 3, 7, 12] {
            let n = size as f64;
            let of = |family| graph(family, size).spectrum().unwrap();
            let complete = of(Family::Complete);
            assert!(close(&complete.eigenvalues, &sorted(size, |k| if k == 0.0 { 0.0 } else { n })));
            assert!((complete.algebraic_connectivity - if size > 1 { n } else { 0.0 }).abs() < 1e-9);
            let path = of(Family::Line(undirected));
            assert!(close(&path.eigenvalues, &sorted(size, |k| 2.0 - 2.0 * libm::cos(PI * k / n))));
            if size > 2 {
                let cycle = of(Family::Ring(undirected));
                assert!(close(&cycle.eigenvalues, &sorted(size, |k| 2.0 - 2.0 * libm::cos(2.0 * PI * k / n))));
                assert!((cycle.algebraic_connectivity - cycle.eigenvalues[1]).abs() < 1e-9);
                // 1 - exp(2 pi i k / n); its mirror graph is half of the cycle with links both ways.
                let directed = of(Family::Ring(Orientation::Directed));
                assert!(close(&directed.eigenvalues, &sorted(size, |k| 1.0 - libm::cos(2.0 * PI * k / n))));
                assert!((directed.algebraic_connectivity - 0.5 * cycle.eigenvalues[1]).abs() < 1e-9);
                let star = of(Family::Star { centre: 1, orientation: undirected });
                assert!(close(
                    &star.eigenvalues,
                    &sorted(size, |k| if k == 0.0 {
                        0.0
                    } else if k == 1.0 {
                        n
                    } else {
                        1.0
                    })
                ));
            }
        }
        // With x of sum 0, the form of the star is the sum of all squares, and that of one link among three is below 0 somewhere.
        let star = Family::Star { centre: 0, orientation: Orientation::Directed };
        assert!((graph(star, 12).spectrum().unwrap().algebraic_connectivity - 1.0).abs() < 1e-9);
        let link = Topology::from_links(&[Link { from: 0, to: 2, weight: 1.0 }], vec![1.0; 3]).unwrap();
        assert!(link.spectrum().unwrap().algebraic_connectivity < -0.05);
    }

    #[test]
    fn diameters() {
        let undirected = Orientation::Undirected;
        let of = |family, size| graph(family, size).diameter();
        assert_eq!(of(Family::Ring(Orientation::Directed), 6), Some(5));
        assert_eq!([of(Family::Ring(undirected), 6), of(Family::Complete, 6)], [Some(3), Some(1)]);
        assert_eq!(of(Family::Grid { shape: Some([3, 4]) }, 12), Some(5));
        assert_eq!([of(Family::Line(Orientation::Directed), 3), of(Family::Complete, 1)], [None, Some(0)]);
        let line = graph(Family::Line(Orientation::Directed), 3);
        assert!(line.is_weakly_connected() && !Topology::from_links(&[], vec![1.0; 2]).unwrap().is_weakly_connected());
    }

    proptest! {
        #[test]
        fn the_laplacian_of_a_random_graph(seed in 0..u64::MAX, directed in proptest::bool::ANY) {
            let orientation = if directed { Orientation::Directed } else { Orientation::Undirected };
            let random = graph(Family::Random { probability: 0.4, seed, connected: false, orientation }, 9);
            let laplacian = random.laplacian();
            for row in laplacian.row_iter() {
                prop_assert!(row.sum().abs() < 1e-12);
            }
            prop_assert_eq!(laplacian == laplacian.transpose(), random.is_symmetric());
            prop_assert!(directed || random.is_symmetric());
            let spectrum = random.spectrum().unwrap();
            prop_assert!(spectrum.eigenvalues[0].abs() < 1e-9);
            if !directed {
                let connected = random.unreachable_pair().is_none();
                prop_assert_eq!(spectrum.algebraic_connectivity > 1e-9, connected);
                prop_assert!((spectrum.algebraic_connectivity - spectrum.eigenvalues[1]).abs() < 1e-9);
            }
        }
    }
}
