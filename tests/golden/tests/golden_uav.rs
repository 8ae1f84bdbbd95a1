//! Golden values of the drone scenario, variant TSC and TOC, agent 1. (specification ch7-uav, section 12)

use golden::Bench;

/// Values whose size is round-off of larger ones.
const FLOOR: f64 = 1e-11;

struct Golden {
    time: f64,
    position: [f64; 3],
    angles: [f64; 3],
    velocity: [f64; 3],
    rates: [f64; 3],
    input: [f64; 4],
    disturbance: [f64; 6],
    virtual_position: [f64; 3],
    virtual_velocity: [f64; 3],
    virtual_input: [f64; 3],
    attitude: [f64; 2],
    xi1: [f64; 2],
    xi2: [f64; 2],
}

#[rustfmt::skip]
const TSC: &[Golden] = &[
    Golden {
        time: 0.0,
        position: [4.0, 1.0, 0.0], angles: [0.0, 0.0, 0.0],
        velocity: [0.0, 0.0, 0.0], rates: [0.0, 0.0, 0.0],
        input: [20.8208, 1.03310569, -1.02504533, 0.0],
        disturbance: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        virtual_position: [4.0, 1.0, 0.0], virtual_velocity: [0.0, 0.0, 0.0], virtual_input: [-0.2, -0.2, 0.2],
        attitude: [0.0199733767, -0.0199773619], xi1: [0.0, 0.0], xi2: [0.0, 0.0],
    },
    Golden {
        time: 0.01,
        position: [4.00001502, 1.00002353, 4.18402032e-05], angles: [9.49093424e-06, -1.43306234e-05, -2.11845536e-06],
        velocity: [0.00300722482, 0.00470829863, 0.00837007936], rates: [0.00189887715, -0.0028654312, -0.000423404314],
        input: [20.7673595, 1.12616079, -1.05713433, 0.125845608],
        disturbance: [0.028550544, 0.0447006705, 0.0606657039, -0.00450212098, -0.00467003258, -0.00401985151],
        virtual_position: [3.99999, 0.99999, 1e-05], virtual_velocity: [-0.002, -0.002, 0.002], virtual_input: [-0.2, -0.2, 0.2],
        attitude: [0.0227312406, -0.0220499344], xi1: [0.0, 0.0], xi2: [0.0, 0.0],
    },
    Golden {
        time: 0.1,
        position: [4.00151136, 1.00236039, 0.00385198619], angles: [0.00171230359, -0.0018824569, -0.00017563762],
        velocity: [0.030176514, 0.0471437997, 0.0733847059], rates: [0.0387230565, -0.039707575, -0.00313103285],
        input: [20.3401194, 7.09606174, -6.20083832, 1.02571859],
        disturbance: [0.454754414, 0.705589488, 0.954324425, -0.0654468286, -0.0716023559, -0.0615968249],
        virtual_position: [3.999, 0.999, 0.001], virtual_velocity: [-0.02, -0.02, 0.02], virtual_input: [-0.2, -0.2, 0.2],
        attitude: [0.0499282975, -0.0425152315], xi1: [0.2, -0.183480672], xi2: [0.1, -0.1],
    },
    Golden {
        time: 1.0,
        position: [3.96730214, 1.03446941, 0.191294759], angles: [0.067662186, -0.0824948025, -0.00245806313],
        velocity: [-0.24610156, -0.111182164, 0.273463754], rates: [-0.285703484, 0.193901672, 0.000416490446],
        input: [19.1541834, -1.10617226, -0.664293134, 1.33844832],
        disturbance: [0.411602108, 0.541499679, 0.664458109, 0.00131811519, -0.00182552493, -0.0170425478],
        virtual_position: [3.9, 0.93967881, 0.1], virtual_velocity: [-0.2, -0.0244133778, 0.2], virtual_input: [-0.2, 0.199999987, 0.2],
        attitude: [0.00342642282, -0.0465794267], xi1: [-0.2, 0.112838968], xi2: [0.0, -0.1],
    },
    Golden {
        time: 5.0,
        position: [2.40304737, 1.30838566, 1.26150701], angles: [0.0836182082, -0.0325419518, -1.9472002e-06],
        velocity: [-0.123959792, 0.152869429, 0.13386955], rates: [0.00329066488, -0.0582073295, -4.18477125e-06],
        input: [18.6708607, -0.331778289, 0.250512233, -2.7577412],
        disturbance: [0.536609315, 0.797709126, 0.878898107, 0.092147299, 0.0569417157, 0.0563067415],
        virtual_position: [2.41111381, 1.30779366, 1.26215802], virtual_velocity: [-0.146266682, 0.152811784, 0.133294244], virtual_input: [0.2, 0.0461784634, 0.007564199],
        attitude: [0.0842089828, -0.0421923092], xi1: [0.00304947789, -0.0363184641], xi2: [0.00953199652, 0.1],
    },
    Golden {
        time: 20.0,
        position: [-0.0812042453, 3.08287971, 3.49999982], angles: [-0.0725084608, -0.0140880789, -3.4180626e-07],
        velocity: [-0.240059671, -0.0569255208, 0.149999407], rates: [-0.00221280579, -0.0161346352, 2.53600636e-07],
        input: [22.3344158, -0.125425011, 0.323330387, -2.36370472],
        disturbance: [0.144283012, -0.796790529, -0.898419456, -0.00549150093, -0.0741552327, 0.0482221564],
        virtual_position: [-0.0811700287, 3.08266447, 3.5], virtual_velocity: [-0.240002744, -0.0567853618, 0.15], virtual_input: [-0.00662380485, -0.0163785112, -5.7359395e-12],
        attitude: [-0.0726746792, -0.0140509869], xi1: [-0.00432594733, -0.0161315123], xi2: [-0.0199166339, 0.000998516047],
    },
    Golden {
        time: 80.0,
        position: [2.97985754, 0.349828123, 12.5000007], angles: [-0.0598601702, 0.030550595, -1.33617173e-07],
        velocity: [-0.0280523733, 0.238389273, 0.149999084], rates: [-0.00851395035, -0.0141347469, 1.73558539e-07],
        input: [22.1061413, -0.408623518, 0.0698995634, 0.582354161],
        disturbance: [-0.343148526, -0.638071752, -0.793966805, 0.097874716, -0.0196795752, -0.0118794628],
        virtual_position: [2.97955481, 0.34964888, 12.5], virtual_velocity: [-0.0279719119, 0.238364398, 0.15], virtual_input: [-0.0190682547, -0.00224538037, -3.55271368e-15],
        attitude: [-0.0597514927, 0.0304118523], xi1: [-0.0086076693, -0.0139622677], xi2: [0.00233224356, -0.00270205968],
    },
];

/// The yaw channel holds round-off of the others from about 5 s on.
const YAW_FLOOR: f64 = 1e-9;

#[test]
fn tsc_agrees_to_nine_digits() {
    let mut bench = Bench::new("uav", &[]);
    for golden in TSC {
        bench.run_to(golden.time);
        // Behind 20 s the round-off of torques of some newtons has grown to the ninth digit.
        let digits = if golden.time > 20.0 { 1e-6 } else { 1e-8 };
        let state = "/agent_1/state";
        bench.expect_within(state, "position", 0, &golden.position, digits, FLOOR);
        bench.expect_within(state, "position", 3, &golden.angles[..2], digits, FLOOR);
        bench.expect_within(state, "position", 5, &golden.angles[2..], digits, YAW_FLOOR);
        bench.expect_within(state, "velocity", 0, &golden.velocity, digits, FLOOR);
        bench.expect_within(state, "velocity", 3, &golden.rates[..2], digits, FLOOR);
        bench.expect_within(state, "velocity", 5, &golden.rates[2..], digits, YAW_FLOOR);
        let reference = "/agent_1/reference";
        bench.expect(reference, "position", 0, &golden.virtual_position, FLOOR);
        bench.expect(reference, "velocity", 0, &golden.virtual_velocity, FLOOR);
        bench.expect(reference, "acceleration", 0, &golden.virtual_input, FLOOR);
        bench.expect_within("/agent_1/estimate", "disturbance", 0, &golden.disturbance, digits, FLOOR);
        let command = "/agent_1/command";
        bench.expect_within(command, "input", 0, &golden.input, digits, 1e-9);
        bench.expect_within(command, "attitude_reference", 0, &golden.attitude, digits, FLOOR);
        bench.expect_within(command, "xi1", 0, &golden.xi1, digits, FLOOR);
        bench.expect_within(command, "xi2", 0, &golden.xi2, digits, 1e-9);
    }
}

struct Short {
    time: f64,
    position: [f64; 3],
    angles: [f64; 3],
    input: [f64; 4],
    disturbance: [f64; 6],
}

#[rustfmt::skip]
const TOC: &[Short] = &[
    Short {
        time: 1.0,
        position: [3.96690345, 1.01532619, 0.0994118906], angles: [0.0857084171, -0.102290498, 1.78087187e-05],
        input: [19.5816495, -1.82748705, 0.17833955, 0.886219355],
        disturbance: [0.411104239, 0.540761085, 0.674103098, -0.0148044874, 0.0228990692, -0.0172991809],
    },
    Short {
        time: 5.0,
        position: [2.40957914, 1.30761199, 1.2620565], angles: [0.0840804487, -0.0387866911, -1.7376424e-06],
        input: [18.6741471, -0.410982241, -0.279683412, -2.75864203],
        disturbance: [0.540617583, 0.797659746, 0.878992014, 0.0917672947, 0.0551894625, 0.0562958337],
    },
    Short {
        time: 20.0,
        position: [-0.0811747274, 3.08267288, 3.49999984], angles: [-0.0726900038, -0.0140890497, -3.41900652e-07],
        input: [22.3347414, -0.250413803, 0.322279473, -2.36371608],
        disturbance: [0.144281887, -0.796671923, -0.898434814, -0.00579927099, -0.0741556221, 0.0482224235],
    },
];

#[test]
fn toc_agrees_to_nine_digits() {
    let mut bench = Bench::new("uav", &["variant=TOC"]);
    for golden in TOC {
        bench.run_to(golden.time);
        bench.expect("/agent_1/state", "position", 0, &golden.position, FLOOR);
        bench.expect("/agent_1/state", "position", 3, &golden.angles[..2], FLOOR);
        bench.expect("/agent_1/state", "position", 5, &golden.angles[2..], YAW_FLOOR);
        bench.expect("/agent_1/command", "input", 0, &golden.input, 1e-7);
        bench.expect("/agent_1/estimate", "disturbance", 0, &golden.disturbance, 1e-9);
    }
}
