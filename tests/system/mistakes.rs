//! What a user does wrong, and what the program says.

use crate::program::Folder;

const UAV: &str = include_str!("../../scenarios/uav.toml");

/// Replaces `from` by `to` and insists that it is there.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "the scenario no longer holds {from:?}");
    text.replacen(from, to, 1)
}

#[test]
fn ten_mistakes_in_one_file_give_ten_errors() {
    let mistakes = [
        ("dt = 0.01 ", "dt = 0.03 "),
        ("m = 2.10, R = 0.31", "m = -2.10, R = 0.31"),
        ("position = [1, 2, 0]", "position = [1, 2]"),
        ("b = 1\n", "b = [1, 1]\n"),
        ("    [1, 0, 0, 0, 0, 0],\n", "    [1, 0, 0, 0, 0],\n"),
        ("\"3*sin(alpha)\"", "\"3*sin(alfa)\""),
        ("c_bar = 1\n", "c_bar = \"one\"\n"),
        ("lam_obs = 2\n", "lam_obs = 2\nlam_obz = 2\n"),
        ("intro = \"logistic\"", "intro = \"logistics\""),
        ("[timing]", "[timings]\n[timing]"),
    ];
    let text = mistakes.iter().fold(UAV.to_string(), |text, (from, to)| changed(&text, from, to));
    let folder = Folder::new();
    folder.write("bad.toml", &text);
    let run = folder.run(&["run", "bad.toml"]);
    assert_eq!(run.code(), 2);
    let stderr = run.stderr();
    assert!(stderr.starts_with("error: 10 problems; nothing was started"), "{stderr}");
    for expected in [
        "timing.duration: 80.0 s is not a whole number of steps of 0.03 s",
        "agents.2.m: expected a number > 0, found -2.1",
        "agents.2.position: expected 3 or 6 values, found 2",
        "topology.b: expected 6 values, one for each agent, found 2",
        "topology.A: expected 6 x 6 values, found 5 in row 2",
        "reference.position.2: expected a known name, found 'alfa'",
        "planner.c_bar: expected a number, found the string \"one\"",
        "observer.lam_obz: unknown field",
        "did you mean `lam_obs`?",
        "controller.intro: ",
        "timings: unknown field",
    ] {
        assert!(stderr.contains(expected), "missing {expected:?} in\n{stderr}");
    }
    assert!(!folder.path("runs").exists(), "nothing was started, nothing was written");
}

fn refused(arguments: &[&str], expected: &[&str]) {
    let folder = Folder::new();
    let run = folder.run(&[&["run", "uav", "-q"], arguments].concat());
    let stderr = run.stderr();
    assert_eq!(run.code(), 2, "{stderr}");
    for text in expected {
        assert!(stderr.contains(text), "missing {text:?} in\n{stderr}");
    }
    assert!(!stderr.contains("panicked"), "{stderr}");
}

#[test]
fn overrides_are_checked_just_the_same() {
    refused(
        &["--set", "controller.c_q=3"],
        &["--set controller.c_q=3: controller.c_q: unknown field", "did you mean `c_p`"],
    );
    refused(&["--set", "agents.9.position=[1,2,0]"], &["agents.9: there is no element 9"]);
    refused(&["--set", "controller.c_p=-3"], &["controller.c_p: expected a number > 0, found -3"]);
    refused(&["--set", "nonsense=3"], &["nothing in this scenario is called `nonsense`"]);
    refused(&["--set", "c_p"], &["expected NAME=VALUE"]);
    refused(&["--variant", "TAC"], &["no variant is called `TAC`", "did you mean `TSC`"]);
    refused(&["--set", "variant=TAC"], &["no variant is called `TAC`"]);
    refused(&["--dt", "0.007"], &["80.0 s is not a whole number of steps of 0.007 s", "79.996 s (11428 steps)"]);
    refused(&["--dt", "0.0003", "--duration", "1000"], &["999.9999 s (3333333 steps) and 1000.0002 s"]);
    refused(&["--dt", "0.0166666667"], &["near are \"1/60\" and 0.016666667"]);
    refused(&["--duration", "1e-9"], &["less than one step"]);
    refused(&["--dt", "1e9", "--duration", "5e9"], &["68 years"]);
    refused(&["--deadline", "1e300"], &["above 0 and up to 86400 s"]);
    refused(&["--realtime", "1e-300"], &["expected a factor from 0.001"]);
    refused(&["--pin", "99"], &["--pin 99", "expected auto, none or one of the cores"]);
    refused(&["--swap", "controler.1=x"], &["did you mean `controller_1`"]);
}

#[test]
fn a_graph_that_is_not_strongly_connected_is_refused() {
    let rows = "A=[[0,0,0,0,0,0],[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0]]";
    refused(&["--set", rows], &["topology.A: the graph is not strongly connected", "agent 2 sends reaches agent 1"]);
}

#[test]
fn an_observer_for_another_vehicle_is_refused_with_a_reason() {
    let folder = Folder::new();
    let text = changed(UAV, "kind = \"hierarchical_uav\"", "kind = \"hierarchical_uav\" # flies quadcopters");
    let robots: String = (0..6).map(|i| format!("{{ m = 3, R = 0.2, I = 0.1, position = [{i}, 0, 0] }},")).collect();
    let start = text.find("agents = [").expect("agents");
    let end = text.find("[timing]").expect("timing");
    let text = format!("{}agents = [{robots}]\n{}", &text[..start], &text[end..]);
    let text = changed(&text, "kind = \"quadcopter\"", "kind = \"omni\"\norder = 2");
    let start = text.find("matched = [").expect("matched");
    let end = text.find("[plant]").expect("plant");
    folder.write("robots.toml", &format!("{}matched = [0, 0, 0]\n{}", &text[..start], &text[end..]));
    let run = folder.run(&["run", "robots.toml", "-q"]);
    assert_eq!(run.code(), 2);
    assert!(run.stderr().contains("`hierarchical_uav` flies quadcopters"), "{}", run.stderr());
}

#[test]
fn a_scenario_that_does_not_exist() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uaw"]);
    assert_eq!(run.code(), 2);
    assert!(run.stderr().contains("did you mean `uav`"), "{}", run.stderr());
    let run = folder.run(&["run", "none.toml"]);
    assert_eq!(run.code(), 2);
    assert!(run.stderr().contains("cannot read the scenario none.toml"), "{}", run.stderr());
}
