use super::*;

fn gains(choice: GainChoice) -> NeuralPosition {
    NeuralPosition {
        beta1: 2.0 / 3.0,
        alpha1: 8.0,
        alpha2: 8.0,
        n_rbf: 8,
        rbf_shift: 3.0,
        mu: 8.0,
        What0: PerAgent::from(0.0),
        gains: choice,
        eta1_static: 200.0,
        eta2_static: 20.0,
        cv: 1.0,
        eta1_levels: vec![1.0, 5.0, 50.0, 200.0, 10000.0],
        eta2_levels: vec![0.05, 0.25, 5.0, 20.0, 100.0],
        diff_alpha: [6.0, 8.0, 8.0, 6.0],
        diff_beta: 0.1,
    }
}

/// The estimate enters the velocity only after the measurement that formed it, and the weights follow the old φ.
#[test]
fn one_step_uses_old_states_everywhere() {
    let mut observer = NeuralPositionObserver::new(gains(GainChoice::Static), Vector3::zeros(), Vector3::zeros(), 0.1);
    let position = Vector3::repeat(0.008);
    observer.update(&position);
    let phi: Vec<f64> = (1..=8)
        .map(|j| libm::exp(-3.0 * ((0.008 - (j as f64 - 3.0)).powi(2) + (j as f64 - 3.0).powi(2)) / 64.0))
        .collect();
    let estimate = 0.1 * phi.iter().sum::<f64>();
    assert!((observer.estimate - Vector3::repeat(estimate)).norm() < 1e-12);
    observer.advance(&Interval { dt: 0.01, position, acceleration: Vector3::repeat(-1.0) });
    // sig(0.008, 2/3) = 0.04, sig(0.008, 1/3) = 0.2
    assert!((observer.position - Vector3::repeat(0.01 * 0.32)).norm() < 1e-12);
    assert!((observer.velocity - Vector3::repeat(0.01 * (1.6 - 1.0 + estimate))).norm() < 1e-12);
    let leak = 20.0 * 0.04 * 3f64.sqrt();
    let weight = 0.1 + 0.01 * (200.0 * phi[0] * 0.04 - leak * 0.1);
    assert!((observer.network.weights[(0, 0)] - weight).abs() < 1e-12);
}

#[test]
fn the_level_follows_the_error() {
    let mut observer = NeuralPositionObserver::new(gains(GainChoice::Levels), Vector3::zeros(), Vector3::zeros(), 0.0);
    let mut level = |error: f64| {
        observer.update(&Vector3::new(error, 0.0, 0.0));
        observer.level
    };
    assert_eq!([level(2.0), level(0.5), level(0.01), level(1e-4), level(0.0)], [1, 2, 3, 4, 5]);
}

/// A point mass pushed by a slow force: the estimate has to find it from positions.
fn settled_error(choice: GainChoice) -> f64 {
    let mut observer = NeuralPositionObserver::new(gains(choice), Vector3::repeat(0.2), Vector3::zeros(), 0.0);
    let (dt, mut worst): (f64, f64) = (1e-3, 0.0);
    for k in 0..20_000 {
        let t = f64::from(k) * dt;
        let (position, force) = (Vector3::repeat(libm::sin(0.5 * t)), -0.25 * libm::sin(0.5 * t));
        observer.update(&position);
        if t > 15.0 {
            worst = worst.max((observer.estimate - Vector3::repeat(force)).norm());
        }
        observer.advance(&Interval { dt, position, acceleration: Vector3::zeros() });
    }
    worst
}

#[test]
fn a_slow_force_is_found_and_levels_find_it_better() {
    let (fixed, levels) = (settled_error(GainChoice::Static), settled_error(GainChoice::Levels));
    assert!(levels < 0.02 && levels < 0.5 * fixed, "levels {levels}, fixed {fixed}");
}
