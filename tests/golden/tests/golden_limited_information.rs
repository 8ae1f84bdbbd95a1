//! Golden values of the scenario of chapter 4, variant APFTVT, agent 1. (specification ch4-limited-information, section 12)

use golden::Bench;

struct Golden {
    time: f64,
    position: [f64; 3],
    velocity: [f64; 3],
    input: [f64; 3],
    estimated_position: [f64; 3],
    estimated_velocity: [f64; 3],
    disturbance: [f64; 3],
    reference_velocity: [f64; 3],
    reference_acceleration: [f64; 3],
}

#[rustfmt::skip]
const GOLDEN: &[Golden] = &[
    Golden {
        time: 0.0,
        position: [1.8, 0.1, 0.0],
        velocity: [0.0, 0.0, 0.0],
        input: [98.2620072, -11.5212899, -80.853969],
        estimated_position: [1.5, 0.4, 0.0],
        estimated_velocity: [0.0, 0.0, 0.0],
        disturbance: [0.0, 0.0, 0.0],
        reference_velocity: [0.0, 0.0, 0.0],
        reference_acceleration: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.001,
        position: [1.79999464, 0.100015064, 5.10335868e-06],
        velocity: [-0.0107226424, 0.030127945, 0.0102067848],
        input: [97.2762189, -11.2093591, -80.2930263],
        estimated_position: [1.50358512, 0.396414876, 0.0],
        estimated_velocity: [-0.0071536742, 0.0247382107, 0.00941879728],
        disturbance: [0.00810464009, -0.00810464009, 0.0],
        reference_velocity: [0.0, 0.0, 0.0],
        reference_acceleration: [0.0, 0.0, 0.0],
    },
    Golden {
        time: 0.01,
        position: [1.79947052, 0.101465244, 0.000485102611],
        velocity: [-0.105109433, 0.288401288, 0.0941677514],
        input: [88.9424351, -8.75622554, -75.3756302],
        estimated_position: [1.53425375, 0.366513533, 0.000455060564],
        estimated_velocity: [-0.0700370132, 0.235105512, 0.088068431],
        disturbance: [0.0783958422, -0.0783841663, 0.000104577683],
        reference_velocity: [0.00226444514, 0.0027754255, 0.0],
        reference_acceleration: [0.0112106492, 0.0124187627, 0.0],
    },
    Golden {
        time: 1.0,
        position: [1.21259972, 1.36178875, 0.073333792],
        velocity: [-0.0123722592, 1.21698402, -0.109275387],
        input: [-5.51980139, 7.73468521, -2.88661392],
        estimated_position: [1.21259976, 1.36178872, 0.0733033049],
        estimated_velocity: [-0.0122281362, 1.21642588, -0.116601837],
        disturbance: [1.8978729, 0.817705609, 0.987240663],
        reference_velocity: [0.200737235, 0.292755298, 0.0],
        reference_acceleration: [-0.00558373898, 0.0648744904, 0.0],
    },
    Golden {
        time: 5.0,
        position: [1.89927033, 2.55468093, -0.00197907729],
        velocity: [0.200230131, 0.0210354213, 0.00032358285],
        input: [-1.99797408, 4.11170195, -2.24689563],
        estimated_position: [1.89927036, 2.55468096, -0.00197901804],
        estimated_velocity: [0.200308825, 0.0210577777, 0.000445161074],
        disturbance: [1.1736948, 0.541969987, 0.244214895],
        reference_velocity: [0.199999989, 0.0211762508, 0.0],
        reference_acceleration: [1.62067323e-06, -0.0897788217, 0.0],
    },
    Golden {
        time: 20.0,
        position: [4.90178844, 1.27831684, -0.000558271924],
        velocity: [0.199627523, 0.287872453, 0.000807430506],
        input: [-2.05699349, 2.77245479, -0.257056194],
        estimated_position: [4.90178837, 1.27831684, -0.000558244273],
        estimated_velocity: [0.199488555, 0.287917071, 0.000880577265],
        disturbance: [0.512862774, 0.723447999, -0.709287188],
        reference_velocity: [0.200000036, 0.288063632, 0.0],
        reference_acceleration: [2.01181122e-05, 0.0251227262, 0.0],
    },
    Golden {
        time: 40.0,
        position: [8.90406436, 1.02111505, -0.000613063085],
        velocity: [0.200698443, 0.254145168, -0.00227011917],
        input: [1.71942255, 1.43931799, -3.89668187],
        estimated_position: [8.90406406, 1.02111517, -0.000613055347],
        estimated_velocity: [0.200338023, 0.254361245, -0.00229761949],
        disturbance: [0.905141169, -0.52732734, 1.16841162],
        reference_velocity: [0.200000027, 0.25318027, 0.0],
        reference_acceleration: [1.75666264e-05, 0.0482522634, 0.0],
    },
];

/// Relative tolerances of one moment; an absolute one for each signal where values are small.
struct Tolerance {
    position: f64,
    estimated_velocity: f64,
    input: f64,
    disturbance: f64,
    reference_velocity: f64,
    reference_acceleration: f64,
}

impl Tolerance {
    /// Up to 0.8 s rounding stays rounding. Then x̂ chatters at the size of rounding; from 1.5 s on so does the sign function of the
    /// differentiator, whose flips reach γ3, from there u, and from there the network.
    fn at(time: f64) -> Option<Self> {
        let later = Self {
            position: 1e-4,
            estimated_velocity: 3e-4,
            input: 1e-2,
            disturbance: 3e-3,
            reference_velocity: 1e-5,
            reference_acceleration: 1e-4,
        };
        let one_second = Self {
            position: 1e-6,
            estimated_velocity: 1e-6,
            input: 1e-5,
            disturbance: 1e-5,
            reference_velocity: 1e-6,
            reference_acceleration: 1e-6,
        };
        (time > 0.01).then_some(if time > 1.0 { later } else { one_second })
    }
}

#[test]
fn apftvt_agrees_as_far_as_rounding_allows() {
    let mut bench = Bench::new("limited-information", &[]);
    for golden in GOLDEN {
        bench.run_to(golden.time);
        let tolerance = Tolerance::at(golden.time);
        let expect = |topic: &str, field: &str, values: &[f64; 3], pick: fn(&Tolerance) -> f64| {
            let topic = format!("/agent_1/{topic}");
            match &tolerance {
                None => bench.expect(&topic, field, 0, values, 1e-11),
                Some(tolerance) => bench.expect_within(&topic, field, 0, values, 0.0, pick(tolerance)),
            }
        };
        expect("state", "position", &golden.position, |t| t.position);
        expect("state", "velocity", &golden.velocity, |t| t.position);
        expect("command", "input", &golden.input, |t| t.input);
        expect("estimate", "position", &golden.estimated_position, |t| t.position);
        expect("estimate", "velocity", &golden.estimated_velocity, |t| t.estimated_velocity);
        expect("estimate", "disturbance", &golden.disturbance, |t| t.disturbance);
        expect("estimate", "reference_velocity", &golden.reference_velocity, |t| t.reference_velocity);
        expect("estimate", "reference_acceleration", &golden.reference_acceleration, |t| t.reference_acceleration);
    }
}

#[test]
fn the_first_instant_of_the_graph() {
    let mut bench = Bench::new("limited-information", &["variant=NBOVP"]);
    bench.run_to(0.0);
    let position: Vec<Vec<f64>> = (1..=6).map(|i| bench.signal(&format!("/agent_{i}/state"), "position")).collect();
    for (i, j, golden) in [(1, 6, 1.431782106), (2, 3, 1.711724277), (4, 5, 1.204159458)] {
        let (a, b) = (&position[i - 1], &position[j - 1]);
        let distance = ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt();
        assert!((distance - golden).abs() < 1e-9, "z_{i}{j} = {distance}");
    }
    bench.expect("/agent_1/command", "adjacency", 5, &[1.903708347e-03], 0.0);
    bench.expect("/agent_5/command", "adjacency", 3, &[3.774756447e-02], 0.0);
    bench.expect("/agent_1/command", "force", 0, &[0.0, 0.0], 0.0);
    bench.expect("/agent_1/command", "sliding", 0, &[5.804568900, -1.431741428e+01, -4.709398642], 0.0);
}
