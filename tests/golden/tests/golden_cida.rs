//! Golden values of the scenario with input distribution. (specification ch5-cida, section 12)

// The printed digits of an angle that happens to be -π/4.
#![allow(clippy::approx_constant)]

use golden::Bench;

struct Golden {
    time: f64,
    position: [f64; 3],
    input: [f64; 3],
    disturbance: [f64; 3],
    estimated_position: [f64; 3],
    share: f64,
}

/// Agent 1, dt = 1e-3 s, seed 17.
#[rustfmt::skip]
const AOBFC: &[Golden] = &[
    Golden {
        time: 0.0,
        position: [-0.2, -0.7, -0.785398163], input: [0.179126304, 0.0767165062, -0.25],
        disturbance: [0.0, 0.0, 0.0], estimated_position: [0.0, -0.3, -0.628318531], share: 0.00506074648,
    },
    Golden {
        time: 0.001,
        position: [-0.200003113, -0.699624083, -0.785408659], input: [0.18407542, 0.072127994, -0.25],
        disturbance: [-0.00643611079, -0.0128722216, -0.00505490959],
        estimated_position: [-0.00283123125, -0.304872601, -0.631693069], share: 0.00445360561,
    },
    Golden {
        time: 0.01,
        position: [-0.199659036, -0.696095132, -0.785138028], input: [0.239010235, 0.040632657, -0.25],
        disturbance: [-0.0655363807, -0.131679781, -0.0498143906],
        estimated_position: [-0.0266632013, -0.346446333, -0.659047733], share: 0.00183197825,
    },
    Golden {
        time: 1.0,
        position: [-0.0938065549, -0.291334003, -0.809211088], input: [0.241468093, 0.0170316549, -0.25],
        disturbance: [-0.0771122946, -0.154904094, -0.0929918033],
        estimated_position: [-0.0979239055, -0.300288229, -0.810929348], share: 0.00201031908,
    },
    Golden {
        time: 5.0,
        position: [0.102985247, 1.48408506, -0.640284434], input: [0.25, 1.6709956e-05, -0.231657263],
        disturbance: [0.0135924378, 0.0667530599, 0.0180305828],
        estimated_position: [0.103639041, 1.48510049, -0.639133855], share: 0.0245348874,
    },
    Golden {
        time: 20.0,
        position: [1.98103854, 2.01361926, 0.000944413288], input: [-0.198659701, 0.0779155259, 0.111929414],
        disturbance: [0.00627795384, -0.00173412987, 0.0342356551],
        estimated_position: [1.98081651, 2.01367114, 0.000770408646], share: 1.0,
    },
    Golden {
        time: 60.0,
        position: [1.82281453, 2.55743141, -0.00157004505], input: [-0.18369482, 0.0343240044, 0.152091366],
        disturbance: [0.0191771276, -0.00401212996, -0.00395463965],
        estimated_position: [1.82273425, 2.55714802, -0.00135701599], share: 1.0,
    },
];

/// Inputs, differences of terms of order 0.1, carry round-off of 1e-16 that 60 000 steps of a contracting loop do not amplify.
const FLOOR: f64 = 1e-13;

#[test]
fn aobfc_agrees_to_nine_digits() {
    let mut bench = Bench::new("cida", &[]);
    for golden in AOBFC {
        bench.run_to(golden.time);
        bench.expect("/agent_1/state", "position", 0, &golden.position, FLOOR);
        bench.expect("/agent_1/command", "input", 0, &golden.input, FLOOR);
        bench.expect("/agent_1/command", "xi_bar", 0, &[golden.share], FLOOR);
        bench.expect("/agent_1/estimate", "disturbance", 0, &golden.disturbance, FLOOR);
        bench.expect("/agent_1/estimate", "position", 0, &golden.estimated_position, FLOOR);
    }
}
