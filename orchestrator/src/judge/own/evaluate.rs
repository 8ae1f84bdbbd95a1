//! Evaluating the metrics of a scenario on a log.

use std::path::Path;

use formation::wiring::Assembly;
use lockstep::ChannelId;
use recording::{Head, Log, Stream};

use super::{OwnMetric, Reduction, read};
use crate::judge::JudgeError;
use crate::judge::metrics::{Definition, Metric};

/// The values of the metrics that the scenario of `assembly` defines, and of its default set, with what they mean.
///
/// # Errors
/// What is wrong with the metrics; they have been checked before the run.
pub fn of_log(assembly: &Assembly, log: &Log) -> Result<Vec<(Metric, Definition)>, JudgeError> {
    let mut metrics = read(assembly)?;
    let channels: Vec<_> = assembly
        .network
        .channels
        .iter()
        .map(|channel| log.samples(&channel.topic).filter(|samples| samples.width() == channel.layout.words()))
        .collect();
    if channels.iter().any(Option::is_none) {
        return Ok(Vec::new());
    }
    let dt = assembly.scenario.context.timing.dt;
    let mut slots = Vec::new();
    for (row, step) in log.steps().enumerate() {
        let sample = |channel: ChannelId| channels[channel.0].map_or(&[][..], |samples| samples.row(row));
        advance(&mut metrics, step, dt, &sample, &mut slots);
    }
    Ok(results(metrics))
}

/// The same from the log `path`, step by step, in no more memory than a few chunks take.
///
/// # Errors
/// As those of [`of_log`], and [`JudgeError::Log`] if the log cannot be read.
pub fn stream(assembly: &Assembly, path: &Path) -> Result<Vec<(Metric, Definition)>, JudgeError> {
    let mut metrics = read(assembly)?;
    if metrics.iter().all(|metric| metric.reductions.is_empty()) {
        return Ok(results(metrics));
    }
    let head = Head::read(path)?;
    let mut topics = Vec::new();
    for channel in &assembly.network.channels {
        let is_it = |(topic, layout): &&(String, lockstep::Layout)| {
            *topic == channel.topic && layout.words() == channel.layout.words()
        };
        let Some(known) = head.topics.iter().find(is_it) else { return Ok(Vec::new()) };
        topics.push(known.clone());
    }
    let dt = assembly.scenario.context.timing.dt;
    let mut stream = Stream::open(path, &topics)?;
    let mut slots = Vec::new();
    while stream.advance()? {
        let step = stream.step().unwrap_or_default();
        advance(&mut metrics, step, dt, &|channel: ChannelId| stream.words(channel.0), &mut slots);
    }
    Ok(results(metrics))
}

pub(super) fn advance<'s>(
    metrics: &mut [OwnMetric],
    step: u64,
    dt: f64,
    sample: &impl Fn(ChannelId) -> &'s [f64],
    slots: &mut Vec<f64>,
) {
    for reduction in metrics.iter_mut().flat_map(|metric| &mut metric.reductions) {
        reduction.step(step, dt, sample, slots);
    }
}

pub(super) fn results(metrics: Vec<OwnMetric>) -> Vec<(Metric, Definition)> {
    let result = |metric: OwnMetric| {
        let values: Vec<f64> = metric.reductions.iter().map(Reduction::result).collect();
        (Metric::new(metric.id, metric.value.evaluate(&values)), metric.definition)
    };
    metrics.into_iter().map(result).collect()
}
