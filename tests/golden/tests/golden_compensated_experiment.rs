//! Golden values of the experiment with emulated robots. (specification ch5-compensated, section 12, emulation)

// The printed digits of an angle that happens to be -π/4.
#![allow(clippy::approx_constant)]

use formation::scenario::{Scenario, Selection};
use golden::Bench;
use plant::Laboratory;
use plant::laboratory::LaboratoryRobot;
use schemes::SCENARIOS;

struct Golden {
    time: f64,
    truth: [f64; 3],
    measured: [f64; 3],
    input: [f64; 3],
    disturbance: [f64; 3],
    estimated: [f64; 3],
}

/// Robot 1, COBFC, 50 Hz, noise_seed 1.
#[rustfmt::skip]
const COBFC: &[Golden] = &[
    Golden {
        time: 0.0,
        truth: [-0.6, 0.3, -0.785398163], measured: [-0.6, 0.3, -0.785398163], input: [0.2, -0.147954483, -0.2],
        disturbance: [0.0, 0.0, 0.0], estimated: [-0.6, 0.3, -0.785398163],
    },
    Golden {
        time: 0.02,
        truth: [-0.5998094, 0.301421092, -0.785482447], measured: [-0.599825102, 0.30052739, -0.784762847],
        input: [0.2, -0.148508623, -0.2], disturbance: [-0.0358121129, -0.0431909769, 0.0467950902],
        estimated: [-0.595348588, 0.305926262, -0.808160392],
    },
    Golden {
        time: 0.2,
        truth: [-0.569862349, 0.352939607, -0.895784856], measured: [-0.571622365, 0.349147809, -0.891296735],
        input: [0.2, 0.000410738147, -0.179258758], disturbance: [-0.0151480371, -0.0232430837, 0.0771278942],
        estimated: [-0.571630984, 0.3501135, -0.907225091],
    },
    Golden {
        time: 1.0,
        truth: [-0.523585596, 0.549428459, -0.740293997], measured: [-0.524065228, 0.547362234, -0.742778582],
        input: [0.0902873074, -0.00611017279, -0.0688210632], disturbance: [-0.0272462922, 0.0736788951, 0.0312459452],
        estimated: [-0.522015593, 0.543757248, -0.752801423],
    },
    Golden {
        time: 5.0,
        truth: [-0.636466208, 0.729946277, -0.0842980146], measured: [-0.6362934, 0.731074912, -0.0847711081],
        input: [-0.0970851867, 0.029570279, 0.0736144581], disturbance: [-0.0344934769, 0.0661686903, 0.0608044759],
        estimated: [-0.635837182, 0.728614982, -0.0917883363],
    },
    Golden {
        time: 18.6,
        truth: [0.379342481, -0.177103885, 0.200094858], measured: [0.48125468, -0.175987466, 0.202682985],
        input: [-0.0806760897, 0.2, -0.2], disturbance: [0.949448446, 0.306818689, 0.0824433484],
        estimated: [0.370246963, -0.220843829, 0.117802035],
    },
    Golden {
        time: 20.0,
        truth: [0.428448808, -0.114969557, 0.0911703616], measured: [0.427709418, -0.115686909, 0.0900545125],
        input: [0.0979907381, -0.0689452482, -0.0291127794], disturbance: [0.0308450602, -0.0644098816, -0.00273164655],
        estimated: [0.425526455, -0.11343288, 0.101163219],
    },
    Golden {
        time: 90.0,
        truth: [0.401549276, -1.69206698, -0.00153099593], measured: [0.39961812, -1.69226908, -0.000766168654],
        input: [0.024175898, -0.136040052, 0.114590361], disturbance: [-0.0536429803, 0.0144301376, -0.0205673823],
        estimated: [0.40246906, -1.6934068, 0.00135535996],
    },
];

/// The specification compares states to 1e-9, in units of the states: nine digits, and never less than that.
const FLOOR: f64 = 1e-9;

#[test]
fn cobfc_agrees_to_nine_digits() {
    let shipped = SCENARIOS.iter().find(|shipped| shipped.name == "compensated-experiment").expect("a scenario");
    let scenario = Scenario::load(shipped.file, shipped.text, &Selection::default()).expect("a valid one");
    let laboratory = Laboratory::of(&scenario).expect("a laboratory");
    let ticks = laboratory.ticks(scenario.context.timing.dt).expect("whole ticks");
    // The log has no true poses; the same commands lead the same robot along the same way.
    let mut robot = LaboratoryRobot::new(&laboratory, &scenario.context, 0);
    let mut bench = Bench::new("compensated-experiment", &[]);
    bench.run_to(0.0);
    let mut step = 0;
    for golden in COBFC {
        let last = (golden.time / 0.02).round() as u64;
        while step < last {
            let input = bench.signal("/agent_1/command", "input");
            robot.command([input[0], input[1], input[2]]);
            (0..ticks).for_each(|_| robot.advance());
            step += 1;
            bench.run_to(step as f64 * 0.02);
        }
        for (j, (value, expected)) in robot.pose().into_iter().zip(golden.truth).enumerate() {
            assert!(
                (value - expected).abs() <= FLOOR,
                "true pose[{j}] at {} s: {value:e}, not {expected:e}",
                golden.time
            );
        }
        bench.expect("/agent_1/state", "position", 0, &golden.measured, FLOOR);
        bench.expect("/agent_1/command", "input", 0, &golden.input, FLOOR);
        bench.expect("/agent_1/estimate", "disturbance", 0, &golden.disturbance, FLOOR);
        bench.expect("/agent_1/estimate", "position", 0, &golden.estimated, FLOOR);
    }
}
