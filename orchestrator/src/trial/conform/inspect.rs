//! Findings about the outputs of a program.

use std::time::Duration;

use lockstep::{ChannelId, Network};

use super::test_run::TestRun;

/// An interval in which all numbers of a field have to lie.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// The field.
    pub field: String,
    /// The least that is allowed.
    pub low: f64,
    /// The most that is allowed.
    pub high: f64,
}

/// Names of the numbers that a node publishes in a step: field, and field with its index.
pub(super) fn labels(network: &Network, node: usize) -> Vec<(String, String)> {
    let outputs = network.nodes[node].outputs.iter();
    let of_channel = |&ChannelId(channel): &ChannelId| {
        let (topic, layout) = (&network.channels[channel].topic, &network.channels[channel].layout);
        let names = layout.fields().iter().flat_map(|field| vec![field.name.clone(); field.shape.words()]);
        names.enumerate().map(|(word, name)| (name, format!("{topic} {}", layout.label(word)))).collect::<Vec<_>>()
    };
    outputs.flat_map(of_channel).collect()
}

/// The fields that are zero at every step, where the recorded ones are not.
pub(super) fn zeros<'a>(run: &TestRun, labels: &'a [(String, String)]) -> Vec<&'a str> {
    let is_zero = |numbers: &[f64], field: &str| {
        let mut of_field = numbers.iter().zip(labels.iter().cycle()).filter(|(_, (name, _))| name == field);
        of_field.all(|(number, _)| *number == 0.0)
    };
    let mut fields: Vec<&str> = labels.iter().map(|(field, _)| field.as_str()).collect();
    fields.dedup();
    fields.retain(|field| is_zero(&run.outputs, field) && !is_zero(&run.recorded, field));
    fields
}

/// The first number that is out of its range.
pub(super) fn out_of_range(run: &TestRun, labels: &[(String, String)], ranges: &[Range]) -> Option<String> {
    for (index, number) in run.outputs.iter().enumerate() {
        let (field, label) = &labels[index % labels.len()];
        let wrong = |range: &&Range| range.field == *field && !(range.low..=range.high).contains(number);
        if let Some(Range { low, high, .. }) = ranges.iter().find(wrong) {
            return Some(format!("{label} is {number} at step {}, not within {low} ... {high}", index / labels.len()));
        }
    }
    None
}

/// The first number that differs between two runs.
pub(super) fn unlike(first: &TestRun, second: &TestRun, labels: &[(String, String)]) -> Option<String> {
    let pairs = first.outputs.iter().zip(&second.outputs);
    let (index, (a, b)) = pairs.enumerate().find(|(_, (a, b))| a.to_bits() != b.to_bits())?;
    let (step, label) = (index / labels.len(), &labels[index % labels.len()].1);
    Some(format!("{label} at step {step} is {a:e} once and {b:e} another time"))
}

/// How far the outputs are from those of the reference, which were recorded.
pub(super) fn departure(run: &TestRun) -> String {
    let departures = &run.departures;
    match &departures.first {
        None => format!("all {} numbers are those that were recorded, bit by bit", departures.numbers),
        Some(first) => {
            let worst = departures.fields().max_by(|a, b| a.largest.total_cmp(&b.largest));
            let worst =
                worst.map(|worst| format!("; at most by {:.3e} in {} {}", worst.largest, worst.topic, worst.field));
            format!(
                "{} of {} numbers differ, first at step {} in {} {}{}",
                departures.differing,
                departures.numbers,
                first.step,
                first.topic,
                first.field,
                worst.unwrap_or_default()
            )
        }
    }
}

/// How long steps take, compared with the period of `dt` seconds.
pub(super) fn speed(lengths: &[Duration], dt: f64) -> String {
    let mut lengths: Vec<f64> = lengths.iter().map(Duration::as_secs_f64).collect();
    lengths.sort_by(f64::total_cmp);
    let Some(last) = lengths.len().checked_sub(1) else { return "it was not measured".into() };
    let (median, most) = (lengths[last / 2], lengths[last * 99 / 100]);
    let verdict = if most <= dt { "in real time it keeps up" } else { "in real time it does not keep up" };
    format!(
        "{:.1} us in the median, {:.1} us for 99 % of the steps, of a period of {:.1} us: {verdict}",
        median * 1e6,
        most * 1e6,
        dt * 1e6
    )
}
