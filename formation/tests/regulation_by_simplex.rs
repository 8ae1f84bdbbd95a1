//! The regulation of inputs against an independent solver of linear programs.

use formation::math::{SplitMix64, regulate};
use formation::nalgebra::{Matrix3, Vector3};
use formation::vehicle::{Drive, Omni};
use microlp::{ComparisonOp, LinearExpr, OptimizationDirection, Problem};

/// Commands beyond the limits that each test compares.
const INSTANCES: usize = 5000;

/// The optimal value of the same program, by the simplex method.
fn optimum(effect: &Matrix3<f64>, commanded: &Vector3<f64>, limit: f64) -> f64 {
    let demanded = effect * commanded;
    let sign = demanded.map(|value| if value < 0.0 { -1.0 } else { 1.0 });
    let mut problem = Problem::new(OptimizationDirection::Maximize);
    let inputs: Vec<_> = (0..3).map(|k| problem.add_var(sign.dot(&effect.column(k)), (-limit, limit))).collect();
    for j in 0..3 {
        let mut row = LinearExpr::empty();
        for (k, input) in inputs.iter().enumerate() {
            row.add(*input, sign[j] * effect[(j, k)]);
        }
        problem.add_constraint(row.clone(), ComparisonOp::Ge, 0.0);
        problem.add_constraint(row, ComparisonOp::Le, demanded[j].abs());
    }
    let outcome = problem.solve().expect("zero is admissible and the box bounds the rest");
    outcome.solution().expect("no limit of time").objective()
}

fn value(effect: &Matrix3<f64>, commanded: &Vector3<f64>, input: &Vector3<f64>) -> f64 {
    let (demanded, achieved) = (effect * commanded, effect * input);
    (0..3).map(|j| if demanded[j] < 0.0 { -achieved[j] } else { achieved[j] }).sum()
}

/// A vector whose length varies over four decades.
fn random_command(random: &mut SplitMix64) -> Vector3<f64> {
    let size = libm::pow(10.0, 2.0 * random.symmetric());
    Vector3::from_fn(|_, _| size * random.symmetric())
}

fn compare(seed: u64, mut effect: impl FnMut(&mut SplitMix64) -> Matrix3<f64>) {
    let mut random = SplitMix64::new(seed);
    let mut compared = 0;
    while compared < INSTANCES {
        let effect = effect(&mut random);
        let commanded = random_command(&mut random);
        let input = regulate(&effect, &commanded, 1.0);
        if input == commanded {
            continue; // within the limits: there is no program to solve
        }
        let expected = optimum(&effect, &commanded, 1.0);
        let found = value(&effect, &commanded, &input);
        assert!(
            (found - expected).abs() < 1e-9 * expected.max(1.0),
            "instance {compared}: {found}, simplex {expected}"
        );
        compared += 1;
    }
}

#[test]
fn omni_directional_robots() {
    compare(1, |random| {
        let mut between = |low: f64, high: f64| low + 0.5 * (high - low) * (1.0 + random.symmetric());
        let omni = Omni {
            drive: Drive::Force,
            mass: between(1.0, 6.0),
            radius: between(0.1, 0.4),
            inertia: between(0.03, 0.5),
            friction: 0.0,
        };
        omni.matrix(between(-4.0, 4.0))
    });
}

#[test]
fn any_coupling() {
    compare(2, |random| Matrix3::from_fn(|_, _| 2.0 * random.symmetric()));
}

/// Headings and couplings at which edges of the admissible set are orthogonal to the objective.
#[test]
fn couplings_of_small_whole_numbers() {
    compare(3, |random| Matrix3::from_fn(|_, _| (2.5 * random.symmetric()).round()));
}
