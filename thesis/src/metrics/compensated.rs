//! Metrics of the scenario with the saturation compensator. (specification ch5-compensated, section 11)

use formation::wiring::Role;

use super::speed_formation::SpeedFormation;
use orchestrator::judge::metrics::{Definition, Metric, MetricError, Run, maximum, maximum_from, norm, norm_between};

/// Level below which every ‖Ẽ_i‖ has to settle; the bound of the thesis.
const UNCERTAINTY_LEVEL: f64 = 2.1e-3;
/// Level below which ‖e‖ has to settle.
const ERROR_LEVEL: f64 = 0.05;
/// End of the span in which oscillations count, s.
const TRANSIENT: f64 = 30.0;

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new(
        "b_Ẽ",
        "max ‖Ẽ_i‖",
        "m/s, rad/s",
        "Uncertainty against its estimate; worst robot, largest in the last quarter.",
    ),
    Definition::new("t_Ẽ", "t(‖Ẽ_i‖ ≤ 2.1e-3)", "s", "Time from which on every ‖Ẽ_i‖ stays below the thesis's bound."),
    Definition::new("b_x̃", "max ‖x_i − x̂_i‖", "m, rad", "Observation error; worst robot, largest in the last quarter."),
    Definition::new("b_ex", "‖e‖", "m, rad", "Local error; all robots, largest in the last quarter."),
    Definition::new("b_δ", "‖δ‖", "m, rad", "Formation error; all robots, largest in the last quarter."),
    Definition::new("t_ex", "t(‖e‖ ≤ 0.05)", "s", "Time from which on ‖e‖ stays below 0.05."),
    Definition::new("sat_end", "t", "s", "Last time at which a wheel is asked for more than its limit."),
    Definition::new(
        "b_ξ",
        "max ‖ξ_i‖",
        "m, rad",
        "Auxiliary variable of the compensator; worst robot, largest in the last quarter.",
    ),
    Definition::new("max_u", "max |u|", "m/s", "Largest wheel speed that is commanded."),
    Definition::new(
        "V_x",
        "V_x",
        "m",
        "Oscillation of the local errors along x in the first 30 s: total variation less net change, all robots.",
    ),
    Definition::new("V_y", "V_y", "m", "Oscillation of the local errors along y in the first 30 s, all robots."),
    Definition::new(
        "V_θ",
        "V_θ",
        "rad",
        "Oscillation of the local errors of the heading in the first 30 s, all robots.",
    ),
    Definition::new("V_x_{i}", "V_x", "m", "As `V_x`, of one robot."),
    Definition::new("V_y_{i}", "V_y", "m", "As `V_y`, of one robot."),
    Definition::new("V_θ_{i}", "V_θ", "rad", "As `V_θ`, of one robot."),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let formation = SpeedFormation::read(run, Role::Observer, "disturbance")?;
    let position = run.signals(Role::Plant, "position")?;
    let estimated = run.signals(Role::Observer, "position")?;
    let auxiliary = run.signals(Role::Controller, "xi")?;
    let largest = |of: &dyn Fn(usize, usize) -> f64| run.history(|k| maximum((0..run.agents()).map(|i| of(i, k))));
    let quarter = run.last_quarter();
    let uncertainty = largest(&|i, k| formation.uncertainty_error(i, k));
    let observation = largest(&|i, k| norm_between(position[i].row(k), estimated[i].row(k)));
    let error = formation.stacked_error();
    let mut metrics = vec![
        Metric::new("b_Ẽ", maximum_from(&uncertainty, quarter)),
        Metric::new("t_Ẽ", formation.settled(&uncertainty, UNCERTAINTY_LEVEL)),
        Metric::new("b_x̃", maximum_from(&observation, quarter)),
        Metric::new("b_ex", maximum_from(&error, quarter)),
        Metric::new("b_δ", maximum_from(&formation.stacked_tracking_error(), quarter)),
        Metric::new("t_ex", formation.settled(&error, ERROR_LEVEL)),
        Metric::new("sat_end", saturation_end(run)?),
        Metric::new("b_ξ", maximum_from(&largest(&|i, k| norm(auxiliary[i].row(k))), quarter)),
        Metric::new("max_u", formation.largest_input()),
    ];
    metrics.extend(formation.oscillations(TRANSIENT));
    Ok(metrics)
}

/// The last instant at which a wheel is asked for more than the actuators have, s; NaN if there is none.
fn saturation_end(run: &Run) -> Result<f64, MetricError> {
    let nominal = run.signals(Role::Controller, "nominal")?;
    let limit = run.scenario.context.input_limit.unwrap_or(f64::INFINITY);
    let saturated = |k: usize| nominal.iter().any(|series| series.row(k).iter().any(|input| input.abs() > limit));
    Ok((0..run.samples()).rev().find(|&k| saturated(k)).map_or(f64::NAN, |k| run.time(k)))
}
