//! A signal over a whole run, for figures.

use formation::formula::Formula;
use formation::wiring::Assembly;
use lockstep::{Channel, ChannelId};

use super::geometry::Geometry;
use super::signal::number;
use super::slot::Slot;
use recording::Log;

/// The values of the signal `text` of the agent at this place, one for each recorded step.
///
/// # Errors
/// What is wrong with the signal, or that the log does not hold what it needs.
pub(crate) fn history(text: &str, assembly: &Assembly, log: &Log, agent: usize) -> Result<Vec<f64>, String> {
    let (formula, slots) = compiled(text, assembly, agent)?;
    let of_channel =
        |channel: &Channel| log.samples(&channel.topic).filter(|samples| samples.width() == channel.layout.words());
    let channels: Vec<_> = assembly.network.channels.iter().map(of_channel).collect();
    let dt = assembly.scenario.context.timing.dt;
    let mut values = vec![0.0; slots.len()];
    let mut value = |row: usize, step: u64| {
        let sample = |channel: ChannelId| channels[channel.0].map_or(&[][..], |samples| samples.row(row));
        for (place, slot) in values.iter_mut().zip(&slots) {
            *place = slot.value(step as f64 * dt, &sample);
        }
        formula.evaluate(&values)
    };
    match channels.iter().position(Option::is_none) {
        Some(missing) => Err(format!("the log has no topic {}", assembly.network.channels[missing].topic)),
        None => Ok(log.steps().enumerate().map(|(row, step)| value(row, step)).collect()),
    }
}

/// The signal as a formula and what fills its slots.
fn compiled(text: &str, assembly: &Assembly, agent: usize) -> Result<(Formula, Vec<Slot>), String> {
    number(text, assembly, &Geometry::new(assembly), agent).map_err(|error| error.within(text))
}

/// Whether the signal `text` of the agent at this place means anything in this scenario.
///
/// # Errors
/// What is wrong with it.
#[cfg(test)]
pub(crate) fn check(text: &str, assembly: &Assembly, agent: usize) -> Result<(), String> {
    compiled(text, assembly, agent).map(|_| ())
}
