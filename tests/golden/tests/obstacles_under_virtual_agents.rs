//! Ground robots under the hierarchical planner, with obstacles: virtual agents form up, each robot tracks its own one as far as
//! the obstacles allow. The robots give way; the virtual agents, and so the neighbours, do not notice.

use golden::Bench;

const DURATION: f64 = 40.0;
const DT: f64 = 2e-3;
const ROBOTS: usize = 5;

/// Obstacles of the scenario (centre and radius, m), radii of the robots, and the factor of the inner boundary.
const OBSTACLES: [([f64; 2], f64); 2] = [([2.9, 2.0], 0.30), ([1.8, -1.6], 0.25)];
const RADII: [f64; ROBOTS] = [0.24, 0.23, 0.30, 0.28, 0.25];
const EPS1: f64 = 1.1;

fn bench(layer: &[&str], use_rca: bool) -> Bench {
    let rca = format!("use_rca={use_rca}");
    Bench::new("rca", &[&["dt=2e-3", &rca], layer].concat())
}

/// What a run of all robots amounts to.
#[derive(Debug, Default)]
struct Outcome {
    /// Smallest distance to an inner boundary.
    gap: f64,
    /// Largest ‖δx‖ after 5 s of each robot, against what it has to track.
    deviation: [f64; ROBOTS],
    /// Whether the reference of each robot was ever corrected.
    flagged: [bool; ROBOTS],
    /// Where the virtual agents are at the end.
    virtual_positions: Vec<Vec<f64>>,
    /// Largest distance at the end from robot to virtual agent, and from virtual agent to the given reference.
    distances: [f64; 2],
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn run(mut bench: Bench) -> Outcome {
    let mut outcome = Outcome { gap: f64::INFINITY, ..Outcome::default() };
    for k in 0..=(DURATION / DT).round() as u64 {
        let time = k as f64 * DT;
        bench.run_to(time);
        for (i, body) in RADII.iter().enumerate() {
            let (state, reference) = (format!("/agent_{}/state", i + 1), format!("/agent_{}/reference", i + 1));
            let position = bench.signal(&state, "position");
            for (centre, radius) in OBSTACLES {
                outcome.gap = outcome.gap.min(distance(&position[..2], &centre) - EPS1 * (body + radius));
            }
            if time >= 5.0 {
                let deviation = distance(&position, &bench.signal(&reference, "position"));
                outcome.deviation[i] = outcome.deviation[i].max(deviation);
            }
            outcome.flagged[i] |= bench.signal(&reference, "flag")[0] != 0.0;
        }
    }
    for i in 1..=ROBOTS {
        let virtual_position = bench.signal(&format!("/agent_{i}/reference"), "virtual_position");
        let position = bench.signal(&format!("/agent_{i}/state"), "position");
        let desired = bench.signal(&format!("/agent_{i}/reference"), "desired_position");
        let [robot, layer] = outcome.distances;
        outcome.distances =
            [robot.max(distance(&position, &virtual_position)), layer.max(distance(&virtual_position, &desired))];
        outcome.virtual_positions.push(virtual_position);
    }
    outcome
}

fn check(layer: &[&str]) {
    let (with, without) = (run(bench(layer, true)), run(bench(layer, false)));
    for outcome in [&with, &without] {
        assert!(outcome.gap > 0.02, "a robot came too close: {outcome:?}");
        let [robot, layer] = outcome.distances;
        assert!(robot < 1e-2, "a robot lost its virtual agent: {outcome:?}");
        assert!(layer < 1e-2, "the virtual agents did not form up: {outcome:?}");
    }
    assert_eq!(with.flagged, [false, true, true, true, false], "{with:?}");
    assert_eq!(without.flagged, [false; ROBOTS]);
    assert_eq!(with.virtual_positions, without.virtual_positions, "virtual agents know nothing of obstacles");
    for i in [0, 4] {
        let ratio = with.deviation[i] / without.deviation[i];
        assert!(ratio < 0.5, "robot {} follows the others around the obstacle, {ratio}: {with:?}", i + 1);
    }
}

#[test]
fn robots_leave_their_virtual_agents_to_go_around() {
    check(&[
        "planner.source.kind=virtual_agents",
        "planner.source.c_bar=1",
        "planner.source.lam_bar=2",
        "planner.source.feedforward=1",
    ]);
}

#[test]
fn bounded_virtual_agents_do_as_well() {
    check(&[
        "planner.source.kind=saturated_virtual_agents",
        "planner.source.UM=0.4",
        "planner.source.tau_e=0.5",
        "planner.source.psi_e=0.05",
        "planner.source.c_bar=1",
        "planner.source.lam_bar=2",
        "planner.source.k_bar=1.5",
        "planner.source.tau_u=0.39",
        "planner.source.psi_u=0.01",
    ]);
}
