use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::math::SplitMix64;
use crate::vehicle::{Drive, Omni};

/// The robots of the scenario `lp-regulation`: m in kg, R in m, I in kg m².
const ROBOTS: [[f64; 3]; 6] =
    [[3.0, 0.20, 0.08], [3.2, 0.22, 0.10], [2.8, 0.21, 0.07], [2.6, 0.19, 0.05], [3.1, 0.23, 0.09], [2.9, 0.18, 0.06]];

fn robot(number: usize) -> Omni {
    let [mass, radius, inertia] = ROBOTS[number - 1];
    Omni { drive: Drive::Force, radius, mass, inertia, friction: 0.0 }
}

fn commands() -> impl Strategy<Value = Vector3<f64>> {
    let element = prop_oneof![-80.0..80.0f64, -3.0..3.0f64, -1.0..1.0f64];
    [element.clone(), element.clone(), element].prop_map(Vector3::from)
}

/// Σ_j sign(y_j) g_j·u.
fn objective(effect: &Matrix3<f64>, commanded: &Vector3<f64>, input: &Vector3<f64>) -> f64 {
    let (demanded, achieved) = (effect * commanded, effect * input);
    (0..3).map(|j| if demanded[j] < 0.0 { -achieved[j] } else { achieved[j] }).sum()
}

/// The optimum for robots whose lever mR/I is at least √2: the turning moment first, then the best push in the plane among
/// the intersections of the ten lines that bound it.
fn closed_form(omni: &Omni, heading: f64, commanded: &Vector3<f64>, limit: f64) -> f64 {
    let effect = omni.matrix(heading);
    let demanded = effect * commanded;
    let [turn_effect, scale] = [3.0 * omni.radius / omni.inertia, 2.0 * omni.mass / 3.0];
    let turn = demanded[2].signum() * (demanded[2].abs() / turn_effect).min(limit);
    let sign = [demanded[0].signum(), demanded[1].signum()];
    // Lines n·(p, q) <= bound with p, q >= 0 the parts of the demanded accelerations.
    let mut lines = vec![([1.0, 0.0], demanded[0].abs()), ([-1.0, 0.0], 0.0)];
    lines.extend([([0.0, 1.0], demanded[1].abs()), ([0.0, -1.0], 0.0)]);
    for k in 0..3 {
        let along = [0, 1].map(|axis| scale * omni.mass * effect[(axis, k)] * sign[axis]);
        lines.push((along, limit - turn));
        lines.push((along.map(|value| -value), limit + turn));
    }
    let mut best = f64::NEG_INFINITY;
    for (index, (a, bound_a)) in lines.iter().enumerate() {
        for (b, bound_b) in &lines[..index] {
            let determinant = a[0] * b[1] - a[1] * b[0];
            if determinant.abs() < 1e-12 {
                continue;
            }
            let p = (bound_a * b[1] - bound_b * a[1]) / determinant;
            let q = (a[0] * bound_b - b[0] * bound_a) / determinant;
            if lines.iter().all(|(line, bound)| line[0] * p + line[1] * q <= bound + 1e-9 * bound.max(1.0)) {
                best = best.max(p + q);
            }
        }
    }
    best + turn.abs() * turn_effect
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn within_the_limits_and_never_the_opposite(number in 1..=6usize, heading in -4.0..4.0f64, commanded in commands(), limit in 0.2..3.0f64) {
        let effect = robot(number).matrix(heading);
        let input = regulate(&effect, &commanded, limit);
        prop_assert!(input.amax() <= limit);
        let (demanded, achieved) = (effect * commanded, effect * input);
        for j in 0..3 {
            let part = demanded[j].signum() * achieved[j];
            prop_assert!(part >= -1e-8 * demanded[j].abs().max(1.0), "coordinate {j}: {part}");
            prop_assert!(part <= demanded[j].abs() + 1e-8 * demanded[j].abs().max(1.0), "coordinate {j}: {part}");
        }
    }

    #[test]
    fn commands_within_the_limits_pass(number in 1..=6usize, heading in -4.0..4.0f64, commanded in commands()) {
        let limit = commanded.amax();
        prop_assert_eq!(regulate(&robot(number).matrix(heading), &commanded, limit), commanded);
    }

    #[test]
    fn as_good_as_the_closed_form(number in 1..=6usize, heading in -4.0..4.0f64, commanded in commands(), limit in 0.2..3.0f64) {
        let omni = robot(number);
        let effect = omni.matrix(heading);
        let found = objective(&effect, &commanded, &regulate(&effect, &commanded, limit));
        // A command within the limits is its own optimum, which the closed form finds too.
        let expected = closed_form(&omni, heading, &commanded, limit);
        prop_assert!((found - expected).abs() < 1e-9 * expected.max(1.0), "{found} {expected}");
    }

    #[test]
    fn no_scaled_command_is_better(number in 1..=6usize, heading in -4.0..4.0f64, commanded in commands()) {
        let effect = robot(number).matrix(heading);
        let scaled = commanded / commanded.amax().max(1.0);
        let best = objective(&effect, &commanded, &regulate(&effect, &commanded, 1.0));
        prop_assert!(best >= objective(&effect, &commanded, &scaled) - 1e-9);
    }

    /// Turning everything by 120° renumbers the wheels.
    #[test]
    fn wheels_are_alike(number in 1..=6usize, heading in -4.0..4.0f64, commanded in commands()) {
        let omni = robot(number);
        let value = |heading: f64, commanded: Vector3<f64>| {
            let effect = omni.matrix(heading);
            objective(&effect, &commanded, &regulate(&effect, &commanded, 1.0))
        };
        let third = 2.0 * std::f64::consts::FRAC_PI_3;
        let renumbered = Vector3::new(commanded[1], commanded[2], commanded[0]);
        prop_assert!((value(heading, commanded) - value(heading + third, renumbered)).abs() < 1e-7);
    }
}

struct Case {
    robot: usize,
    heading: f64,
    commanded: [f64; 3],
    regulated: [f64; 3],
    value: f64,
}

#[rustfmt::skip]
const CASES: [Case; 6] = [
    Case { robot: 4, heading: std::f64::consts::FRAC_PI_4, commanded: [-2.58051659e+01, 1.46767445e+01, 8.76093092e+00], regulated: [-1.0, -5.01155469e-01, -8.66335011e-01], value: 9.168483736 },
    Case { robot: 6, heading: std::f64::consts::FRAC_PI_6, commanded: [4.57826643e+01, -2.39660518e+01, -2.39905051e+01], regulated: [-1.73892600e-01, -1.0, -1.0], value: 6.910810109 },
    Case { robot: 5, heading: -0.6558801806, commanded: [-2.34135523e+01, -2.70957240e+01, 5.01846926e+01], regulated: [-3.24583700e-01, -1.0, 1.0], value: 1.632156230 },
    Case { robot: 2, heading: -0.6383258783, commanded: [-1.28940985e+01, 2.59701661e+01, -1.37470195e+01], regulated: [-6.70951900e-01, 1.0, -1.0], value: 2.189842958 },
    Case { robot: 6, heading: 0.0150302019, commanded: [8.64040205e+00, -5.49404307e+00, -2.98876688e+00], regulated: [1.0, -1.0, 1.57592100e-01], value: 1.306273351 },
    Case { robot: 2, heading: -0.1814702625, commanded: [-2.83175074e+00, 1.90420266e+00, 9.91663072e-01], regulated: [-1.0, 1.0, 6.41149920e-02], value: 0.901776483 },
];

/// Commands of the run, among them (the first) one with two optimal vertices.
#[test]
fn commands_of_the_run() {
    for case in &CASES {
        let effect = robot(case.robot).matrix(case.heading);
        let commanded = Vector3::from(case.commanded);
        let regulated = regulate(&effect, &commanded, 1.0);
        assert!((regulated - Vector3::from(case.regulated)).amax() < 1e-9, "robot {}: {regulated}", case.robot);
        let value = objective(&effect, &commanded, &regulated);
        assert!((value - case.value).abs() < 1e-8, "robot {}: {value}", case.robot);
    }
}

/// Couplings of small whole numbers often make an edge or a face of the admissible set optimal.
#[test]
fn of_several_optima_the_nearest_to_the_command() {
    let mut random = SplitMix64::new(5);
    let mut ties = 0;
    for _ in 0..20_000 {
        let effect = Matrix3::from_fn(|_, _| (1.5 * random.symmetric()).round());
        let commanded = Vector3::from_fn(|_, _| 5.0 * random.symmetric());
        let input = regulate(&effect, &commanded, 1.0);
        let program = Program::new(&effect, &commanded, 1.0);
        let mut room = [Vector3::zeros(); VERTICES];
        let best = program.objective.dot(&input);
        let equals = program.vertices(&mut room).iter().filter(|vertex| program.objective.dot(vertex) > best - 1e-9);
        for vertex in equals {
            let farther = (vertex - commanded).norm() - (input - commanded).norm();
            assert!(input == commanded || farther > -1e-6, "{vertex} is nearer to {commanded} than {input}");
            ties += u64::from(input != commanded && (vertex - input).norm() > 1e-3);
        }
    }
    assert!(ties > 1000, "only {ties} other optima");
}

#[test]
fn a_demand_of_zero_stays_zero() {
    let effect = Matrix3::from_rows(&[
        Vector3::new(1.0, 1.0, 1.0).transpose(),
        Vector3::new(1.0, -1.0, 0.0).transpose(),
        Vector3::new(0.0, 1.0, -1.0).transpose(),
    ]);
    let input = regulate(&effect, &Vector3::new(4.0, 4.0, 2.0), 1.0);
    assert!((input.x - input.y).abs() < 1e-12, "{input}");
    assert_eq!(regulate(&effect, &Vector3::new(4.0, 4.0, 4.0), 1.0), Vector3::repeat(1.0));
}

#[test]
fn what_is_not_finite_is_not_hidden() {
    let effect = robot(1).matrix(0.3);
    assert!(regulate(&effect, &Vector3::new(f64::NAN, 0.0, 0.0), 1.0).x.is_nan());
}
