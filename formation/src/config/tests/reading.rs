use std::collections::BTreeMap;

use serde::Deserialize;

use super::*;

#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Gate {
    Open,
    Ramp { from: f64, to: f64 },
    Circle(Circle),
    Pair(f64, f64),
}

#[derive(Debug, PartialEq, Deserialize)]
struct Circle {
    radius: f64,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(try_from = "f64")]
struct Positive(f64);

impl TryFrom<f64> for Positive {
    type Error = String;

    fn try_from(value: f64) -> Result<Self, String> {
        if value > 0.0 { Ok(Self(value)) } else { Err(format!("expected a positive number, found {value}")) }
    }
}

#[derive(Debug, PartialEq, Deserialize)]
struct Agent {
    position: [f64; 3],
    mass: Option<Positive>,
}

#[derive(Debug, PartialEq, Deserialize)]
struct Everything {
    name: String,
    seed: u64,
    workers: u8,
    fast: bool,
    dt: Positive,
    gate: Gate,
    parameters: BTreeMap<String, f64>,
    pair: (String, i32),
    #[serde(default)]
    every: Option<u32>,
    agents: Vec<Agent>,
}

const GOOD: &str = "
name = 'x'
seed = 3
workers = 255
fast = true
dt = 1
gate = 'open'
pair = ['a', -1]
[parameters]
phase = 'pi/4'
[[agents]]
position = [1, 2.5, '-2*pi/3']
";

#[test]
fn good_values_are_read() {
    let value = value_of::<Everything>(GOOD);
    assert_eq!(value.dt, Positive(1.0));
    assert_eq!(value.parameters["phase"], std::f64::consts::FRAC_PI_4);
    assert_eq!(value.agents[0].position, [1.0, 2.5, -2.0 * std::f64::consts::PI / 3.0]);
    assert_eq!((value.every, value.workers, value.pair), (None, 255, ("a".into(), -1)));
}

#[test]
fn every_mistake_of_a_file_is_reported() {
    let text = "
        name = 3
        seed = -3
        workers = 256
        fast = 'yes'
        dt = 0
        gate = 'opn'
        pair = ['a']
        evry = 1
        parameters.phase = 'pi/'
        agents = [{ position = [1, 2] }, { position = [1, 'x', 3], mass = -1 }, { mass = 1 }]
        ";
    let problems = problems_of::<Everything>(text);
    let found: Vec<String> = problems.iter().map(|p| format!("{}: {}", p.path, p.message)).collect();
    assert_eq!(
        found,
        [
            "name: expected a string, found the integer 3",
            "seed: expected an integer that is not negative, found the integer -3",
            "workers: expected an integer from 0 to 255, found the integer 256",
            "fast: expected true or false, found the string \"yes\"",
            "dt: expected a positive number, found 0",
            "gate: unknown name \"opn\"",
            "pair: expected 2 values, found 1",
            "evry: unknown field",
            "parameters.phase: expected a number, found the string \"pi/\"",
            "agents.1.position: expected 3 values, found 2",
            "agents.2.position.2: expected a number, found the string \"x\"",
            "agents.2.mass: expected a positive number, found -1",
            "agents.3: missing field `position`",
        ]
    );
    assert_eq!(problems[5].help.as_deref(), Some("expected one of open, ramp, circle, pair; did you mean `open`?"));
}

#[test]
fn every_missing_field_is_reported() {
    assert_eq!(problems_of::<Everything>("").len(), 9);
}

#[test]
fn numbers_keep_to_their_types() {
    assert_eq!(only::<BTreeMap<String, u64>>("a = 3.0"), "a: expected an integer, found the number 3.0");
    assert_eq!(
        only::<BTreeMap<String, i8>>("a = 200"),
        "a: expected an integer from -128 to 127, found the integer 200"
    );
    assert_eq!(
        only::<BTreeMap<String, f64>>("a = '1/0'"),
        "a: expected a number, found the string \"1/0\" | as a formula: its value is inf"
    );
    assert_eq!(value_of::<BTreeMap<String, f64>>("a = inf")["a"], f64::INFINITY);
    assert_eq!(value_of::<BTreeMap<String, char>>("a = 'x'")["a"], 'x');
    assert!(only::<BTreeMap<String, char>>("a = 'xy'").contains("a string of one character"));
}

#[test]
fn enums_are_read_in_each_notation() {
    let gate = |text: &str| value_of::<BTreeMap<String, Gate>>(text).remove("g").unwrap();
    assert_eq!(gate("g = 'open'"), Gate::Open);
    assert_eq!(gate("g = { kind = 'open' }"), Gate::Open);
    assert_eq!(gate("g = { kind = 'ramp', from = 0, to = 1 }"), Gate::Ramp { from: 0.0, to: 1.0 });
    assert_eq!(gate("g = { ramp = { from = 0, to = 1 } }"), Gate::Ramp { from: 0.0, to: 1.0 });
    assert_eq!(gate("g = { kind = 'circle', radius = 2 }"), Gate::Circle(Circle { radius: 2.0 }));
    assert_eq!(gate("g = { circle = { radius = 2 } }"), Gate::Circle(Circle { radius: 2.0 }));
    assert_eq!(gate("g = { pair = [1, 2] }"), Gate::Pair(1.0, 2.0));
}

#[test]
fn mistakes_in_enums_are_placed() {
    let only = only::<BTreeMap<String, Gate>>;
    let expected = "expected one of open, ramp, circle, pair";
    assert_eq!(only("g = 1"), "g: expected a name, found the integer 1");
    assert_eq!(only("g = { kind = 1 }"), "g.kind: expected a name, found the integer 1");
    assert_eq!(
        only("g = { kind = 'rmap' }"),
        format!("g.kind: unknown name \"rmap\" | {expected}; did you mean `ramp`?")
    );
    assert_eq!(only("g = { rmap = {} }"), format!("g.rmap: unknown name \"rmap\" | {expected}; did you mean `ramp`?"));
    assert_eq!(only("g = {}"), format!("g: missing field `kind` | {expected}"));
    assert_eq!(
        only("g = 'ramp'"),
        "g: ramp needs parameters, found only its name | write { kind = \"ramp\", ... } instead of the string \"ramp\""
    );
    assert_eq!(only("g = { kind = 'ramp', from = 1 }"), "g: missing field `to`");
    assert_eq!(
        only("g = { ramp = { from = 1, to = 'x' } }").split(" | ").next(),
        Some("g.ramp.to: expected a number, found the string \"x\"")
    );
    assert_eq!(only("g = { kind = 'circle', radius = true }"), "g.radius: expected a number, found the boolean true");
    assert_eq!(only("g = { circle = 1 }"), "g.circle: expected a table with radius, found the integer 1");
    assert_eq!(only("g = { kind = 'open', x = 1 }"), "g.x: unknown field | no fields are expected here");
    assert_eq!(only("g = { open = { x = 1 } }"), "g.open.x: unknown field | no fields are expected here");
}

#[test]
fn mistakes_below_a_condition_hide_the_condition() {
    #[derive(Deserialize)]
    struct Bounds {
        low: f64,
        high: f64,
    }

    #[derive(Debug, Deserialize)]
    #[serde(try_from = "Bounds")]
    struct Range;

    impl TryFrom<Bounds> for Range {
        type Error = &'static str;

        fn try_from(bounds: Bounds) -> Result<Self, &'static str> {
            if bounds.low < bounds.high { Ok(Range) } else { Err("expected low < high") }
        }
    }

    assert_eq!(only::<BTreeMap<String, Range>>("r = { low = 2, high = 1 }"), "r: expected low < high");
    assert_eq!(
        only::<BTreeMap<String, Range>>("r = { low = 2, high = true }"),
        "r.high: expected a number, found the boolean true"
    );
}

#[test]
fn buffered_types_work_as_a_whole() {
    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(untagged)]
    enum Either {
        Number(f64),
        Table { x: f64 },
    }

    assert_eq!(value_of::<BTreeMap<String, Either>>("a = 3")["a"], Either::Number(3.0));
    assert_eq!(value_of::<BTreeMap<String, Either>>("a = { x = 3 }")["a"], Either::Table { x: 3.0 });
    assert!(only::<BTreeMap<String, Either>>("a = true").starts_with("a: data did not match any variant"));
}

#[test]
fn endless_types_and_impossible_conditions_do_not_hang() {
    #[derive(Debug, Deserialize)]
    #[allow(dead_code)]
    struct Endless {
        inner: Box<Endless>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(try_from = "f64")]
    struct Impossible;

    impl TryFrom<f64> for Impossible {
        type Error = &'static str;

        fn try_from(_: f64) -> Result<Self, &'static str> {
            Err("never right")
        }
    }

    assert_eq!(only::<Endless>("inner = 1"), "inner: expected a table with inner, found the integer 1");
    assert_eq!(only::<BTreeMap<String, Impossible>>("a = 1"), "a: never right");
    let many: String = (0..5000).map(|number| format!("a{number} = true\n")).collect();
    let problems = problems_of::<BTreeMap<String, f64>>(&many);
    assert!(problems.len() > 100);
    assert_eq!(problems.last().unwrap().message, "too many mistakes, further ones are not listed");
}

#[test]
fn paths_begin_where_the_caller_says() {
    let node = parsed("[controller]\nradius = true\n");
    let mut problems = Problems::default();
    assert!(read::<Circle>(node.at("controller").unwrap(), "controller", &mut problems).is_none());
    assert_eq!(problems.into_vec()[0].path, "controller.radius");
}

#[test]
fn per_agent_numbers_come_in_three_notations() {
    let resolve = |text: &str| value_of::<BTreeMap<String, PerAgent>>(text)["a"].resolve(3, &[1, 2, 3]);
    assert_eq!(resolve("a = 2"), Ok(vec![2.0; 3]));
    assert_eq!(resolve("a = [1, 2.5, 'pi']"), Ok(vec![1.0, 2.5, std::f64::consts::PI]));
    assert_eq!(resolve("a = '0.5*i'"), Ok(vec![0.5, 1.0, 1.5]));
    assert_eq!(resolve("a = 'i*N'"), Ok(vec![3.0, 6.0, 9.0]));
    assert_eq!(resolve("a = [1, 2]"), Err("expected 3 values, one for each agent, found 2".into()));
    assert_eq!(resolve("a = '1/(i-2)'"), Err("the value of \"1/(i-2)\" for agent 2 of 3 is inf".into()));
    assert!(only::<BTreeMap<String, PerAgent>>("a = 'k*i'").starts_with("a: not a formula of i and N: "));
    assert_eq!(only::<BTreeMap<String, PerAgent>>("a = [1, true]"), "a.2: expected a number, found the boolean true");
    assert!(only::<BTreeMap<String, PerAgent>>("a = true").starts_with("a: expected a number, a list of numbers, or"));
}
