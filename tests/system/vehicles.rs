//! Vehicles by equations: the library against an independent integration, systems of users, mistakes.

use std::process::Command;

use crate::program::Folder;

/// The vehicles of the library with what the row of an agent says, and the law of each input.
const LIBRARY: &[(&str, &str, &str)] = &[
    ("single_integrator_1d", "x = 1", "ux = \"sin(t)\""),
    ("single_integrator_2d", "x = 1, y = 0", "ux = \"sin(t)\"\nuy = \"cos(2*t)\""),
    ("single_integrator_3d", "x = 1, y = 0, z = 2", "ux = \"sin(t)\"\nuy = \"cos(2*t)\"\nuz = \"0.1*t\""),
    ("double_integrator_1d", "x = 1, vx = 0.2", "ux = \"sin(t)\""),
    ("double_integrator_2d", "x = 1, y = 0", "ux = \"sin(t)\"\nuy = \"cos(2*t)\""),
    ("double_integrator_3d", "x = 1, y = 0, z = 2", "ux = \"sin(t)\"\nuy = \"cos(2*t)\"\nuz = \"0.1*t\""),
    ("unicycle", "x = 1, y = 0, theta = 0.4", "v = \"1 + 0.5*sin(t)\"\nomega = \"cos(0.7*t)\""),
    ("bicycle", "x = 1, y = 0", "v = \"3 + sin(t)\"\nsteering = \"0.8*sin(t)\""),
    ("dubins_aeroplane", "x = 1, y = 0, z = 100", "climb = \"3*sin(t)\"\nturn = \"0.7*cos(t)\""),
    ("surface_vessel", "x = 1, y = 0", "surge = \"2 + sin(t)\"\nsway = \"cos(t)\"\nyaw = \"0.5*sin(2*t)\""),
    (
        "quadrotor",
        "x = 0, y = 0, z = 1",
        "f1 = \"1.3 + 0.05*sin(3*t)\"\nf2 = \"1.3 + 0.04*sin(2*t)\"\nf3 = \"1.25 + 0.05*sin(2.5*t)\"\nf4 = \"1.2\"",
    ),
    (
        "crazyflie",
        "x = 0, y = 0, z = 1",
        "f1 = \"0.07 + 1e-3*sin(9*t)\"\nf2 = \"0.07 + 1e-3*sin(8*t)\"\nf3 = \"0.07 - 1e-3*sin(7*t)\"\nf4 = \"0.0701\"",
    ),
    ("spacecraft", "wx = 0.3, wy = 0.1", "tx = \"0.1*sin(t)\"\nty = \"0.2*cos(t)\"\ntz = \"0.05\""),
    ("two_link_arm", "q1 = -1, q2 = 0.4", "tau1 = \"2*sin(t)\"\ntau2 = \"cos(3*t)\""),
];

fn succeeds(folder: &Folder, arguments: &[&str]) -> String {
    let run = folder.run(arguments);
    assert_eq!(run.code(), 0, "{arguments:?}\n{}{}", run.stdout(), run.stderr());
    run.stdout()
}

#[test]
fn the_library_agrees_with_an_independent_integration() {
    let Some(python) = std::env::var_os("PHALANX_PYTHON") else {
        eprintln!("skipped: PHALANX_PYTHON does not name a Python with tests/python/requirements.txt");
        return;
    };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/python/vehicles.py");
    let folder = Folder::new();
    for (name, row, law) in LIBRARY {
        let text = format!(
            "name = \"one\"\nagents = [{{ {row} }}]\ntiming = {{ dt = 0.01, duration = 4 }}\nvehicle.kind = \"{name}\"\n\
             topology.b = 1\nplant = {{ kind = \"vehicles\", integrator = \"dopri5\", substeps = 4 }}\n\
             [controller]\nkind = \"formulas\"\n[controller.law]\n{law}\n"
        );
        folder.write("one.toml", &text);
        succeeds(&folder, &["run", "one.toml", "--placement", "single", "-q", "--out", "one.mcap"]);
        succeeds(&folder, &["export", "one.mcap", "--format", "npz"]);
        let output =
            Command::new(&python).arg(script).arg(name).arg(folder.path("one.npz")).output().expect("Python runs");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
        print!("{text}");
    }
}

/// The systems of `examples/own-systems`, with the assertions that they hold.
const OWN: &[(&str, &str)] = &[
    ("oscillators", include_str!("../../examples/own-systems/oscillators.toml")),
    ("pentagon", include_str!("../../examples/own-systems/pentagon.toml")),
    ("unicycles", include_str!("../../examples/own-systems/unicycles.toml")),
    ("pendulum", include_str!("../../examples/own-systems/pendulum.toml")),
    ("attitude", include_str!("../../examples/own-systems/attitude.toml")),
    ("drone-and-robots", include_str!("../../examples/own-systems/drone-and-robots.toml")),
];

#[test]
fn systems_of_users_have_the_same_samples_in_every_placement() {
    let folder = Folder::new();
    for (name, text) in OWN {
        let file = format!("{name}.toml");
        folder.write(&file, text);
        let samples = ["single", "agents", "processes"].map(|placement| {
            let log = format!("{name}-{placement}.mcap");
            succeeds(&folder, &["run", &file, "--placement", placement, "-q", "--strict", "--out", &log]);
            folder.samples(&log)
        });
        assert!(samples.iter().all(|other| *other == samples[0]), "{name}");
        let log = format!("{name}-single.mcap");
        let equal = succeeds(&folder, &["replay", &log, "--only", "plant"]);
        assert!(equal.starts_with("equal: plant gives all"), "{name}: {equal}");
        succeeds(&folder, &["report", &log]);
    }
}

/// The last value of a signal.
fn last(folder: &Folder, log: &str, topic: &str, field: &str) -> Vec<f64> {
    let log = recording::Log::open(&folder.path(log)).unwrap_or_else(|error| panic!("{error}"));
    let signal = log.signal(topic, field).unwrap_or_else(|| panic!("no {field} on {topic}"));
    signal.rows().last().expect("it has samples").to_vec()
}

#[test]
fn two_oscillators_lock_or_slip_as_adler_says() {
    let folder = Folder::new();
    folder.write("oscillators.toml", OWN[0].1);
    succeeds(&folder, &["run", "oscillators.toml", "-q", "--placement", "single", "--out", "a.mcap"]);
    let difference = last(&folder, "a.mcap", "/agent_1/command", "difference")[0];
    // Locked: sin(difference) = 1/K; the second one is ahead, by whole turns more or less.
    let locked = std::f64::consts::FRAC_PI_6;
    assert!((difference - locked).abs() < 1e-4, "{difference}");
    let slow = [
        "run",
        "oscillators.toml",
        "-q",
        "--placement",
        "single",
        "--set",
        "K=0.5",
        "--set",
        "duration=72.56",
        "--out",
        "b.mcap",
    ];
    succeeds(&folder, &slow);
    // From 2 rad on, after 10 periods of 7.255197 s, the difference has grown by 10 turns.
    let difference = last(&folder, "b.mcap", "/agent_1/command", "difference")[0];
    let turns = (difference - 2.0) / std::f64::consts::TAU;
    assert!((turns - 10.0).abs() < 0.01, "{turns}");
}

#[test]
fn mistakes_in_a_vehicle_are_located() {
    let text = OWN[2].1;
    let folder = Folder::new();
    let rows: &[(&str, &str, &[&str])] = &[
        (
            "kind = \"unicycle\"",
            "kind = \"unicicle\"",
            &["vehicle.kind: no vehicle is called `unicicle`", "did you mean `unicycle`"],
        ),
        (
            "d.theta = \"(right - left)/track\"",
            "d.thetta = \"0\"",
            &["vehicle.d.thetta: no state is called `thetta`", "did you mean `theta`"],
        ),
        (
            "(left + right)/2*cos(theta)\"",
            "(left + right)/2*cos(thetta)\"",
            &["vehicle.d.x: expected a known name, found 'thetta'", "did you mean `theta`"],
        ),
        (
            "y = 0.5, theta",
            "z = 0.5, theta",
            &["agents.2.z: unknown field of the vehicle `unicycle`", "agents.2.y: missing: the state `y` at t = 0"],
        ),
        (
            "law.v = ",
            "law.speed = ",
            &[
                "controller.law: expected a formula for each input of the vehicle `unicycle`; missing: v",
                "controller.law.speed: the vehicle `unicycle` has no input of this name, expected one of v, omega",
            ],
        ),
        ("law.omega = \"(cos", "law.omega = \"(cas", &["controller.law.omega: expected one of the functions"]),
        ("(x_j + ahead", "(xx_j + ahead", &["controller.define.ex: expected a known name, found 'xx_j'"]),
        (
            "reference.velocity[0] - k",
            "reference.velocity[2] - k",
            &["controller.define.px: expected a number from 0 to 1, found '2'"],
        ),
        (
            "reference.velocity[0] - k",
            "reference.speed - k",
            &["controller.define.px: expected a signal of the planner, one of position (2)"],
        ),
        ("angles", "position = [\"x\", \"y\", \"theta\", \"v\"]\nangles", &[]),
        ("track = 0.3", "track = 0", &["vehicle.d.theta: its value is NaN at t = 0 for agent 1"]),
        (
            "v_max = 0.8",
            "t = 0.8",
            &["vehicle.parameters.t: `t` stands for something else in formulas: expected another name"],
        ),
        (
            "outputs.wheels = ",
            "outputs.theta = ",
            &["vehicle.outputs.theta: `theta` stands for something else in this vehicle already"],
        ),
    ];
    for (from, to, expected) in rows.iter().filter(|(.., expected)| !expected.is_empty()) {
        assert!(text.contains(from), "the scenario no longer holds {from:?}");
        folder.write("bad.toml", &text.replacen(from, to, 1));
        let run = folder.run(&["validate", "bad.toml"]);
        assert_eq!(run.code(), 2, "{to}: {}{}", run.stdout(), run.stderr());
        for part in *expected {
            assert!(run.stderr().contains(part), "missing {part:?} in\n{}", run.stderr());
        }
        assert!(!run.stderr().contains("panicked"), "{}", run.stderr());
    }
}

#[test]
fn equations_read_tables_which_are_in_the_log() {
    let folder = Folder::new();
    folder.write("wind.csv", "t,vx\n0,0\n1,2\n2,0\n");
    folder.write(
        "one.toml",
        "name = \"one\"\nagents = [{ x = 0 }]\ntiming = { dt = 0.01, duration = 2 }\ntopology.b = 1\n\
         [vehicle]\nkind = \"single_integrator_1d\"\nd.x = \"ux + table('wind.csv', 'vx', t)\"\n\
         [controller]\nkind = \"formulas\"\nlaw.ux = 0\n",
    );
    succeeds(&folder, &["run", "one.toml", "-q", "--out", "one.mcap"]);
    std::fs::remove_file(folder.path("wind.csv")).expect("it is there");
    succeeds(&folder, &["replay", "one.mcap", "--only", "plant"]);
    // The area below the wind: a triangle of height 2 over 2 s.
    let place = last(&folder, "one.mcap", "/agent_1/state", "x")[0];
    assert!((place - 2.0).abs() < 1e-9, "{place}");
}

#[test]
fn a_new_vehicle_of_each_kind_runs_as_it_is_written() {
    let folder = Folder::new();
    for (vehicle, ..) in LIBRARY {
        let told = succeeds(&folder, &["new", "vehicle", vehicle, "--from", vehicle]);
        assert!(told.contains("Next:"), "{told}");
        let file = format!("{vehicle}.toml");
        succeeds(&folder, &["run", &file, "-q", "--placement", "single", "--duration", "1", "--strict"]);
    }
    let again = folder.run(&["new", "vehicle", "unicycle"]);
    assert!(again.code() == 2 && again.stderr().contains("unicycle.toml exists already"), "{}", again.stderr());
    let unknown = folder.run(&["new", "vehicle", "boat", "--from", "unicicle"]);
    assert!(unknown.stderr().contains("did you mean `unicycle`"), "{}", unknown.stderr());
    let program = folder.run(&["new", "controller", "mine"]);
    assert!(program.code() == 2 && program.stderr().contains("--lang"), "{}", program.stderr());
    // The robots of the default reach their places.
    succeeds(&folder, &["run", "unicycle.toml", "-q", "--placement", "single", "--out", "u.mcap"]);
    let [place, goal] =
        ["state", "reference"].map(|role| last(&folder, "u.mcap", &format!("/agent_2/{role}"), "position"));
    assert!((place[0] - goal[0]).hypot(place[1] - goal[1]) < 0.5, "{place:?} {goal:?}");
}

#[test]
fn a_vehicle_may_stand_in_a_file_of_its_own_and_the_log_needs_it_no_more() {
    let folder = Folder::new();
    folder.write(
        "boat.toml",
        "[vehicle]\nkind = \"equations\"\nstates = { x = \"m\", u = { unit = \"m/s\", initial = 0 } }\ninputs = { push = \"N\" }\n\
         parameters = { m = 2 }\nd.x = \"u\"\nd.u = \"(push - u)/m\"\nposition = [\"x\"]\nvelocity = [\"u\"]\n",
    );
    folder.write(
        "one.toml",
        "name = \"one\"\nagents = [{ x = 1 }, { x = 2, m = 3 }]\ntiming = { dt = 0.01, duration = 1 }\ntopology.b = 1\n\
         [vehicle]\nkind = \"equations\"\nfile = \"boat.toml\"\n[controller]\nkind = \"formulas\"\nlaw.push = \"-x\"\n",
    );
    succeeds(&folder, &["run", "one.toml", "-q", "--out", "one.mcap"]);
    std::fs::remove_file(folder.path("boat.toml")).expect("it is there");
    succeeds(&folder, &["replay", "one.mcap", "--only", "plant"]);
    let run = folder.run(&["run", "one.toml", "-q"]);
    assert_eq!(run.code(), 2);
    assert!(run.stderr().contains("one.toml:7:8: vehicle.file: boat.toml: "), "{}", run.stderr());
}

/// A scenario of two masses whose parts may be exchanged.
const MASSES: &str = r#"
name = "masses"
agents = [{ p = 1, v = 0 }, { p = -1, v = 0 }]

[timing]
dt = 0.1
duration = 1

[vehicle]
kind = "equations"
states = { p = "m", v = "m/s" }
inputs = { u = { unit = "m/s^2", low = -0.5, high = 0.5 } }
define.a = "u"
d.p = "v"
d.v = "a"
position = ["p"]
outputs.energy = "v^2/2"

[plant]
substeps = 2

[controller]
kind = "formulas"
define.e = "p"
law.u = "-e - v"
"#;

#[test]
fn what_means_two_things_or_no_number_is_refused() {
    let folder = Folder::new();
    folder.write("masses.toml", MASSES);
    assert!(succeeds(&folder, &["validate", "masses.toml"]).contains("valid"));
    let rows: &[(&str, &str, &[&str])] = &[
        ("v = \"m/s\" }", "dt = \"m/s\" }", &["vehicle.states.dt: `dt` stands for something else"]),
        ("v = \"m/s\" }", "sin = \"m/s\" }", &["vehicle.states.sin: `sin` stands for something else"]),
        ("v = \"m/s\" }", "p_j = \"m/s\" }", &["vehicle.states.p_j: expected another end than `_j`"]),
        ("{ p = 1, v = 0 }", "{ p = 1, v = 0, position = [2] }", &["agents.1.p: `position` gives this state, too"]),
        (
            "define.a = \"u\"",
            "define.a = \"b\"\ndefine.b = \"u\"",
            &["vehicle.define.a: uses `b`, which is defined below it"],
        ),
        ("define.a = \"u\"", "define.a = \"a + u\"", &["vehicle.define.a: `a` depends on itself"]),
        ("energy = \"v^2/2\"", "energy = []", &["vehicle.outputs.energy: expected at least one formula"]),
        ("energy = \"v^2/2\"", "energy = { value = \"v\", unit = \"m\\n\" }", &["expected a unit in one line"]),
        ("define.e = \"p\"", "define.v = \"p\"", &["controller.define.v: `v` stands for something else in laws"]),
        (
            "define.e = \"p\"",
            "states.t = { d = \"1\" }",
            &["controller.states.t: `t` stands for something else in laws"],
        ),
        (
            "law.u = \"-e - v\"",
            "law.u = \"v/v\"",
            &["controller.law.u: controller_1 cannot compute the first step", "\"v/v\""],
        ),
        (
            "law.u = \"-e - v\"",
            "law.u = \"-e - v\"\n[expect]\neffrt = { low = 1 }",
            &["no metric is called `effrt`", "did you mean `effort`?"],
        ),
    ];
    for (old, new, expected) in rows {
        assert!(MASSES.contains(old), "{old}");
        folder.write("masses.toml", &MASSES.replacen(old, new, 1));
        let end = folder.run(&["validate", "masses.toml"]);
        let stderr = end.stderr();
        assert_eq!(end.code(), 2, "{new}: {stderr}");
        for text in *expected {
            assert!(stderr.contains(text), "{new}: {text:?} is not in\n{stderr}");
        }
        // A mistake in a formula is one problem.
        assert!(
            stderr.contains("1 problem") || new.ends_with("m/s\" }") || new.contains("position"),
            "{new}: {stderr}"
        );
    }
}

#[test]
fn inputs_at_their_limits_are_a_metric_and_angles_have_no_turns() {
    let folder = Folder::new();
    folder.write("masses.toml", MASSES);
    let end = folder.run(&["run", "masses.toml", "--placement", "single", "-q", "--json", "--out", "masses.mcap"]);
    let share = end.json()["metrics"]["saturation"]["value"].as_f64().expect("a share");
    assert!((0.3..1.0).contains(&share), "{share}");

    // Two pendulums just left and right of the same place.
    let angles = MASSES
        .replace("position = [\"p\"]", "position = [\"p\"]\nangles = [\"p\"]")
        .replace("p = 1, v", "p = 3.1, v")
        .replace("p = -1, v", "p = -3.1, v")
        .replace("law.u = \"-e - v\"", "law.u = 0*e");
    folder.write("angles.toml", &angles.replace("law.u = 0*e", "law.u = \"0*e\""));
    let end = folder.run(&["run", "angles.toml", "--placement", "single", "-q", "--json", "--out", "angles.mcap"]);
    let gap = end.json()["metrics"]["gap_min"]["value"].as_f64().expect("a distance");
    assert!((gap - (std::f64::consts::TAU - 6.2)).abs() < 1e-12, "{gap}");
}
