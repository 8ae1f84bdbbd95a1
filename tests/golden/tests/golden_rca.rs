//! Golden values of the scenario with reference correction, variant RCABSMC, agent 1. (specification ch3-rca, section 12)

use golden::Bench;

/// States and estimates agree to this, at all times: signs switch in the observer, and its small chatter depends on round-off.
const STATES: f64 = 1e-6;

/// The inputs are the mass, 5 kg, times these.
const INPUTS: f64 = 1e-5;

struct Golden {
    time: f64,
    position: [f64; 3],
    velocity: [f64; 3],
    input: [f64; 3],
    mismatched: [f64; 3],
    disturbance: [f64; 3],
}

#[rustfmt::skip]
const RCABSMC: &[Golden] = &[
    Golden {
        time: 0.0,
        position: [0.0, 0.8, std::f64::consts::FRAC_PI_6], velocity: [0.0, 0.0, 0.0],
        input: [29.511685, -40.4293056, 11.2448698],
        mismatched: [0.0, 0.0, 0.0], disturbance: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.001,
        position: [0.000379373155, 0.800277977, 0.523872949], velocity: [0.00583202389, 0.0146392818, 0.00181765317],
        input: [29.1629062, -40.037652, 11.164467],
        mismatched: [0.0, 0.0, 0.0], disturbance: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.01,
        position: [0.00406133222, 0.803412987, 0.52641707], velocity: [0.0563751101, 0.139745714, 0.0147238281],
        input: [25.8624877, -35.6600692, 9.62257223],
        mismatched: [0.0132806956, 0.0119344101, 0.011887451], disturbance: [0.163391579, 0.155006214, 0.132696508],
    },
    Golden {
        time: 0.1,
        position: [0.0586228997, 0.876540961, 0.548362725], velocity: [0.298454304, 0.795415587, -0.159879118],
        input: [3.83066193, 1.05352288, -8.00567262],
        mismatched: [0.269484432, 0.231112887, 0.23320413], disturbance: [2.73515379, 2.48730217, 1.53250622],
    },
    Golden {
        time: 1.0,
        position: [0.522765107, 1.62872422, 0.168125418], velocity: [-0.164770366, 0.359902445, -0.597475385],
        input: [-4.86360759, 10.4056811, -6.04591866],
        mismatched: [0.499391007, 0.134178531, 0.256199561], disturbance: [2.37775395, 1.55752601, 1.49465191],
    },
    Golden {
        time: 5.0,
        position: [1.21421122, 2.42374748, -7.8211226e-05], velocity: [0.13242525, -0.135693848, -0.239320165],
        input: [-2.86156409, 8.67708721, -6.2391532],
        mismatched: [0.0172878636, 0.158098222, 0.238447502], disturbance: [2.45452393, 0.901085719, 0.501051035],
    },
    Golden {
        time: 20.0,
        position: [3.44062459, 1.15790449, 0.000465441176], velocity: [-0.330728902, 0.0203345776, -0.0830820077],
        input: [-4.84759501, 6.65897262, -2.33997834],
        mismatched: [0.493611089, 0.280766168, 0.0829606679], disturbance: [1.7058605, 1.37605961, 0.601353874],
    },
    Golden {
        time: 40.0,
        position: [6.46294498, 0.890615996, 0.000527382134], velocity: [-0.112813712, 0.0989275106, 0.0878005598],
        input: [-4.25158126, 5.15078509, -1.86819865],
        mismatched: [0.263307187, 0.154214532, -0.0877516433], disturbance: [1.55419337, 1.14446473, 1.4689908],
    },
];

#[test]
fn rcabsmc_agrees_to_six_decimals() {
    let mut bench = Bench::new("rca", &[]);
    for golden in RCABSMC {
        bench.run_to(golden.time);
        let expect = |topic, field, values, tolerance| bench.expect_within(topic, field, 0, values, 0.0, tolerance);
        expect("/agent_1/state", "position", &golden.position, STATES);
        expect("/agent_1/state", "velocity", &golden.velocity, STATES);
        expect("/agent_1/estimate", "mismatched", &golden.mismatched, STATES);
        expect("/agent_1/estimate", "disturbance", &golden.disturbance, STATES);
        expect("/agent_1/command", "input", &golden.input, INPUTS);
    }
}
