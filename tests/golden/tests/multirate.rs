//! The variant of the drones at two rates.

use formation::scenario::Selection;
use formation::wiring::Assembly;
use lockstep::{ChannelId, Local};
use schemes::{ROLES, SCENARIOS};

/// The position loop runs at every tenth step and what it asks for stands in between; the attitude loop runs at every step.
#[test]
fn the_position_loop_is_ten_times_slower() {
    let shipped = SCENARIOS.iter().find(|shipped| shipped.name == "uav").expect("the drones");
    let selection = Selection { variant: Some("multirate".into()), ..Selection::default() };
    let assembly =
        Assembly::load(shipped.file, shipped.text, &selection, &ROLES).unwrap_or_else(|p| panic!("{}", p[0]));
    let nodes: Vec<usize> = (0..assembly.network.nodes.len()).collect();
    let participants = assembly.participants(&nodes).unwrap_or_else(|problems| panic!("{}", problems[0]));
    let channels = &assembly.network.channels;
    let channel = channels.iter().position(|channel| channel.topic == "/agent_2/command").expect("the command");
    let find = |name| channels[channel].layout.find(name).expect("a field");
    let (reference, input) = (find("attitude_reference"), find("input"));
    let mut local = Local::new(assembly.network.clone(), participants, 0.001).expect("no loop");
    let mut before: Option<(Vec<f64>, Vec<f64>)> = None;
    for step in 0..200 {
        local.step().expect("no fault");
        let sample = local.store().read(ChannelId(channel), step);
        let part = |(start, length): (usize, usize)| sample[start..start + length].to_vec();
        let now = (part(reference), part(input));
        if let Some(before) = before.replace(now.clone()) {
            assert_eq!(before.0 != now.0, step % 10 == 0, "attitude reference at step {step}");
            assert_ne!(before.1[1..], now.1[1..], "torques at step {step}");
        }
    }
}
