use formation::math::{Topology, TopologySchedule};
use formation::scenario::Proximity;
use formation::vehicle::Drive;

use super::*;

fn gains(apf: bool) -> LimitedInformation {
    LimitedInformation { c: 2.0, lam: 2.0, apf, apf_alpha: 2.0, eps1: 1.1, eps2: 2.0 }
}

fn robot() -> Omni {
    Omni { drive: Drive::Force, radius: 0.25, mass: 5.0, inertia: 0.2, friction: 0.0 }
}

fn at(x: f64, y: f64) -> Motion {
    let zero = Vector3::zeros();
    Motion { position: Vector3::new(x, y, 0.3), reference: zero, velocity: zero, reference_velocity: zero }
}

/// Agent 1 of three: receives from agent 3 only, unless others come close.
fn controller(apf: bool, near: bool) -> LimitedInformationController {
    let proximity =
        near.then_some(Proximity { enabled: true, range: 1.5, f_max: 0.2, f_slope: 14.0, f_mid: 1.1, weight: None });
    let topology = TopologySchedule::from(Topology::ring(vec![2.0; 3]));
    let row = AdjacencyRow::new(&topology, proximity, 0);
    let heard = row.heard().len();
    LimitedInformationController::new(gains(apf), robot(), 2.0, row, vec![0.5; heard])
}

/// The accelerations that the wheel forces cause.
fn push(controller: &LimitedInformationController) -> Vector3<f64> {
    robot().matrix(0.3) * controller.input
}

#[test]
fn the_law_by_hand() {
    let mut controller = controller(false, false);
    let own = Motion {
        velocity: Vector3::new(0.5, 0.0, 0.0),
        reference_velocity: Vector3::new(0.2, 0.0, 0.0),
        ..at(1.0, 0.0)
    };
    let estimate = Vector3::new(0.7, -0.4, 0.1);
    controller.update(&own, [at(-1.0, 3.0)], &estimate, &Vector3::new(0.0, 0.05, 0.0));
    // The headings are equal, so they count through the reference only: e_x = (2, -3, 0) + 2 (1, 0, 0.3).
    assert!((controller.error - Vector3::new(4.0, -3.0, 0.6)).norm() < 1e-12);
    assert!((controller.velocity_error - Vector3::new(0.9, 0.0, 0.0)).norm() < 1e-12);
    assert!((controller.sliding - Vector3::new(8.9, -6.0, 1.2)).norm() < 1e-12);
    let expected = Vector3::new(-17.8 - 0.7 - 0.6 - 1.0, 12.0 + 0.4 + 0.05, -2.4 - 0.1 - 0.3);
    assert!((push(&controller) - expected).norm() < 1e-9, "{}", push(&controller));
}

#[test]
fn links_appear_with_the_distance_and_bring_repulsion() {
    let mut controller = controller(true, true);
    let quiet = [Vector3::zeros(), Vector3::zeros()];
    controller.update(&at(0.0, 0.0), [at(2.0, 0.0), at(9.0, 0.0)], &quiet[0], &quiet[1]);
    assert_eq!(controller.row.weights, [0.0, 0.0, 1.0]);
    assert_eq!(controller.force, Vector2::zeros());
    controller.update(&at(0.0, 0.0), [at(0.8, 0.0), at(9.0, 0.0)], &quiet[0], &quiet[1]);
    assert!(controller.row.weights[1] > 0.19);
    // 2 (1 - 0.8) / (0.8 - 0.55)^2, away from the other.
    assert!((controller.force - Vector2::new(-6.4, 0.0)).norm() < 1e-9, "{}", controller.force);
}

#[test]
fn who_is_not_linked_does_not_repel() {
    let mut controller = controller(true, false);
    assert_eq!(controller.row.heard(), [2]);
    controller.update(&at(0.0, 0.0), [at(0.8, 0.0)], &Vector3::zeros(), &Vector3::zeros());
    assert!(controller.force.x < -6.0, "a static neighbour repels");
    let mut silent = self::controller(false, true);
    silent.update(&at(0.0, 0.0), [at(0.8, 0.0), at(0.0, 0.9)], &Vector3::zeros(), &Vector3::zeros());
    assert_eq!(silent.force, Vector2::zeros());
}
