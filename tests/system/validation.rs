//! What `validate` and `run` find in a scenario before anything starts, and how they say it.

use std::os::unix::process::ExitStatusExt;
use std::process::{Command, Stdio};

use crate::program::Folder;

const EXPERIMENT: &str = "compensated-experiment";

/// The scenario with these changes is refused, with each of these words.
fn refused(scenario: &str, changes: &[&str], expected: &[&str]) {
    let folder = Folder::new();
    let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
    for command in ["validate", "run"] {
        let end = folder.run(&[&[command, scenario], &changes[..]].concat());
        let stderr = end.stderr();
        assert_eq!(end.code(), 2, "{scenario} {changes:?}: {stderr}");
        for text in expected {
            assert!(stderr.contains(text), "{scenario} {changes:?}: {text:?} is not in\n{stderr}");
        }
        assert!(!folder.path("runs").exists(), "nothing was started, nothing was written");
    }
}

fn accepted(scenario: &str, changes: &[&str]) -> String {
    let folder = Folder::new();
    let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
    let end = folder.run(&[&["validate", scenario, "--print"], &changes[..]].concat());
    assert_eq!(end.code(), 0, "{scenario} {changes:?}: {}", end.stderr());
    end.stdout()
}

#[test]
fn an_order_that_the_vehicle_does_not_have() {
    for scenario in ["triangle", "uav", "cida", "rca"] {
        for order in ["0", "3", "7"] {
            let section = format!("vehicle.order={order}");
            refused(scenario, &[&section], &["1 problem;", "vehicle.order: ", &format!("found {order}")]);
        }
        refused(scenario, &["agents.2.order=7"], &["agents.2.order: ", "found 7"]);
    }
    accepted("triangle", &["vehicle.order=2"]);
}

#[test]
fn parameters_that_no_robot_has() {
    for field in ["R", "m", "I"] {
        for value in ["0", "-1", "inf", "nan"] {
            let change = format!("agents.2.{field}={value}");
            refused("triangle", &[&change], &[&format!("agents.2.{field}: expected a number > 0")]);
        }
    }
    refused("triangle", &["fric=nan"], &["agents.1.fric: expected a finite number, found NaN"]);
    refused("uav", &["agents.1.K=inf"], &["agents.1.K: expected a finite number, found inf"]);
}

#[test]
fn rows_are_as_many_as_agents() {
    let three = "x0=[[0,0,0],[1,1,0],[2,2,0]]";
    refused("cida", &["agents=[2,3,5,6]", three], &["agents.*.position: expected 4 values", "found 3"]);
    refused("cida", &["agents=[2,3]", three], &["agents.*.position: expected 2 values", "found 3"]);
    refused("cida", &["N=4", three], &["agents.*.position: expected 4 values", "found 3"]);
    refused("cida", &["N=4", "agents=[1,2]"], &["--set N=4", "expected N = 2"]);
    for (name, field) in [("v0", "velocity"), ("xhat0", "estimate"), ("vhat0", "estimate_velocity")] {
        let rows = format!("{name}=[[0,0,0],[1,1,0]]");
        let message = format!("agents.*.{field}: expected 3 values, one per agent, found 2");
        refused("triangle", &[&rows], &[&message]);
        refused("triangle", &["agents=[1,2,3]", &rows], &[&message]);
    }
    refused("triangle", &["Rhat=[1,2]"], &["agents.*.R_hat: expected 3 values", "found 2"]);
    refused("triangle", &["b=[1,2]"], &["topology.b: expected 3 values", "found 2"]);
    refused("triangle", &["A=[[0,1],[1,0]]"], &["topology.A: expected 3 rows", "found 2"]);
    let many = format!("x0=[{}]", "[0,0,0],".repeat(1001));
    refused("triangle", &[&many], &["at most 1000 agents, found 1001"]);
    accepted("triangle", &["agents=[1,3]", "x0=[[0,0,0],[1,1,0]]"]);
    accepted("triangle", &["N=5", "m=[1,2,3,4,5]"]);
}

#[test]
fn values_of_another_kind() {
    refused("uav", &["parameters.phase=inf"], &["parameters.phase: expected a finite number, found inf"]);
    refused(
        "uav",
        &["expect={x_til={low=2, high=1}}"],
        &["expect.x_til: expected a range with low <= high, found low = 2"],
    );
    refused("uav", &["expect={x_til={low=nan}}"], &["expect.x_til: expected a range"]);
    refused(
        "uav",
        &["controller=3"],
        &["1 problem;", "controller: expected a table with the `kind`", "found the integer 3"],
    );
    refused("uav", &["controller.kind=3"], &["controller.kind: expected a name", "found the integer 3"]);
    refused("uav", &["disturbance=3"], &["1 problem;", "disturbance: expected a table with matched"]);
    refused("uav", &["reference=3"], &["reference: expected a table with position"]);
    refused("uav", &["variants.X.seed=3"], &["variants: a variant is chosen"]);
    refused(
        "uav",
        &["controller.every=2.5"],
        &["expected a whole number of steps from 1 to 1000000, found the number 2.5"],
    );
    refused("uav", &["agents=[2,1,2]"], &["agent 2 is chosen twice"]);
}

#[test]
fn a_graph_that_is_not_strongly_connected_names_the_way_out() {
    let path = "A=[[0,0,0],[1,0,0],[0,1,0]]";
    refused("triangle", &[path], &["topology.A: the graph is not strongly connected", "topology.any_graph = true"]);
    accepted("triangle", &[path, "any_graph=true"]);
}

#[test]
fn one_agent_can_run_every_shipped_scenario() {
    let folder = Folder::new();
    for scenario in folder.run(&["list", "--json"]).json().as_array().expect("a list") {
        let name = scenario["name"].as_str().expect("a name");
        for change in ["N=1", "agents=[2]"] {
            accepted(name, &[change]);
        }
    }
    let end = folder.run(&["run", "uav", "--set", "N=1", "--duration", "0.1", "-q", "--out", "one.mcap"]);
    assert_eq!(end.code(), 0, "{}", end.stderr());
    let check = folder.run(&["check", "one.mcap"]);
    assert_eq!(check.code(), 0, "{}", check.stderr());
    let end = folder.run(&["run", EXPERIMENT, "--set", "N=1", "--duration", "0.1", "-q"]);
    assert_eq!(end.code(), 0, "{}", end.stderr());
    let end = folder.run(&["validate", "triangle", "--set", "N=1"]);
    assert!(end.stdout().contains("1 agent, 4 processes"), "{}", end.stdout());
}

#[test]
fn what_a_scenario_says_about_agents_follows_them() {
    let swaps = |change: &str| {
        let text = accepted(EXPERIMENT, &[change]);
        let at = text.find("[swap]").expect("the section");
        text[at..].lines().skip(1).take_while(|line| line.contains('=')).map(str::to_string).collect::<Vec<_>>()
    };
    let emulated = |agents: &[u32]| agents.iter().map(|n| format!("\"plant.{n}\" = \"emulator\"")).collect::<Vec<_>>();
    assert_eq!(swaps("N=3"), emulated(&[1, 2, 3]));
    assert_eq!(swaps("N=2"), emulated(&[1, 2]));
    assert_eq!(swaps("agents=[1,3]"), emulated(&[1, 2]));
    assert_eq!(swaps("x0=[[0,0,0],[1,1,0]]"), emulated(&[1, 2]));
    assert_eq!(swaps("N=5"), emulated(&[1, 2, 3, 4, 5]));
    refused(
        EXPERIMENT,
        &["swap={\"plant.9\"=\"emulator\"}"],
        &["swap: plant.9: there is no plant of agent 9, expected agents 1 to 3"],
    );

    let folder = Folder::new();
    let extra = r#"
on_failure = { "controller.2" = "hold", controller_3 = "abort" }
edges = { "controller_1 <- plant" = "delayed", "controller_2 <- plant" = "delayed" }
placement.groups = [["controller_1", "plant"], ["controller_2"], ["controller_3", "planner"]]
swap = { "controller.2" = "./two", controller = { 3 = "./three" } }
"#;
    let triangle =
        include_str!("../../scenarios/triangle.toml").replace("\nagents = [", &format!("{extra}\nagents = ["));
    let assertion = "\n[[assert]]\nname = \"third\"\nsignal = \"state.position[0]\"\nmax = 9\nagents = [2, 3]\n";
    folder.write("t.toml", &format!("{triangle}{assertion}"));
    let end = folder.run(&["validate", "t.toml", "--print", "--set", "agents=[3,1]"]);
    assert_eq!(end.code(), 0, "{}", end.stderr());
    let text = end.stdout();
    for part in [
        "\"controller_2 <- plant\" = \"delayed\"",
        "[[\"controller_2\", \"plant\"], [\"controller_1\", \"planner\"]]",
        "controller = { 1 = \"./three\" }",
        "controller_1 = \"abort\"",
        "agents = [1]",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    assert!(!text.contains("./two") && !text.contains("\"hold\""), "{text}");
    // Emulators of chosen agents are those agents.
    let end = folder.run(&["run", EXPERIMENT, "--set", "agents=[1,3]", "--duration", "0.1", "-q", "--json"]);
    assert!(end.code() == 0 || end.code() == 6, "{}", end.stderr());
}

#[test]
fn the_plant_of_one_agent_can_be_swapped_in_the_file() {
    let folder = Folder::new();
    let text = include_str!("../../scenarios/compensated.toml");
    folder.write("c.toml", &format!("{text}\n[swap]\n\"plant.2\" = \"emulator\"\n"));
    let end = folder.run(&["validate", "c.toml"]);
    assert_eq!(end.code(), 0, "{}", end.stderr());
}

#[test]
fn formulas_that_are_not_finite_at_the_start() {
    for (formula, finding) in [("sin(t)/t", "value is NaN"), ("1/t", "value is inf"), ("ln(t)", "value is -inf")] {
        let reference = format!("reference.position=['{formula}', '0', '0']");
        refused("triangle", &[&reference], &["1 problem;", "reference.position.1: ", finding, formula]);
        let disturbance = format!("disturbance.matched=['0', '{formula}', '0']");
        refused("triangle", &[&disturbance], &["1 problem;", "disturbance.matched.2: ", finding, formula]);
        let mismatched = format!("disturbance.mismatched=['0', '0', '{formula}']");
        refused("triangle", &[&mismatched], &["disturbance.mismatched.3: ", finding]);
    }
    refused("triangle", &["reference.position=['0', 'sqrt(t)', '0']"], &["position.2: its velocity is inf"]);
    refused("triangle", &["reference.position=['0', 't^1.5', '0']"], &["position.2: its acceleration is inf"]);
    refused("triangle", &["reference.position=['0', 't^2.5', '0']"], &["position.2: its third derivative is inf"]);
    refused(
        "triangle",
        &["disturbance.matched=['1/(px-2)', '0', '0']"],
        &["matched.1: its value is inf at t = 0 for agent 2"],
    );
    let folder = Folder::new();
    let text = include_str!("../../scenarios/triangle.toml").replace("0.1*sin(t)\"", "gust*sin(t)\"");
    let text = text.replace("[disturbance]\n", "[disturbance]\ndefine.gust = \"1/sin(t)\"\n");
    folder.write("t.toml", &text);
    let end = folder.run(&["validate", "t.toml"]);
    let line = text.lines().position(|line| line.contains("gust*sin")).expect("the formula") + 1;
    assert_eq!(end.code(), 2);
    for part in [
        &format!("t.toml:{line}:12: disturbance.matched.1: its value is NaN at t = 0"),
        "because of disturbance.define.gust, \"1/sin(t)\"",
    ] {
        assert!(end.stderr().contains(part), "{part} is not in\n{}", end.stderr());
    }
}

#[test]
fn messages_say_what_to_write_instead() {
    refused(EXPERIMENT, &["control_hz=50"], &["`control_hz`", "timing.dt"]);
    refused(EXPERIMENT, &["plant.control_hz=50"], &["plant.control_hz: unknown field", "timing.dt"]);
    refused(EXPERIMENT, &["dt=0.0125"], &["0.001 s each, found 0.0125 s; the nearest are 0.012 s and 0.013 s"]);
    let rows = "faults=[[1, 18, 0.5, 'dropout']]";
    refused(EXPERIMENT, &[rows], &["expected a table with robot, start, duration, kind, offset, found a list of 4"]);
    refused("uav", &["metrics=uaw"], &["no set of metrics is called `uaw`", "did you mean `uav`?", "--set metrics="]);
    let folder = Folder::new();
    for (field, having) in [("controller.tau=1", "AOBFC, OBFC have"), ("tau=1", "AOBFC, OBFC have")] {
        let end = folder.run(&["validate", "cida", "--variant", "RCTFC", "--set", field]);
        assert!(end.code() == 2 && end.stderr().contains(having), "{}", end.stderr());
        assert!(end.stderr().contains("--set-if-present"), "{}", end.stderr());
    }
    let end = folder.run(&["validate", "nothing-near"]);
    assert!(end.stderr().contains("there is no such file; `phalanx list`"), "{}", end.stderr());
    let end = folder.run(&["run", "triangle", "--duration", "0.1", "--placement", "single", "--out", "a.mcap"]);
    assert!(end.stderr().starts_with("triangle: three planar robots"), "{}", end.stderr());
    assert!(end.stderr().contains("3 agents, 1 process, 0.1 s"), "{}", end.stderr());
    assert!(end.stdout().contains("x real time, 1 process\n"), "{}", end.stdout());
    let end = folder.run(&["graph", "triangle"]);
    assert!(end.stdout().starts_with("triangle: 5 processes"), "{}", end.stdout());
    let end = folder.run(&["graph", "uav"]);
    assert!(end.stdout().starts_with("uav TSC: "), "{}", end.stdout());
}

#[test]
fn no_message_is_longer_than_one_reads() {
    let folder = Folder::new();
    let (long, sum) = ("x".repeat(60_000), "t + ".repeat(15_000) + "t");
    for change in [
        format!("{long}=3"),
        format!("controller.{long}=3"),
        format!("controller.k_x={long}"),
        format!("controller.kind={long}"),
        format!("variant={long}"),
        format!("N={}", "9".repeat(60_000)),
        format!("topology.b={long}"),
        format!("topology.A={long}"),
        format!("agents.1.position=[{}, 0, 0]", "9".repeat(400)),
        format!("reference.position=['{sum}', '0', '0']"),
        format!("reference.position=['{}*q', '0', '0']", "t + ".repeat(500) + "t"),
        format!("disturbance.matched=['{sum}', '0', '0']"),
        format!("assert=[{{name='a', signal='{sum}', max=1}}]"),
        format!("assert=[{{name='a', metric='{long}', max=1}}]"),
        format!("assert=[{{name='a', metric='gap', max='{sum}'}}]"),
        format!("ranges={{'{long}'={{max=1}}}}"),
        format!("placement.groups=[['{long}']]"),
        format!("edges={{'{long}'='delayed'}}"),
        format!("on_failure={{'{long}'='hold'}}"),
        format!("swap={{'{long}'='true'}}"),
        format!("metrics={long}"),
        "controller.k_x=-1e308".into(),
        "agents.1.R=-1e300".into(),
    ] {
        let end = folder.run(&["validate", "triangle", "--set", &change]);
        let stderr = end.stderr();
        let start: String = change.chars().take(40).collect();
        assert_eq!(end.code(), 2, "{start}: {stderr}");
        assert!(stderr.len() < 1500, "{start}: {} bytes", stderr.len());
        assert!(stderr.split(' ').all(|word| word.len() <= 170), "{start}: {stderr}");
        let digits = stderr.split(|c: char| !c.is_ascii_digit()).map(str::len).max();
        assert!(change.contains("999") || digits.is_none_or(|digits| digits < 25), "{start}: {stderr}");
    }
    for arguments in
        [["--swap", &long], ["--on-failure", &long], ["--pin", &long], ["--deadline", &long], ["--variant", &long]]
    {
        let end = folder.run(&[&["run", "triangle"], &arguments[..]].concat());
        assert!(end.code() == 2 && end.stderr().len() < 1500, "{arguments:?}: {} bytes", end.stderr().len());
    }
    let end = folder.run(&["validate", &long]);
    assert!(end.code() == 2 && end.stderr().len() < 500, "{}", end.stderr().len());
    // The name that is wrong is in what is shown of a long formula.
    let end = folder.run(&[
        "validate",
        "triangle",
        "--set",
        &format!("reference.position=['{}alfa', '0', '0']", "t + ".repeat(900)),
    ]);
    assert!(end.stderr().contains("found 'alfa' (column 3601 of \"…"), "{}", end.stderr());
}

#[test]
fn no_more_is_read_than_a_scenario_may_have() {
    let folder = Folder::new();
    let end = folder.run(&["run", "triangle", "--duration", "0.1", "-q", "--out", "a.mcap"]);
    assert_eq!(end.code(), 0, "{}", end.stderr());
    // A file of one terabyte that takes no room on the disk.
    std::fs::File::create(folder.path("huge.toml")).and_then(|file| file.set_len(1 << 40)).expect("a sparse file");
    folder.write("bytes.toml", "name = \"a\"\n");
    std::fs::write(folder.path("bytes.toml"), b"name = \"\xff\"\n").expect("a file");
    for (file, expected) in [
        ("/dev/zero", "at most 4 MB"),
        ("/dev/urandom", "at most 4 MB"),
        ("huge.toml", "at most 4 MB"),
        ("./a.mcap", "this is an MCAP log; give it to `phalanx report`"),
        ("bytes.toml", "byte 8 is not valid UTF-8"),
        ("/", "Is a directory"),
    ] {
        for arguments in [&["validate", file][..], &["run", file], &["verify", "--scenario", file], &["robot", file]] {
            // Within 200 MB of memory.
            let mut limited = Command::new("sh");
            let line = "ulimit -v 200000; exec \"$@\"";
            limited.args(["-c", line, "sh", env!("CARGO_BIN_EXE_phalanx")]).args(arguments);
            let end = limited.current_dir(folder.path("")).output().expect("a shell");
            let stderr = String::from_utf8_lossy(&end.stderr);
            assert!(end.status.code() == Some(2), "{arguments:?}: {:?} {stderr}", end.status.into_raw());
            assert!(stderr.contains(expected), "{arguments:?}: {stderr}");
        }
        let robot = format!("plant.2=hardware:{file}");
        let end = folder.run(&["run", "compensated", "--realtime", "--swap", &robot]);
        assert!(end.code() == 2 && end.stderr().contains(expected), "{robot}: {}", end.stderr());
    }
}

#[test]
fn a_scenario_may_come_from_a_pipe() {
    let folder = Folder::new();
    let text = include_str!("../../scenarios/triangle.toml");
    folder.write("t.toml", text);
    let program = env!("CARGO_BIN_EXE_phalanx");
    for line in
        ["cat t.toml | \"$0\" validate /dev/stdin", "mkfifo f.toml; cat t.toml > f.toml & \"$0\" validate f.toml"]
    {
        let end =
            Command::new("sh").args(["-c", line, program]).current_dir(folder.path("")).output().expect("a shell");
        assert!(end.status.success(), "{line}: {}", String::from_utf8_lossy(&end.stderr));
    }
    // An endless one is refused as soon as it is too long.
    let mut endless = Command::new("yes").stdout(Stdio::piped()).spawn().expect("the program yes");
    let output = endless.stdout.take().expect("its output");
    let mut command = folder.phalanx(&["validate", "/dev/stdin"]);
    let end = command.stdin(output).output().expect("the program");
    endless.kill().and_then(|()| endless.wait()).expect("it ends");
    let stderr = String::from_utf8_lossy(&end.stderr);
    assert!(end.status.code() == Some(2) && stderr.contains("at most 4 MB"), "{stderr}");
}
