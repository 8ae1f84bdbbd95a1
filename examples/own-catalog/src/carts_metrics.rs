//! What a run of carts is worth: three numbers, for the regression ranges under `[expect]` of a scenario.

use formation::wiring::Role;
use orchestrator::judge::metrics::{
    Definition, Metric, MetricError, Run, first_below_for_good, maximum, maximum_from, norm,
};

/// A tip as near to its place as this is there, m.
const THERE: f64 = 0.1;

/// What they mean: symbol, unit and a sentence, for `check --explain` and the report.
pub const DEFINITIONS: &[Definition] = &[
    Definition::new(
        "miss",
        "max ‖δ_i‖",
        "m",
        "How far the farthest tip is from its place, largest in the last quarter.",
    ),
    Definition::new("t_there", "t(‖δ_i‖ ≤ 0.1)", "s", "Time from which on every tip stays within 10 cm of its place."),
    Definition::new("max_force", "max |F|", "N", "Largest force of any cart."),
];

/// Computes them from the log of a run. A signal that the log does not have is reported by its name.
pub fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let deviations = run.signals(Role::Controller, "deviation")?;
    let inputs = run.signals(Role::Controller, "input")?;
    let farthest = run.history(|k| maximum(deviations.iter().map(|deviation| norm(deviation.row(k)))));
    let force = run.history(|k| maximum(inputs.iter().map(|input| input.row(k)[0].abs())));
    let there = first_below_for_good(&farthest, THERE);
    Ok(vec![
        Metric::new("miss", maximum_from(&farthest, run.last_quarter())),
        Metric::new("t_there", there.map_or(f64::NAN, |k| run.time(k))),
        Metric::new("max_force", maximum(force)),
    ])
}
