use super::*;
use proptest::prelude::*;

fn gains() -> HierarchicalUav {
    HierarchicalUav {
        lam_p: 1.5,
        c_p: 2.5,
        k_p: 0.7,
        lam_a: 3.0,
        c_a: 4.0,
        k_a: 1.3,
        psi_d: 0.4,
        xi1_max: 1.0,
        xi2_max: 1.0,
        intro: Introduction::None,
        gamma1: 2.0,
        gamma2: 3.0,
        diff: Differentiation::Slope,
        n_diff: 1,
        position_every: 1,
    }
}

fn controller(gains: HierarchicalUav) -> HierarchicalUavController {
    let vehicle = Quadcopter { mass: 1.2, arm: 0.2, inertia: [0.5, 0.6, 0.8], drag: 0.1, torque_factor: 0.3 };
    HierarchicalUavController::new(gains, vehicle)
}

fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-limit..limit).prop_map(Vector3::from)
}

fn stack(first: &Vector3<f64>, second: &Vector3<f64>) -> Vector6<f64> {
    Vector6::from_fn(|row, _| if row < 3 { first[row] } else { second[row - 3] })
}

/// The derivative of V = (s² + k e²) / 2, and what it has to be: -c s² - k λ e².
fn decays(
    acceleration: Vector3<f64>,
    [slope, gain, spring]: [f64; 3],
    error: Vector3<f64>,
    rate: Vector3<f64>,
) -> bool {
    let sliding = rate + slope * error;
    let change = sliding.dot(&(acceleration + slope * rate)) + spring * error.dot(&rate);
    let expected = -gain * sliding.norm_squared() - spring * slope * error.norm_squared();
    (change - expected).abs() <= 1e-9 * (1.0 + expected.abs())
}

proptest! {
    #[test]
    fn errors_of_the_position_loop_decay(
        error in vector(5.0), rate in vector(5.0), wind in vector(5.0), place in vector(9.0), speed in vector(9.0), push in vector(3.0),
    ) {
        let mut law = controller(gains());
        let reference = UavReference { position: place, velocity: speed, acceleration: push };
        let zero = Vector3::zeros();
        let demanded = law.position_loop(
            &stack(&(place + error), &zero), &stack(&(speed + rate), &zero), &reference, &stack(&wind, &zero),
        );
        // Gravity and the disturbance act on the vehicle besides.
        let acceleration = demanded + wind - Vector3::new(0.0, 0.0, GRAVITY) - push;
        prop_assert!(decays(acceleration, [1.5, 2.5, 0.7], error, rate));
        prop_assert!((law.sliding_position - rate - 1.5 * error).norm() < 1e-9);
    }

    #[test]
    fn errors_of_the_attitude_loop_decay(
        error in vector(1.0), rate in vector(2.0), torque in vector(3.0), turn in vector(0.5), spin in vector(1.0), swing in vector(1.0),
    ) {
        let mut law = controller(gains());
        (law.attitude_reference, law.attitude_rate, law.attitude_acceleration) = (turn, spin, swing);
        let zero = Vector3::zeros();
        let demanded =
            law.attitude_loop(&stack(&zero, &(turn + error)), &stack(&zero, &(spin + rate)), &stack(&zero, &torque));
        prop_assert!(decays(demanded + torque - swing, [3.0, 4.0, 1.3], error, rate));
        prop_assert!((law.sliding_attitude - rate - 3.0 * error).norm() < 1e-9);
    }

    #[test]
    fn the_thrust_points_along_the_acceleration_that_is_asked_for(sideways in vector(5.0), up in 1.0..20.0f64, yaw in -3.0..3.0f64) {
        let mut law = controller(HierarchicalUav { psi_d: yaw, ..gains() });
        law.push = Vector3::new(sideways.x, sideways.y, up);
        law.guide();
        let (roll, pitch, yaw) = (law.attitude_reference.x, law.attitude_reference.y, law.attitude_reference.z);
        let (sin, cos) = (libm::sin, libm::cos);
        // The third axis of the body, turned by yaw, pitch and roll.
        let axis = Vector3::new(
            cos(roll) * sin(pitch) * cos(yaw) + sin(roll) * sin(yaw),
            cos(roll) * sin(pitch) * sin(yaw) - sin(roll) * cos(yaw),
            cos(roll) * cos(pitch),
        );
        prop_assert!((law.push.norm() * axis - law.push).norm() < 1e-9);
    }
}

#[test]
fn a_drone_at_its_place_carries_its_weight_and_does_not_turn() {
    let mut law = controller(HierarchicalUav { psi_d: 0.0, ..gains() });
    let (zero, still) = (Vector3::zeros(), Vector6::zeros());
    let reference = UavReference { position: zero, velocity: zero, acceleration: zero };
    law.update(&Step { index: 0, dt: 0.01 }, &still, &still, &reference, &still);
    assert_eq!(law.input, [1.2 * GRAVITY, 0.0, 0.0, 0.0]);
}

#[test]
fn inputs_are_what_the_body_needs_at_its_attitude() {
    let mut law = controller(HierarchicalUav { psi_d: 0.0, position_every: 2, ..gains() });
    let (zero, still) = (Vector3::zeros(), Vector6::zeros());
    let reference = UavReference { position: zero, velocity: zero, acceleration: zero };
    // The position loop does not run at this step: the push stays.
    law.push = Vector3::new(0.0, 0.0, 6.0);
    let turned = stack(&Vector3::x(), &Vector3::new(0.3, -0.2, 0.1));
    law.update(&Step { index: 1, dt: 0.01 }, &turned, &still, &reference, &still);
    let [thrust, roll, pitch, yaw] = law.input;
    assert!((thrust * libm::cos(0.3) * libm::cos(0.2) - 1.2 * 6.0).abs() < 1e-12);
    // -k_a - c_a λ_a for each radian; arm / Jx, arm / Jy, υ / Jz per newton.
    let stiffness = 1.3 + 4.0 * 3.0;
    for (torque, expected) in [
        (roll, -0.3 * stiffness * 0.5 / 0.2),
        (pitch, 0.2 * stiffness * 0.6 / 0.2),
        (yaw, -0.1 * stiffness * 0.8 / 0.3),
    ] {
        assert!((torque - expected).abs() < 1e-9, "{torque} instead of {expected}");
    }
}

#[test]
fn the_estimate_is_faded_in_around_its_middle() {
    let fade = |intro, time| controller(HierarchicalUav { intro, ..gains() }).introduction(time);
    assert_eq!([0.0, 3.0, 9.0].map(|time| fade(Introduction::None, time)), [1.0; 3]);
    assert_eq!(fade(Introduction::Logistic, 3.0), 0.5);
    assert!((fade(Introduction::Logistic, 4.0) - 1.0 / (1.0 + libm::exp(-2.0))).abs() < 1e-15);
    assert!(fade(Introduction::Logistic, 0.0) < 0.01 && fade(Introduction::Logistic, 6.0) > 0.99);
    assert_eq!(fade(Introduction::Printed, 3.0), 0.0);
    assert!(fade(Introduction::Printed, 0.0) < -0.99 && fade(Introduction::Printed, 6.0) > 0.99);
}
