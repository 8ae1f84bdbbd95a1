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
    let mut reaches: Vec<Vec<bool>> = (0..n).map(|i| (0..n).map(|j| i == j || rows[j][i] > 0.0).collect()).collect();
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

fn link(from: usize, to: usize, weight: f64) -> Link {
    Link { from, to, weight }
}

#[test]
fn lists_of_links_may_be_in_any_order() {
    let links = [link(2, 0, 0.5), link(1, 0, 2.0), link(0, 2, 1.0), link(1, 0, 2.0), link(1, 2, 0.0)];
    let graph = Topology::from_links(&links, vec![1.0; 3]).unwrap();
    assert_eq!(matrix(&graph), [[0.0, 2.0, 0.5], [0.0; 3], [1.0, 0.0, 0.0]]);
    assert_eq!(graph.links().collect::<Vec<_>>(), [link(1, 0, 2.0), link(2, 0, 0.5), link(0, 2, 1.0)]);
    assert!(!graph.is_symmetric());
}

#[test]
fn links_that_cannot_be_are_refused_with_their_place() {
    let refuse = |links: &[Link]| {
        let error = Topology::from_links(links, vec![1.0; 3]).unwrap_err();
        format!("{}: {}", error.place, error.message)
    };
    assert_eq!(refuse(&[link(0, 1, 1.0), link(0, 3, 1.0)]), "1: expected agents from 1 to 3, found 4");
    assert_eq!(refuse(&[link(2, 2, 1.0)]), "0: an agent is not its own neighbour, found a link from 3 to 3");
    assert_eq!(refuse(&[link(0, 1, -1.0)]), "0: a weight is a number >= 0, found -1");
    assert!(refuse(&[link(0, 1, f64::NAN)]).contains("found NaN"));
    let twice = "2: the link from 1 to 2 is given twice, with the weights 1 and 2";
    assert_eq!(refuse(&[link(0, 1, 1.0), link(2, 1, 1.0), link(0, 1, 2.0)]), twice);
}

#[test]
fn a_union_has_the_links_of_all() {
    let [one, two] = [[link(0, 1, 1.0), link(1, 2, 0.5)], [link(2, 0, 1.0), link(1, 2, 3.0)]]
        .map(|links| Topology::from_links(&links, vec![0.0; 3]).unwrap());
    let two = two.with_reference(&[0.0, 2.0, 0.0]).unwrap();
    let union = Topology::union([&one, &two]);
    assert_eq!(matrix(&union), [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
    assert_eq!((union.b(0), union.b(1), union.unreachable_pair()), (0.0, 2.0, None));
    assert!(one.with_reference(&[1.0]).unwrap_err().contains("expected 3 weights"));
}
