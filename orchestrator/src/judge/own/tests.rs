//! Metrics without a run: reading, evaluating.

use formation::scenario::Selection;
use formation::wiring::Assembly;
use lockstep::ChannelId;

use super::evaluate::{advance, results};
use super::*;
use schemes::ROLES;

/// Three robots on a line with these metrics; `metrics` may be empty.
fn robots(metrics: &str) -> Assembly {
    let text = format!(
        "name = \"three\"\nagents = [{{ position = [0, 0, 0], R = 0.1 }}, {{ position = [2, 0, 0], R = 0.1 }}, {{ position = [4, 0, 0], R = 0.1 }}]\n\
         timing = {{ dt = 0.5, duration = 2 }}\nvehicle = {{ kind = \"integrator\", UM = 2 }}\ntopology = {{ graph = \"complete\" }}\n\
         parameters = {{ late = 1 }}\nreference = {{ position = [\"2*i\", 0, 0] }}\nplant = {{ kind = \"vehicles\" }}\nplanner = {{ kind = \"reference\" }}\n\
         controller = {{ kind = \"consensus\", k_x = 1, k_v = 1 }}\n{metrics}\n"
    );
    Assembly::load("three.toml", &text, &Selection::default(), &ROLES)
        .unwrap_or_else(|problems| panic!("{}", problems[0]))
}

fn mistake(metrics: &str) -> String {
    let problems = read(&robots(metrics)).expect_err("a mistake");
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// The metrics on samples that are 0 but for the first position of each agent, at the steps 0, 1, ...
fn evaluate(metrics: &str, steps: &[[f64; 3]]) -> Vec<(String, f64)> {
    let assembly = robots(metrics);
    let mut metrics = read(&assembly).unwrap_or_else(|problems| panic!("{}", problems[0]));
    let mut slots = Vec::new();
    for (step, positions) in (0..).zip(steps) {
        let samples: Vec<Vec<f64>> = assembly
            .network
            .channels
            .iter()
            .map(|channel| {
                let mut words = vec![0.0; channel.layout.words()];
                let is_state = channel.topic.ends_with("/state");
                if is_state || channel.topic.ends_with("/command") {
                    words[0] = positions[channel.agent as usize - 1];
                }
                words
            })
            .collect();
        advance(&mut metrics, step, 0.5, &|channel: ChannelId| &samples[channel.0][..], &mut slots);
    }
    results(metrics).into_iter().map(|(metric, _)| (metric.id, metric.value)).collect()
}

const STEPS: [[f64; 3]; 5] = [[4.0, 0.0, 1.0], [3.0, 0.0, 1.0], [-2.0, 0.0, 1.0], [0.1, 0.0, 1.0], [0.2, 1.0, 1.0]];

fn value(formula: &str) -> f64 {
    let metrics = format!("[metrics]\nset = \"\"\nx = {{ value = \"{formula}\", agents = [1] }}");
    evaluate(&metrics, &STEPS)[0].1
}

#[test]
fn reducers_over_time() {
    for (formula, expected) in [
        ("max(state.position[0])", 4.0),
        ("min(state.position[0])", -2.0),
        ("final(state.position[0])", 0.2),
        ("mean(abs(state.position[0]), from = 1)", 2.3 / 3.0),
        ("mean(state.position[0], from = late, until = 1.5)", -0.95),
        ("rms(state.position[0], until = 0.5)", 12.5_f64.sqrt()),
        ("integral(state.position[0])", 0.5 * (2.0 + 3.0 - 2.0 + 0.1 + 0.1)),
        ("variation(state.position[0])", 1.0 + 5.0 + 2.1 + 0.1),
        ("share(state.position[0] >= 3)", 0.4),
        ("share(state.position[0] > 0 and t < 1)", 0.4),
        ("settle(abs(state.position[0]), below = 0.5)", 1.5),
        ("settle(abs(state.position[0]), within = 0.5)", 1.0),
        ("final(state.position[0])/max(state.position[0]) + sqrt(min(t))", 0.05),
        ("max(norm(state.position[0:2]), from = 1)", 2.0),
        ("max(max(state.position[0], 3.5), from = 0.5)", 3.5),
        ("N*mean(t)", 3.0),
    ] {
        let found = value(formula);
        assert!((found - expected).abs() < 1e-12, "{formula}: {found}");
    }
    assert!(value("settle(abs(state.position[0]), below = 0.1)").is_nan());
    assert!(
        mistake("[metrics]\nx = \"max(state.position[0], from = 7)\"").contains("expected times 0 <= from <= until")
    );
}

#[test]
fn agents_are_taken_together() {
    let of = |across: &str| {
        let metrics = format!("[metrics]\nset = \"\"\nx = \"final(state.position[0], across = {across})\"");
        evaluate(&metrics, &STEPS)[0].1
    };
    assert_eq!([of("max"), of("min"), of("sum")], [1.0, 0.2, 2.2]);
    assert!((of("\\\"mean\\\"") - 2.2 / 3.0).abs() < 1e-12);
}

#[test]
fn the_default_set() {
    let found = evaluate("", &[[2.0, 4.0, 6.0], [2.0, 4.0, 7.0]]);
    let value = |id: &str| found.iter().find(|(known, _)| known == id).map(|(_, value)| *value);
    // The references are 0 in these samples.
    assert_eq!((value("tracking_end"), value("tracking_end_1")), (Some(7.0), Some(2.0)));
    assert_eq!(value("formation_end"), Some(5.0));
    assert!((value("gap_min").unwrap() - 1.8).abs() < 1e-12);
    assert_eq!((value("variation"), value("saturation")), (Some(1.0), Some(1.0)));
    assert!((value("lambda_2").unwrap() - 3.0).abs() < 1e-9);
    assert!(value("effort").is_some() && value("settling").is_some());
    // A table of one's own comes on top; a set, or none by name, takes its place.
    let with_own = evaluate("[metrics]\ngap_min = \"min(distance, across = min)\"", &[[2.0, 4.0, 6.0]]);
    assert_eq!(with_own.iter().filter(|(id, _)| id == "gap_min").count(), 1);
    assert!(with_own.len() > 3);
    assert!(evaluate("metrics = \"\"", &[[2.0, 4.0, 6.0]]).is_empty());
}

#[test]
fn mistakes_have_their_place() {
    for (metrics, expected) in [
        (
            "x = \"norm(state.position)\"",
            "three.toml:12:5: metrics.x: expected a signal over time within one of max, min, mean",
        ),
        ("x = \"maxx(tracking)\"", "did you mean `max`?"),
        ("x = \"max(state.positon[0])\"", "did you mean `position`?"),
        ("x = \"max(state.position)\"", "found a vector of 3"),
        (
            "x = \"max(tracking, form = 2)\"",
            "has no option `form`, expected one of from, until, across, below, within; did you mean `from`?",
        ),
        ("x = \"max(tracking, 2)\"", "expected one signal in max(...), found 2"),
        ("x = \"max(tracking\"", "expected ')' behind max("),
        ("x = \"max(tracking, across = \\\"mx\\\")\"", "across: expected one of max, mean, sum, min, found `mx`"),
        ("x = \"settle(tracking)\"", "settle(...) needs `below = VALUE`"),
        ("x = \"max(tracking, below = 1)\"", "only settle(...) has `below` and `within`"),
        ("x = \"max(tracking, from = 3, until = 1)\"", "found from = 3, until = 1"),
        ("x = \"max(tracking, from = lat)\"", "from: "),
        ("x = \"max(tracking) + frm\"", "frm"),
        ("x = 3", "metrics.x: expected a formula, or a table with `value`, found"),
        ("x = { value = \"max(tracking)\", unt = \"m\" }", "did you mean `unit`?"),
        ("x = { value = \"max(tracking)\", agents = [4] }", "metrics.x.agents: expected numbers of agents from 1 to 3"),
        ("x = { value = \"max(trackin)\" }", "metrics.x.value: "),
    ] {
        let found = mistake(&format!("[metrics]\n{metrics}"));
        assert!(found.contains(expected), "{metrics}\n{found}");
    }
}

#[test]
fn edges_have_lengths_and_directions() {
    // At the end the first robot is at 0.2, the others at 1; the references of these samples are all 0.
    assert_eq!(["final(edge_longest)", "final(edge_shortest)", "final(edge_error)"].map(value), [0.8; 3]);
    assert_eq!(value("final(bearing_error)"), std::f64::consts::PI);
    assert_eq!(value("max(edge_longest)"), 4.0);
}
