//! Golden values of the cluster of mixed order, agents 1 (order 1) and 3 (order 2). (specification ch7-mixed, section 12)

// Rounded values that happen to be headings of pi/6 and pi/3.
#![allow(clippy::approx_constant)]

use golden::Bench;

/// Values whose size is round-off of larger ones; the decayed headings of the virtual agents are below it.
const FLOOR: f64 = 1e-11;

struct FirstOrder {
    time: f64,
    position: [f64; 3],
    input: [f64; 3],
    network: [f64; 3],
    virtual_position: [f64; 3],
    virtual_velocity: [f64; 3],
    virtual_input: [f64; 3],
}

#[rustfmt::skip]
const AGENT_1: &[FirstOrder] = &[
    FirstOrder {
        time: 0.0, position: [0.8, 2.3, 0.523598776],
        input: [0.0, 0.0, 0.0], network: [0.0, 0.0, 0.0],
        virtual_position: [0.8, 2.3, 0.523598776], virtual_velocity: [0.0, 0.0, 0.0],
        virtual_input: [-5.8, 3.14, -7.85398163],
    },
    FirstOrder {
        time: 0.01, position: [0.800997473, 2.29998718, 0.524030734],
        input: [0.0322717285, -0.00459140007, -0.0479195344], network: [0.00119853685, -0.000158087903, 0.000767691967],
        virtual_position: [0.79971, 2.300157, 0.523206077], virtual_velocity: [-0.058, 0.0314, -0.0785398163],
        virtual_input: [-5.65104638, 2.82346133, -7.1518095],
    },
    FirstOrder {
        time: 0.1, position: [0.783048216, 2.31106529, 0.498290612],
        input: [0.257362912, 0.0396526684, -0.438617769], network: [0.0562156564, -0.0052664214, 0.0320491212],
        virtual_position: [0.773281458, 2.31176933, 0.493073343], virtual_velocity: [-0.506417212, 0.196665196, -0.523925095],
        virtual_input: [-4.10291221, 0.864631342, -2.7570227],
    },
    FirstOrder {
        time: 1.0, position: [-0.0151114116, 2.4200901, 0.0734822971],
        input: [0.0151151673, 0.344626532, -0.417689174], network: [0.0641819575, 0.0120673119, 0.050648588],
        virtual_position: [-0.0138218644, 2.41914294, 0.0747842229], virtual_velocity: [-0.600592012, 0.017000507, -0.183745159],
        virtual_input: [0.800897928, -0.129847084, 0.429459874],
    },
    FirstOrder {
        time: 5.0, position: [-0.762058095, 1.8108026, -0.000170617256],
        input: [-0.211966556, 0.13852184, 0.0820015872], network: [-0.0133792139, 0.0690597284, -0.033901389],
        virtual_position: [-0.762225896, 1.81045733, 2.26604834e-05], virtual_velocity: [-0.0620465639, -0.252469646, -6.04580449e-05],
        virtual_input: [0.0504227717, -0.0322985485, 0.000139005857],
    },
    FirstOrder {
        time: 20.0, position: [3.13495795, 0.0191435254, 0.000113990156],
        input: [0.0590955441, -0.173438712, 0.0829122024], network: [0.0746011742, 0.123443549, 0.12549588],
        virtual_position: [3.13520939, 0.019536375, 0.0], virtual_velocity: [0.29609279, 0.227041954, 0.0],
        virtual_input: [-0.0454475791, 0.0391731236, 0.0],
    },
    FirstOrder {
        time: 50.0, position: [5.8159486, -0.25863066, 5.70073022e-05],
        input: [0.203099426, -0.262455191, 0.0332334072], network: [0.0958437676, -0.154470297, 0.104375417],
        virtual_position: [5.8160376, -0.258607138, 0.0], virtual_velocity: [0.351721511, 0.163207573, 0.0],
        virtual_input: [-0.0326918372, 0.0503116272, 0.0],
    },
];

struct SecondOrder {
    time: f64,
    position: [f64; 3],
    velocity: [f64; 3],
    input: [f64; 3],
    network: [f64; 3],
}

#[rustfmt::skip]
const AGENT_3: &[SecondOrder] = &[
    SecondOrder {
        time: 0.0, position: [-0.6, -1.2, 1.04719755], velocity: [0.0, 0.0, 0.0],
        input: [-15.0635275, -13.1993272, 20.4088731], network: [0.0, 0.0, 0.0],
    },
    SecondOrder {
        time: 0.01, position: [-0.599546784, -1.19976312, 1.04641719], velocity: [0.0906534743, 0.0473662861, -0.156069182],
        input: [-14.1082646, -12.4991356, 19.3898728], network: [-0.00237228514, -0.00099104891, 0.000448318661],
    },
    SecondOrder {
        time: 0.1, position: [-0.561507375, -1.17945013, 0.985330198], velocity: [0.698733308, 0.378221542, -1.07387229],
        input: [-6.89697335, -8.18274722, 12.0332766], network: [-0.156025659, -0.0710104933, 0.0333297123],
    },
    SecondOrder {
        time: 1.0, position: [0.325876939, -0.632181914, 0.142574053], velocity: [0.62851208, 0.385782601, -0.301369548],
        input: [-0.25743195, 2.32899603, -1.85294314], network: [0.352487993, -0.167666499, 0.273421248],
    },
    SecondOrder {
        time: 5.0, position: [1.76182217, 0.189977064, 0.00139764796], velocity: [0.261926391, 0.250407809, -0.000306851414],
        input: [0.770263593, 2.02336907, -3.31536979], network: [1.39752194, -0.40219808, 1.03774368],
    },
    SecondOrder {
        time: 20.0, position: [0.865504023, 1.9792785, -0.00108456902], velocity: [-0.0966343137, -0.227181179, -0.000505013926],
        input: [0.57357326, 1.9742678, -2.26923037], network: [1.19223191, -0.259265541, -0.549778476],
    },
    SecondOrder {
        time: 50.0, position: [4.18421587, 2.2587638, -0.000311583348], velocity: [-0.151831924, -0.163156147, -0.000151059246],
        input: [0.196355817, 2.61853392, -2.64247066], network: [1.45564696, -0.116845602, -0.342675991],
    },
];

#[test]
fn both_orders_agree_to_nine_digits() {
    let mut bench = Bench::new("mixed", &[]);
    for (first, second) in AGENT_1.iter().zip(AGENT_3) {
        bench.run_to(first.time);
        bench.expect("/agent_1/state", "position", 0, &first.position, FLOOR);
        bench.expect("/agent_1/command", "input", 0, &first.input, FLOOR);
        bench.expect("/agent_1/command", "network", 0, &first.network, FLOOR);
        bench.expect("/agent_1/reference", "position", 0, &first.virtual_position, FLOOR);
        bench.expect("/agent_1/reference", "velocity", 0, &first.virtual_velocity, FLOOR);
        bench.expect("/agent_1/reference", "acceleration", 0, &first.virtual_input, FLOOR);
        assert_eq!(first.time, second.time);
        bench.expect("/agent_3/state", "position", 0, &second.position, FLOOR);
        bench.expect("/agent_3/state", "velocity", 0, &second.velocity, FLOOR);
        bench.expect("/agent_3/command", "input", 0, &second.input, FLOOR);
        bench.expect("/agent_3/command", "network", 0, &second.network, FLOOR);
    }
}
