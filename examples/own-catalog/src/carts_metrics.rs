//! What a run of carts is worth: three numbers, for the bands under `[expect]` of a scenario.

use formation::wiring::Role;
use orchestrator::judge::metrics::{Metric, MetricError, Run, first_below_for_good, maximum, maximum_from, norm};

/// A tip as near to its place as this is there, m.
const THERE: f64 = 0.1;

/// Computes them from the log of a run. A signal that the log does not have is reported by its name.
pub fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let deviations = run.signals(Role::Controller, "deviation")?;
    let inputs = run.signals(Role::Controller, "input")?;
    let farthest = run.history(|k| maximum(deviations.iter().map(|deviation| norm(deviation.row(k)))));
    let force = run.history(|k| maximum(inputs.iter().map(|input| input.row(k)[0].abs())));
    let there = first_below_for_good(&farthest, THERE);
    Ok(vec![
        // How far the farthest tip is from its place, at worst, in the last quarter of the run, m.
        Metric::new("miss", maximum_from(&farthest, run.last_quarter())),
        // From when on all tips are there, s.
        Metric::new("t_there", there.map_or(f64::NAN, |k| run.time(k))),
        // The largest force, N.
        Metric::new("max_force", maximum(force)),
    ])
}
