//! From the signals of a log to what a plot shows.

use formation::wiring::Assembly;

use super::catalog::{Across, Quantity};
use crate::catalog::Catalog;
use crate::judge::assertions::history;
use crate::judge::metrics::{Run, norm_between};
use recording::Log;

/// What a plot shows of a run of `variant`: the place of an agent, from 0, and its values at all samples; a single one, at place 0,
/// for what all agents are together.
///
/// # Errors
/// In words, if the log does not hold it.
pub(super) fn histories(
    catalog: &Catalog,
    plot: &Quantity,
    variant: &str,
    assembly: &Assembly,
    log: &Log,
) -> Result<Vec<(usize, Vec<f64>)>, String> {
    if let Some(pair) = plot.pair {
        return Ok(vec![(0, distance(pair, log)?)]);
    }
    let places: Vec<usize> = match &plot.agents {
        Some(numbers) => numbers.iter().map(|number| number - 1).collect(),
        None => (0..assembly.scenario.context.agents.len()).collect(),
    };
    let signal = plot.instead.get(variant).or(plot.signal.as_ref());
    let each: Vec<Vec<f64>> = match (&plot.derived, signal) {
        (Some(derived), _) => {
            let signal = catalog.signal(derived).ok_or_else(|| format!("there is no derived signal `{derived}`"))?;
            let mut all = (signal.compute)(&Run::new(&assembly.scenario, log)).map_err(|error| error.to_string())?;
            places.iter().map(|&place| std::mem::take(&mut all[place])).collect()
        }
        (None, Some(signal)) => {
            places.iter().map(|&place| history(signal, assembly, log, place)).collect::<Result<_, _>>()?
        }
        (None, None) => return Err("it says not what it shows".into()),
    };
    let together = |of: &dyn Fn(&mut dyn Iterator<Item = f64>) -> f64| {
        let samples = each.first().map_or(0, Vec::len);
        vec![(0, (0..samples).map(|sample| of(&mut each.iter().map(|values| values[sample]))).collect())]
    };
    Ok(match plot.across {
        Across::Each => places.into_iter().zip(each).collect(),
        Across::Norm => together(&|values| values.map(|value| value * value).sum::<f64>().sqrt()),
        Across::Sum => together(&|values| values.sum()),
    })
}

/// The distance of two agents, by their numbers, in the plane.
fn distance(pair: [usize; 2], log: &Log) -> Result<Vec<f64>, String> {
    let [a, b] = pair.map(|number| {
        let topic = format!("/agent_{number}/state");
        log.signal(&topic, "position").ok_or(format!("the log has no positions in {topic}"))
    });
    Ok(a?.rows().zip(b?.rows()).map(|(a, b)| norm_between(&a[..2], &b[..2])).collect())
}

/// The integral over time, by the rule of trapezia.
pub(super) fn integrated(values: &mut [f64], dt: f64) {
    let (mut sum, mut before) = (0.0, None);
    for value in values {
        sum += before.map_or(0.0, |before: f64| 0.5 * dt * (before + *value));
        before = Some(std::mem::replace(value, sum));
    }
}
