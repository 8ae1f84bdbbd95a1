//! Assertions without a run: reading, evaluating, telling.

use formation::scenario::Selection;
use formation::wiring::Assembly;
use lockstep::ChannelId;

use super::*;
use schemes::{ROLES, SCENARIOS};

/// The drones with these assertions instead of their own.
fn drones(assertions: &str) -> Assembly {
    let text = SCENARIOS.iter().find(|shipped| shipped.name == "uav").expect("uav").text;
    let start = text.find("[[assert]]").expect("its assertions");
    let end = text.find("[expect]").expect("its expectations");
    let text = format!("{}{assertions}\n{}", &text[..start], &text[end..]);
    Assembly::load("uav.toml", &text, &Selection::default(), &ROLES).expect("a valid scenario")
}

fn mistake(assertion: &str) -> String {
    let problems = read(&drones(&format!("[[assert]]\n{assertion}"))).expect_err("a mistake");
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Evaluates assertions at steps 0, 1, ... on samples that are 0 but for the first position of each agent.
fn evaluate(assertions: &str, steps: &[[f64; 6]]) -> (Watch, Vec<(usize, Violation)>) {
    let assembly = drones(assertions);
    let mut watch = Watch::new(read(&assembly).expect("valid assertions"), 0.01);
    let mut told = Vec::new();
    for (step, positions) in (0..).zip(steps) {
        let samples: Vec<Vec<f64>> = assembly
            .network
            .channels
            .iter()
            .map(|channel| {
                let mut words = vec![0.0; channel.layout.words()];
                if channel.topic.ends_with("/state") {
                    words[0] = positions[channel.agent as usize - 1];
                }
                words
            })
            .collect();
        let sample = |channel: ChannelId| &samples[channel.0][..];
        watch.step(step, &sample, |index, _, violation| told.push((index, *violation)));
    }
    (watch, told)
}

const APART: [f64; 6] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0];

#[test]
fn signals_are_formulas_over_fields_and_metrics() {
    let assertions = r#"
        [[assert]]
        name = "word"
        signal = "2*state.position[0] + i + 1e-1"
        max = 1e9
        [[assert]]
        name = "folds"
        signal = "norm(state.position[0:3] - reference.position) + peak(state.position) + largest( state.velocity )"
        max = 1e9
        [[assert]]
        name = "distance"
        metric = "distance"
        max = 1e9
        [[assert]]
        name = "gap"
        signal = "gap + t"
        max = 1e9
        [[assert]]
        name = "norm of all"
        signal = "state.position[0]"
        across = "norm"
        max = 1e9
        [[assert]]
        name = "sum of two"
        signal = "state.position[0]"
        across = "sum"
        agents = [2, 3]
        max = "m*1e9"
    "#;
    let (watch, told) = evaluate(assertions, &[[3.0, 14.0, 26.0, 38.0, 50.0, 62.0]]);
    assert!(told.is_empty());
    // With upper bounds only, the worst value is the largest.
    let worst: Vec<f64> =
        watch.findings().0.iter().filter_map(|finding| finding.to_json()["worst"]["value"].as_f64()).collect();
    let stacked = [3.0f64, 14.0, 26.0, 38.0, 50.0, 62.0].iter().map(|x| x * x).sum::<f64>().sqrt();
    // Of the gaps, the largest is that of agent 3, to agent 4.
    let expected = [2.0 * 62.0 + 6.1, 2.0 * 62.0, 12.0, 12.0 - 0.30 - 0.32, stacked, 40.0];
    assert_eq!(worst.len(), expected.len());
    for (found, expected) in worst.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found} instead of {expected}");
    }
}

#[test]
fn a_violation_says_who_when_and_by_how_much() {
    let assertion = "[[assert]]\nname = \"apart\"\nmetric = \"gap\"\nmin = 0\nfrom = 0.01\nto = 0.04";
    let near = [0.0, 0.5, 20.0, 30.0, 40.0, 50.0];
    // At step 0 the window has not begun, at step 5 it is over; once in between they come close.
    let (watch, told) = evaluate(assertion, &[near, APART, near, near, APART, near]);
    let steps: Vec<(u64, u32)> = told.iter().map(|(_, violation)| (violation.step, violation.agent)).collect();
    assert_eq!(steps, [(2, 1), (2, 2)], "both of the pair, once for each time that it begins");
    let findings = watch.findings();
    let finding = &findings.0[0];
    assert_eq!((finding.checked, finding.violations), (24, 4));
    assert!(!findings.ok() && finding.fails() && !watch.stops());
    let failure = findings.failure().expect("a failure");
    assert!(failure.contains("apart: agent 1 at t = 0.02 s: gap = -"), "{failure}");
    assert!(failure.contains("< 0"), "{failure}");
    let narrow = findings.table(Some(30));
    assert!(narrow.contains("\n    VIOLATED: >= 0, worst ") && !narrow.contains("  VIOLATED\n"), "{narrow}");
    assert_eq!(findings.table(Some(500)), findings.table(None));
    let table = findings.table(None);
    assert!(table.contains("VIOLATED") && table.contains(">= 0") && table.contains("agent 1 at 0.02 s"), "{table}");
}

#[test]
fn a_warning_fails_nothing_and_a_stop_stops() {
    let assertion = "[[assert]]\nname = \"a\"\nsignal = \"state.position[0]\"\nmax = 1\nseverity = \"warn\"";
    let far = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (watch, told) = evaluate(assertion, &[far]);
    assert!(watch.findings().ok() && !watch.stops() && told.len() == 1);
    assert!(watch.findings().table(None).contains("violated (warning)"));
    let (watch, _) = evaluate(&format!("{assertion}\nstop = true"), &[[0.0; 6]]);
    assert!(!watch.stops());
    let (watch, _) = evaluate(&format!("{assertion}\nstop = true"), &[far]);
    assert!(watch.stops());
}

#[test]
fn what_is_no_number_violates() {
    let assertion = "[[assert]]\nname = \"a\"\nsignal = \"0/(state.position[0] - 1)\"\nmin = -1\nmax = 1";
    let (watch, told) = evaluate(assertion, &[[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
    assert_eq!(told.len(), 1);
    assert!(watch.findings().failure().is_some_and(|text| text.contains("is NaN")));
    assert_eq!(watch.findings().to_json()[0]["first"]["value"], serde_json::Value::Null);
}

#[test]
fn a_comparison_needs_no_bounds() {
    let assertion = "[[assert]]\nname = \"a\"\nsignal = \"2*state.position[0] < 3 or gap > m and 0 <= t < 1\"";
    // In the end the gap to the nearest is 9 m, less the radii.
    let steps = [[1.0, 2.0, 1.0, 1.0, 1.0, 1.0], [1.5, 11.5, 22.5, 33.5, 44.5, 55.5]];
    let (watch, told) = evaluate(assertion, &steps);
    let found: Vec<(u64, u32)> = told.iter().map(|(_, violation)| (violation.step, violation.agent)).collect();
    assert_eq!(found, [(0, 2)], "{:?}", watch.findings());
    let findings = watch.findings();
    let failure = findings.failure().expect("a failure");
    assert!(
        failure
            .contains("agent 2 at t = 0 s: 2*state.position[0] < 3 or gap > m and 0 <= t < 1 does not hold, margin -1")
    );
    assert!(findings.table(None).contains("margin >= 0  -1 (agent 2 at 0 s)"), "{}", findings.table(None));
    assert!(findings.0[0].summary().contains("< 1: margin >= 0; worst -1 (agent 2"), "{}", findings.0[0].summary());
}

/// Equal is not less, though the margin of both comparisons is 0.
#[test]
fn equal_sides_are_not_less() {
    for (relation, violations) in [("<", 6), ("<=", 0), (">", 6), (">=", 0)] {
        let assertion = format!("[[assert]]\nname = \"a\"\nsignal = \"state.position[0] {relation} 2\"");
        let (_, told) = evaluate(&assertion, &[[2.0; 6]]);
        assert_eq!(told.len(), violations, "{relation}");
    }
}

#[test]
fn a_window_behind_the_end_is_not_reached() {
    let (watch, _) = evaluate("[[assert]]\nname = \"a\"\nmetric = \"tracking\"\nmax = 1\nfrom = 1000", &[APART]);
    assert!(watch.findings().ok() && watch.findings().table(None).contains("not reached"));
}

#[test]
fn assertions_are_about_the_variants_that_they_name() {
    let about = |variants: &str| {
        let assertion = format!("[[assert]]\nname = \"a\"\nmetric = \"gap\"\nmin = 0\nvariants = {variants}");
        read(&drones(&assertion)).expect("valid").len()
    };
    assert_eq!((about("[\"TSC\"]"), about("[\"TOC\"]"), about("[\"TOC\", \"TSC\"]")), (1, 0, 1));
}

#[test]
fn mistakes_have_a_place_and_a_remedy() {
    let cases = [
        ("metric = \"gap\"\nmin = 0", "assert.1: missing field `name`"),
        ("name = \"a\"\nmin = 0", "assert.1: expected a `signal`"),
        ("name = \"a\"\nmetric = \"gap\"", "assert.1: expected a bound"),
        ("name = \"a\"\nmetric = \"gab\"\nmin = 0", "did you mean `gap`?"),
        ("name = \"a\"\nmetric = \"gap\"\nsignal = \"t\"\nmin = 0", "either `signal` or `metric`"),
        ("name = \"a\"\nsignal = \"norm(state.positoin)\"\nmin = 0", "did you mean `position`? (column 6 of "),
        ("name = \"a\"\nsignal = \"norm(stat.position)\"\nmin = 0", "did you mean `state`?"),
        ("name = \"a\"\nsignal = \"state.position\"\nmin = 0", "found a vector of 6"),
        ("name = \"a\"\nsignal = \"state.position[6]\"\nmin = 0", "within the 6 values of state.position"),
        ("name = \"a\"\nsignal = \"state.position[4:2]\"\nmin = 0", "within the 6 values"),
        (
            "name = \"a\"\nsignal = \"norm(state.position - reference.position)\"\nmin = 0",
            "choose some of them, as in [0:3]",
        ),
        ("name = \"a\"\nsignal = \"gap\"", "expected a bound, `min`, `max` or both, or a comparison"),
        ("name = \"a\"\nsignal = \"gap > 1\"\nmin = 0", "expected a number, found a comparison"),
        ("name = \"a\"\nsignal = \"gap > 1 and\"", "found the end of the formula (column 12 of "),
        ("name = \"a\"\nsignal = \"gap > 1\"\nacross = \"sum\"", "assert.1.across: expected bounds"),
        ("name = \"a\"\nsignal = \"gap > radios\"", "found 'radios' (column 7 of "),
        ("name = \"a\"\nsignal = \"norm(1)\"\nmin = 0", "expected a field of a topic"),
        ("name = \"a\"\nsignal = \"1 + dist\"\nmin = 0", "expected a known name, found 'dist'"),
        ("name = \"a\"\nsignal = \"_0\"\nmin = 0", "expected a known name, found '_0'"),
        ("name = \"a\"\nmetric = \"obstacle_gap\"\nmin = 0", "needs a section `[obstacles]`"),
        ("name = \"a\"\nmetric = \"gap\"\nmin = 0\nfrom = -1", "assert.1.from: expected a time >= 0 s"),
        ("name = \"a\"\nmetric = \"gap\"\nmin = 0\nfrom = 2\nto = 1", "assert.1.to: expected a time >= 2 s"),
        ("name = \"a\"\nmetric = \"gap\"\nmin = 0\nagents = [7]", "numbers of agents from 1 to 6"),
        ("name = \"a\"\nmetric = \"gap\"\nmin = 0\nagents = []", "numbers of agents from 1 to 6"),
        ("name = \"a\"\nmetric = \"gap\"\nmin = 0\nvariants = [\"TSD\"]", "did you mean `TSC`?"),
        ("name = \"a\"\nmetric = \"gap\"\nmin = 2\nmax = 1", "expected a bound >= 2"),
        ("name = \"a\"\nmetric = \"gap\"\nmax = \"UM\"", "sets no limit vehicle.UM"),
        ("name = \"a\"\nmetric = \"gap\"\nmax = \"1/0\"", "expected a finite bound"),
        ("name = \"a\"\nmetric = \"gap\"\nmin = 0\nseverity = \"error\"", "assert.1.severity"),
        ("name = \"a\"\nmetric = \"gap\"\nmin = 0\nmox = 3", "assert.1.mox: unknown field"),
        (
            "name = \"a\"\nmetric = \"gap\"\nmin = 0\n[[assert]]\nname = \"a\"\nmetric = \"gap\"\nmin = 1",
            "another assertion has this name",
        ),
    ];
    for (assertion, expected) in cases {
        let message = mistake(assertion);
        assert!(message.contains(expected), "missing {expected:?} in\n{message}");
        assert!(message.starts_with("uav.toml:"), "{message}");
    }
}

#[test]
fn messages_are_those_of_ros() {
    let (watch, told) = evaluate("[[assert]]\nname = \"ab\"\nsignal = \"state.position[0]\"\nmax = 1", &[APART]);
    let message = message::encode(&watch.findings().0[0], &told[0].1, 2_000_000_005);
    let bytes = message.bytes();
    assert_eq!(bytes[..4], [0, 1, 0, 0]);
    assert_eq!(bytes[4..12], [2, 0, 0, 0, 5, 0, 0, 0]);
    assert_eq!(bytes[12], 40);
    // The name follows on the next multiple of four behind the encapsulation.
    assert_eq!(bytes[16..20], 19u32.to_le_bytes());
    assert_eq!(&bytes[20..39], b"phalanx.assertions\0");
    let text = "ab: agent 2 at t = 0 s: state.position[0] = 10 > 1\0";
    assert_eq!(bytes[40..44], (text.len() as u32).to_le_bytes());
    assert_eq!(&bytes[44..44 + text.len()], text.as_bytes());
}
