use lockstep::Timing;

use crate::config::Problem;
use crate::scenario::Selection;
use crate::wiring::{Assembly, Role, Roles};

const TEXT: &str = r#"
name = "own"
agents = [
    { position = [0, 0, 0], m = 1 },
    { position = [2, 0, 0], m = 1 },
    { position = [0, 2, 0], m = 1 },
]
[timing]
dt = 0.1
duration = 1
[vehicle]
kind = "integrator"
[topology]
b = 1
[reference]
position = ["t", 2, 3]
[plant]
kind = "external"
signals = { imu = { size = 6, unit = "m/s^2, rad/s" } }
[planner]
kind = "external"
[controller]
kind = "external"
signals = { plan = { size = 2, initial = [3, 4] }, cost = 1 }
"#;

fn load(text: &str) -> Result<Assembly, Vec<Problem>> {
    Assembly::load("own.toml", text, &Selection::default(), &Roles::NONE)
}

fn refused(from: &str, to: &str) -> String {
    assert!(TEXT.contains(from), "{from}");
    let problems = load(&TEXT.replacen(from, to, 1)).err().expect("a problem");
    problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n\n")
}

/// What a participant reads, `command 3 delayed`.
fn inputs(assembly: &Assembly, node: &str) -> Vec<String> {
    let node = assembly.network.nodes.iter().find(|known| known.name == node).expect("a node");
    let word = |timing| if timing == Timing::Delayed { " before" } else { "" };
    let text =
        |input: &lockstep::Input| format!("{}{}", assembly.network.channels[input.channel.0].topic, word(input.timing));
    node.inputs.iter().map(text).collect()
}

#[test]
fn signals_are_published_behind_the_standard_ones() {
    let assembly = load(TEXT).unwrap();
    let fields = |topic: &str| {
        let channel = assembly.network.channels.iter().find(|channel| channel.topic == topic).unwrap();
        let field = |field: &lockstep::Field| format!("{} {} {}", field.name, field.shape.words(), field.unit);
        channel.layout.fields().iter().map(field).collect::<Vec<_>>()
    };
    assert_eq!(fields("/agent_2/state"), ["position 3 m, m, rad", "velocity 3 m/s, m/s, rad/s", "imu 6 m/s^2, rad/s"]);
    assert_eq!(fields("/agent_1/reference"), ["position 3 ", "velocity 3 ", "acceleration 3 "]);
    assert_eq!(fields("/agent_3/command"), ["input 3 m/s^2, m/s^2, rad/s^2", "cost 1 ", "plan 2 "]);
    assert!(assembly.is_external(Role::Plant) && !assembly.is_external(Role::Observer));
}

#[test]
fn what_is_usually_read_is_of_the_neighbourhood() {
    let assembly = load(TEXT).unwrap();
    // A ring: agent 1 receives from agent 3.
    assert_eq!(
        inputs(&assembly, "controller_1"),
        [
            "/agent_1/state",
            "/agent_3/state",
            "/agent_1/reference",
            "/agent_3/reference",
            "/agent_1/command before",
            "/agent_3/command before"
        ]
    );
    assert_eq!(inputs(&assembly, "plant").len(), 6);
    assert!(inputs(&assembly, "planner").iter().all(|input| input.ends_with(" before")));
}

#[test]
fn delayed_readers_see_the_initial_values_first() {
    let assembly = load(TEXT).unwrap();
    let initial =
        |topic: &str| assembly.network.channels.iter().find(|channel| channel.topic == topic).unwrap().initial.clone();
    assert_eq!(initial("/agent_2/command"), [0.0, 0.0, 0.0, 0.0, 3.0, 4.0]);
    assert_eq!(initial("/agent_2/reference"), [0.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(initial("/agent_2/state")[..3], [2.0, 0.0, 0.0]);
}

#[test]
fn reads_replaces_what_is_usually_read() {
    let text = TEXT.replace("cost = 1 }", "cost = 1 }\nreads = [\"plant.2\", \"all.controller@before\"]");
    let assembly = load(&text).unwrap();
    let expected = ["/agent_2/state", "/agent_1/command before", "/agent_2/command before", "/agent_3/command before"];
    assert_eq!(inputs(&assembly, "controller_1"), expected);
}

#[test]
fn a_loop_is_printed_with_the_advice() {
    let message = refused("cost = 1 }", "cost = 1 }\nreads = [\"plant\", \"neighbours.controller\"]");
    assert!(message.contains("controller.reads"), "{message}");
    assert!(message.contains("controller_2 -> controller_3 -> controller_1 -> controller_2"), "{message}");
    assert!(message.contains("`@before`"), "{message}");
}

#[test]
fn mistakes_have_their_place_and_what_is_expected() {
    for (from, to, place, expected) in [
        ("imu = {", "Imu = {", "plant.signals.Imu", "lower-case letters, digits and single underscores"),
        ("imu = {", "stamp = {", "plant.signals.stamp", "in its header"),
        ("imu = {", "velocity = {", "plant.signals.velocity", "is a standard signal of a plant"),
        ("size = 6", "size = 0", "plant.signals.imu.size", "a size from 1 to 512, found 0"),
        (
            "size = 6",
            "size = 510",
            "plant.signals",
            "at most 512 numbers, and all signals of agent 1 together have 516",
        ),
        ("size = 6", "sise = 6", "plant.signals.imu", "did you mean `size`?"),
        ("cost = 1", "cost = -1", "controller.signals.cost", "a size from 1 to 512"),
        ("cost = 1", "cost = \"1\"", "controller.signals.cost", "expected a size such as 6, or a table such as"),
        ("[3, 4]", "[3]", "controller.signals.plan.initial", "expected 2 numbers, as `size` says, found 1"),
        ("\"m/s^2, rad/s\"", "\"m\\ns\"", "plant.signals.imu.unit", "a unit in one line"),
        ("cost = 1 }", "cost = 1 }\nread = []", "controller.read", "did you mean `reads`?"),
        (
            "cost = 1 }",
            "cost = 1 }\nreads = [\"observer\"]",
            "controller.reads",
            "reads the observer, but this scenario has none",
        ),
        (
            "cost = 1 }",
            "cost = 1 }\nreads = [\"plant\", \"plant.4\"]",
            "controller.reads.2",
            "there is no agent 4; the scenario has 3",
        ),
        ("cost = 1 }", "cost = 1 }\nreads = [\"neighbors.plant\"]", "controller.reads.1", "did you mean `neighbours`?"),
        (
            "[planner]\nkind = \"external\"",
            "[planner]\nkind = \"external\"\nstandard = false",
            "planner.standard",
            "publishes nothing",
        ),
        ("[planner]\nkind = \"external\"", "[planner]\nkind = \"exernal\"", "planner.kind", "did you mean `external`?"),
    ] {
        let message = refused(from, to);
        assert!(message.contains(&format!("{place}:")), "{to}: {message}");
        assert!(message.contains(expected), "{to}: {message}");
    }
}
