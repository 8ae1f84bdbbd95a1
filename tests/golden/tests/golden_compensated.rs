//! Golden values of the scenario with the saturation compensator. (specification ch5-compensated, section 12, simulation)

// The printed digits of an angle that happens to be -π/4.
#![allow(clippy::approx_constant)]

use golden::Bench;

struct Golden {
    time: f64,
    position: [f64; 3],
    input: [f64; 3],
    disturbance: [f64; 3],
    estimated_position: [f64; 3],
    auxiliary: [f64; 3],
}

/// Robot 1, dt = 1e-3 s.
#[rustfmt::skip]
const COBFC: &[Golden] = &[
    Golden {
        time: 0.0,
        position: [-0.6, 0.3, -0.785398163], input: [0.2, -0.147954483, -0.2],
        disturbance: [0.0, 0.0, 0.0], estimated_position: [-0.6, 0.3, -0.785398163],
        auxiliary: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.001,
        position: [-0.599767294, 0.300374138, -0.78644573], input: [0.2, -0.146236115, -0.2],
        disturbance: [1.08129143e-06, 0.000622599319, 0.000181089692],
        estimated_position: [-0.599767429, 0.300296313, -0.786536275],
        auxiliary: [0.00173038404, 0.00361862539, 0.00188423967],
    },
    Golden {
        time: 0.01,
        position: [-0.597733101, 0.303750941, -0.79531812], input: [0.2, -0.131838043, -0.2],
        disturbance: [-4.26073814e-06, 0.00606071205, 0.00178505858],
        estimated_position: [-0.597732567, 0.302999769, -0.796198653],
        auxiliary: [0.0165401324, 0.0338852667, 0.0180548925],
    },
    Golden {
        time: 1.0,
        position: [-0.507110538, 0.604983811, -0.722437673], input: [0.0950931115, -0.020619636, -0.0625750407],
        disturbance: [-0.0369603242, 0.0873996579, 0.069982165],
        estimated_position: [-0.504537411, 0.601035119, -0.732805016],
        auxiliary: [0.0942087529, 0.143278601, 0.122448626],
    },
    Golden {
        time: 5.0,
        position: [-0.624594799, 0.734221323, -0.0468427298], input: [-0.109898397, 0.0324521157, 0.0815042031],
        disturbance: [-0.0495274949, 0.0803896266, 0.0754131741],
        estimated_position: [-0.623603568, 0.73144233, -0.0552089221],
        auxiliary: [0.0127433928, 0.019380954, 0.016563333],
    },
    Golden {
        time: 20.0,
        position: [0.440000553, -0.113449837, 0.0074062296], input: [0.113209015, -0.073732727, -0.0435406265],
        disturbance: [0.0424934296, -0.08533034, 0.0296718001],
        estimated_position: [0.43720221, -0.110407158, 0.00507675044],
        auxiliary: [7.03496407e-06, 1.06992162e-05, 9.14375423e-06],
    },
    Golden {
        time: 90.0,
        position: [0.399917669, -1.69221903, -0.00200973164], input: [0.0229248486, -0.143122897, 0.124003051],
        disturbance: [-0.0677374152, 0.0170330082, -0.028316893],
        estimated_position: [0.40334192, -1.69344053, 0.00178364658],
        auxiliary: [4.4e-21, 6.7e-21, 5.7e-21],
    },
];

/// Differences of terms of order 1 carry round-off of 1e-16.
const FLOOR: f64 = 1e-14;

#[test]
fn cobfc_agrees_to_nine_digits() {
    let mut bench = Bench::new("compensated", &[]);
    for golden in COBFC {
        bench.run_to(golden.time);
        bench.expect("/agent_1/state", "position", 0, &golden.position, FLOOR);
        bench.expect("/agent_1/command", "input", 0, &golden.input, FLOOR);
        bench.expect("/agent_1/estimate", "disturbance", 0, &golden.disturbance, FLOOR);
        bench.expect("/agent_1/estimate", "position", 0, &golden.estimated_position, FLOOR);
        // The last row has two digits.
        let digits = if golden.time > 20.0 { 0.02 } else { 1e-8 };
        bench.expect_within("/agent_1/command", "xi", 0, &golden.auxiliary, digits, 0.0);
    }
}

/// The observer is not tied to its scenario: on a vehicle of order 2 it watches the velocities.
#[test]
fn the_adaptive_observer_serves_drones() {
    let gains = ["observer.eta5=64", "observer.eta6=0.5", "observer.ktilde=16", "observer.kind=adaptive"];
    let mut bench = Bench::new("uav", &gains);
    bench.run_to(20.0);
    for agent in 1..=6 {
        let estimate = bench.signal(&format!("/agent_{agent}/estimate"), "disturbance");
        let disturbance = bench.signal(&format!("/agent_{agent}/state"), "disturbance");
        for (j, (estimate, disturbance)) in estimate.iter().zip(disturbance).enumerate() {
            assert!((estimate - disturbance).abs() < 0.03, "agent {agent}, channel {j}: {estimate} {disturbance}");
        }
    }
}
