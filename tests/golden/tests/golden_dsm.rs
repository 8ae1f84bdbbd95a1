//! Golden values of the dynamic sliding mode scenarios, agent 1. (specification ch2-dsm, section 12)

// The digits of an angle are those of the golden table, not meant as a constant.
#![allow(clippy::approx_constant)]

use formation::scenario::{Scenario, Selection};
use golden::Bench;
use schemes::SCENARIOS;

struct Golden {
    time: f64,
    position: [f64; 3],
    velocity: [f64; 3],
    input: [f64; 3],
    estimate: [f64; 3],
}

/// Values are printed with nine digits.
const PRINTED: f64 = 5e-9;

#[rustfmt::skip]
const FTDO_DSM: &[Golden] = &[
    Golden {
        time: 0.0,
        position: [2.3, -0.5, 0.785398163], velocity: [0.0, 0.0, 0.0],
        input: [0.0, 0.0, 0.0], estimate: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.001,
        position: [2.3000013, -0.499999276, 0.785398697], velocity: [0.00259444243, 0.00144825147, 0.00106692709],
        input: [0.0, 0.0, 0.0], estimate: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.01,
        position: [2.30013259, -0.499927312, 0.78544382], velocity: [0.0269668521, 0.0146039218, 0.00799428441],
        input: [0.315283607, 0.0743999161, -0.633080941], estimate: [0.0966036531, 0.0792634798, 0.0714615321],
    },
    Golden {
        time: 0.1,
        position: [2.31520286, -0.491743491, 0.782202366], velocity: [0.30538785, 0.174626877, -0.124203509],
        input: [0.891588045, 0.906015762, -3.93872259], estimate: [1.90022605, 1.45099869, 1.34198813],
    },
    Golden {
        time: 1.0,
        position: [2.7775606, 0.0880062687, 0.219415429], velocity: [0.354418731, 0.677968407, -0.464853702],
        input: [-2.43757406, -0.271738373, -1.16503868], estimate: [1.84283521, -0.234967946, 1.98406392],
    },
    Golden {
        time: 5.0,
        position: [2.63279774, 1.43839453, -0.000201782492], velocity: [-0.143788158, 0.263435843, -2.05323019e-05],
        input: [-2.20699508, -0.862425749, -0.999803482], estimate: [2.17970036, 0.847364441, 1.0000018],
    },
    Golden {
        time: 20.0,
        position: [-1.24837472, 2.72787038, -0.000308072828], velocity: [-0.272895304, -0.124736725, -3.70271542e-05],
        input: [-2.37512182, -1.30914423, -1.00014818], estimate: [2.38841652, 1.2821602, 0.999791472],
    },
    Golden {
        time: 60.0,
        position: [2.880497, -0.838278429, -0.00020749653], velocity: [0.0839720516, 0.288175298, 6.32096594e-05],
        input: [-0.971815737, -0.777730818, -0.999013377], estimate: [0.943103778, 0.786620426, 1.00036281],
    },
];

/// The observer chatters chaotically: round-off grows by about ten each second, up to what the residuals are.
#[test]
fn ftdo_dsm_agrees_until_round_off_has_grown() {
    let mut bench = Bench::new("dsm-ftdo", &[]);
    for golden in FTDO_DSM {
        bench.run_to(golden.time);
        let (relative, motion, effort) = match golden.time {
            time if time <= 0.1 => (PRINTED, 1e-10, 1e-10),
            time if time < 2.0 => (0.0, 1e-5, 1e-5),
            _ => (0.0, 1e-3, 8e-3),
        };
        bench.expect_within("/agent_1/state", "position", 0, &golden.position, relative, motion);
        bench.expect_within("/agent_1/state", "velocity", 0, &golden.velocity, relative, motion);
        bench.expect_within("/agent_1/command", "input", 0, &golden.input, relative, effort);
        bench.expect_within("/agent_1/estimate", "disturbance", 0, &golden.estimate, relative, effort);
    }
}

#[rustfmt::skip]
const CNN_DSM: &[Golden] = &[
    Golden {
        time: 0.0,
        position: [2.0, 3.0, 0.0], velocity: [0.0, 0.0, 0.0],
        input: [0.0, 0.0, 0.0], estimate: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.0005,
        position: [2.00000031, 3.00000022, 1.2495683e-07], velocity: [0.00125904757, 0.00089930037, 0.000499741],
        input: [0.0, 0.0, 0.0], estimate: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.005,
        position: [2.00002768, 3.00001702, 1.42728061e-05], velocity: [0.0098696665, 0.00509555074, 0.00627713414],
        input: [-0.317141642, -0.465860496, 0.15083714], estimate: [123.440115, 174.150464, -60.0510387],
    },
    Golden {
        time: 0.1,
        position: [1.98178828, 2.9880494, 0.016336111], velocity: [-0.37835057, -0.295133045, 0.35270672],
        input: [-3.84703724, -3.46628293, 1.08047015], estimate: [-70.2326181, 66.8395209, -0.643206794],
    },
    Golden {
        time: 1.0,
        position: [1.62001277, 2.44937318, 0.562020558], velocity: [-0.255883335, -0.477354668, 0.412467031],
        input: [-3.1196912, -2.25405409, 0.253142687], estimate: [13.9304871, 9.68360009, 2.04167859],
    },
    Golden {
        time: 5.0,
        position: [1.45293138, 1.4514492, 0.790101182], velocity: [-0.0217884627, -0.228092446, 0.00309135045],
        input: [-2.67699941, -2.26678849, 0.216916373], estimate: [7.64078993, 8.09189164, 3.76630471],
    },
    Golden {
        time: 20.0,
        position: [-0.21366557, -2.29090669, 0.784660007], velocity: [-0.144395648, -0.162281407, 0.000807111518],
        input: [-2.59691062, -2.20258863, 0.191654503], estimate: [11.6514613, 11.8489518, 4.63295347],
    },
    Golden {
        time: 60.0,
        position: [1.24173551, 2.71292379, 0.78545141], velocity: [0.0792439465, -0.0684940166, 4.40727426e-05],
        input: [-2.01877023, -1.47825553, 0.142785811], estimate: [7.12950594, 7.18719044, 4.65652263],
    },
];

/// This loop is smooth: it agrees over the whole run to the six digits that the specification asks for.
#[test]
fn cnn_dsm_agrees_throughout() {
    let mut bench = Bench::new("dsm-cnn", &[]);
    for golden in CNN_DSM {
        bench.run_to(golden.time);
        bench.expect_within("/agent_1/state", "position", 0, &golden.position, 1e-6, 1e-14);
        bench.expect_within("/agent_1/state", "velocity", 0, &golden.velocity, 1e-6, 1e-14);
        bench.expect_within("/agent_1/command", "input", 0, &golden.input, 1e-6, 0.0);
        bench.expect_within("/agent_1/command", "network", 0, &golden.estimate, 1e-6, 0.0);
    }
}

/// The laws of this chapter are made for undirected graphs: another number of agents keeps the ring's links both ways.
#[test]
fn another_number_of_agents_stays_undirected() {
    let shipped = SCENARIOS.iter().find(|shipped| shipped.name == "dsm-cnn").expect("a shipped scenario");
    let load = |overrides: &[&str]| {
        let selection =
            Selection { overrides: overrides.iter().map(|o| o.to_string()).collect(), ..Selection::default() };
        Scenario::load(shipped.file, shipped.text, &selection).unwrap_or_else(|p| panic!("{}", p[0])).context
    };
    let five = load(&["x0=[[2,0,0],[0,2,0],[-2,0,0],[0,-2,0],[1,1,0]]"]).topology.first().clone();
    assert_eq!(five.neighbours(0), [1, 4]);
    assert!((0..5).all(|i| (0..5).all(|j| five.a(i, j) == five.a(j, i))));
    let three = load(&["x0=[[2,0,0],[0,2,0],[-2,0,0]]", "A=[[0,1,0],[1,0,1],[0,1,0]]"]).topology.first().clone();
    assert_eq!(three.neighbours(0), [1]);
}

/// Every source of the acceleration drives the loop; the command line's bare `true` is a name here.
#[test]
fn accelerations_may_come_from_anywhere() {
    let error = |overrides: &[&str]| {
        let mut bench = Bench::new("dsm-ftdo", overrides);
        bench.run_to(5.0);
        let wanted = bench.signal("/agent_1/reference", "position");
        let found = bench.signal("/agent_1/state", "position");
        wanted.iter().zip(found).map(|(wanted, found)| (wanted - found).abs()).fold(0.0, f64::max)
    };
    let errors = ["bd", "ftdo", "true"].map(|source| error(&[&format!("accel={source}")]));
    assert!(errors.iter().all(|error| *error < 1e-3), "{errors:?}");
    let alone = error(&["variant=DSM-SW", "accel=true"]);
    assert!(alone < 1e-2, "{alone}");
}
