//! Metrics of the scenario with input distribution. (specification ch5-cida, section 11)

use formation::math::sign;
use formation::nalgebra::Vector3;
use formation::wiring::Role;

use super::speed_formation::SpeedFormation;
use orchestrator::judge::metrics::{Definition, Metric, MetricError, Run, maximum_from, total_variation};

/// Levels below which the norms of Ẽ, e, δ and u have to settle, and those that the thesis names for the first three.
struct Levels {
    settled: [f64; 4],
    thesis: [f64; 3],
}

const WITH_OBSERVER: Levels = Levels { settled: [0.06, 0.02, 0.007, 0.65], thesis: [0.053, 0.015, 0.005] };
const WITHOUT_OBSERVER: Levels = Levels { settled: [420.0, 0.20, 0.08, 0.80], thesis: [500.0, 0.15, 0.055] };

const NAMES: [&str; 4] = ["Ẽ", "ex", "δ", "u"];

/// End of the span in which oscillations and reversals count, start of that in which a diverging network is looked at, s.
const TRANSIENT: f64 = 20.0;

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new(
        "b_Ẽ",
        "‖Ẽ‖",
        "m/s, rad/s",
        "Uncertainty against its estimate; all robots, largest in the last quarter.",
    ),
    Definition::new("b_ex", "‖e_x‖", "m, rad", "Local error; all robots, largest in the last quarter."),
    Definition::new("b_δ", "‖δ‖", "m, rad", "Formation error; all robots, largest in the last quarter."),
    Definition::new("b_u", "‖u‖", "m/s", "Wheel speeds; all robots, largest in the last quarter."),
    Definition::new("t_Ẽ", "t(‖Ẽ‖ ≤ 0.06)", "s", "Time from which on ‖Ẽ‖ stays below 0.06 (without an observer: 420)."),
    Definition::new(
        "t_ex",
        "t(‖e_x‖ ≤ 0.02)",
        "s",
        "Time from which on ‖e_x‖ stays below 0.02 (without an observer: 0.20).",
    ),
    Definition::new(
        "t_δ",
        "t(‖δ‖ ≤ 0.007)",
        "s",
        "Time from which on ‖δ‖ stays below 0.007 (without an observer: 0.08).",
    ),
    Definition::new(
        "t_u",
        "t(‖u‖ ≤ 0.65)",
        "s",
        "Time from which on ‖u‖ stays below 0.65 (without an observer: 0.80).",
    ),
    Definition::new(
        "t_Ẽ({level})",
        "t(‖Ẽ‖ ≤ {level})",
        "s",
        "Time from which on ‖Ẽ‖ stays below the level of the thesis.",
    ),
    Definition::new(
        "t_ex({level})",
        "t(‖e_x‖ ≤ {level})",
        "s",
        "Time from which on ‖e_x‖ stays below the level of the thesis.",
    ),
    Definition::new(
        "t_δ({level})",
        "t(‖δ‖ ≤ {level})",
        "s",
        "Time from which on ‖δ‖ stays below the level of the thesis.",
    ),
    Definition::new("t_ξ", "t(ξ̄ = 1)", "s", "Time from which on no consensus input is scaled down any more."),
    Definition::new(
        "V_x",
        "V_x",
        "m",
        "Oscillation of the local errors along x in the first 20 s: total variation less net change, all robots.",
    ),
    Definition::new("V_y", "V_y", "m", "Oscillation of the local errors along y in the first 20 s, all robots."),
    Definition::new(
        "V_θ",
        "V_θ",
        "rad",
        "Oscillation of the local errors of the heading in the first 20 s, all robots.",
    ),
    Definition::new("V_x_{i}", "V_x", "m", "As `V_x`, of one robot."),
    Definition::new("V_y_{i}", "V_y", "m", "As `V_y`, of one robot."),
    Definition::new("V_θ_{i}", "V_θ", "rad", "As `V_θ`, of one robot."),
    Definition::new(
        "m20_Ẽ",
        "max ‖Ẽ‖",
        "m/s, rad/s",
        "Uncertainty against its estimate; all robots, largest after 20 s.",
    ),
    Definition::new("m20_ex", "max ‖e_x‖", "m, rad", "Local error; all robots, largest after 20 s."),
    Definition::new("m20_δ", "max ‖δ‖", "m, rad", "Formation error; all robots, largest after 20 s."),
    Definition::new("m20_u", "max ‖u‖", "m/s", "Wheel speeds; all robots, largest after 20 s."),
    Definition::new("TV_u", "TV(u)", "m/s", "Total variation of all inputs in the last quarter: chatter."),
    Definition::new(
        "rev20",
        "",
        "",
        "Share of the first 20 s, over robots and channels, in which saturation reverses the commanded motion.",
    ),
    Definition::new("max_u", "max |u|", "m/s", "Largest wheel speed that is commanded."),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let observed = run.offers(Role::Observer, 0, "disturbance");
    let (estimator, estimate, levels) = match observed {
        true => (Role::Observer, "disturbance", &WITH_OBSERVER),
        false => (Role::Controller, "network", &WITHOUT_OBSERVER),
    };
    let formation = SpeedFormation::read(run, estimator, estimate)?;
    let histories = [
        formation.stacked_uncertainty_error(),
        formation.stacked_error(),
        formation.stacked_tracking_error(),
        formation.stacked_input(),
    ];
    let named = || NAMES.iter().zip(&histories);
    let quarter = run.last_quarter();
    let mut metrics: Vec<Metric> =
        named().map(|(name, history)| Metric::new(format!("b_{name}"), maximum_from(history, quarter))).collect();
    metrics.extend(
        named()
            .zip(levels.settled)
            .map(|((name, history), level)| Metric::new(format!("t_{name}"), formation.settled(history, level))),
    );
    if let Some(instant) = unscaled(run)? {
        metrics.push(Metric::new("t_ξ", instant));
    }
    metrics.extend(formation.oscillations(TRANSIENT));
    let late = run.sample_at(TRANSIENT);
    metrics.extend(named().map(|(name, history)| Metric::new(format!("m20_{name}"), maximum_from(history, late))));
    let inputs = formation.input.iter();
    let variation =
        inputs.map(|series| (0..3).map(|j| total_variation(series.component(j).skip(quarter))).sum::<f64>());
    metrics.push(Metric::new("TV_u", variation.sum()));
    metrics.push(Metric::new("rev20", reversals(run)?));
    metrics.push(Metric::new("max_u", formation.largest_input()));
    metrics.extend(
        named().zip(levels.thesis).map(|((name, history), level)| {
            Metric::new(format!("t_{name}({level})"), formation.settled(history, level))
        }),
    );
    Ok(metrics)
}

/// The instant from which on no consensus input is scaled down any more, s; `None` if the inputs are not distributed.
fn unscaled(run: &Run) -> Result<Option<f64>, MetricError> {
    let distributes = run.scenario.section("controller.distribution").and_then(|node| node.as_str()) == Some("cida");
    if !distributes {
        return Ok(None);
    }
    let shares = run.signals(Role::Controller, "xi_bar")?;
    let scaled = |k: usize| shares.iter().any(|share| (share.row(k)[0] - 1.0).abs() > 1e-12);
    let first = (0..run.samples()).rev().find(|&k| scaled(k)).map_or(0, |last| last + 1);
    Ok(Some(if first < run.samples() { run.time(first) } else { f64::NAN }))
}

/// Share of (instant, agent, channel) at which the velocity that the input causes points elsewhere than the one that was asked
/// for: sign(ĝ(um + ue)) ≠ sign(ĝ u).
fn reversals(run: &Run) -> Result<f64, MetricError> {
    let position = run.signals(Role::Plant, "position")?;
    let maintenance = run.signals(Role::Controller, "maintenance")?;
    let consensus = run.signals(Role::Controller, "consensus")?;
    let input = run.signals(Role::Controller, "input")?;
    let samples = (run.sample_at(TRANSIENT) + 1).min(run.samples());
    let mut reversed = 0;
    for i in 0..run.agents() {
        let nominal = run.scenario.context.agents[i].nominal.omni().ok_or_else(|| MetricError::NotApplicable {
            set: run.scenario.metrics.clone(),
            reason: "the vehicles are no planar robots".into(),
        })?;
        for k in 0..samples {
            let vector = |series: &[recording::Series]| Vector3::from_column_slice(series[i].row(k));
            let matrix = nominal.matrix(position[i].row(k)[2]);
            let asked = matrix * (vector(&maintenance) + vector(&consensus));
            let given = matrix * vector(&input);
            reversed += (0..3).filter(|&j| sign(asked[j]) != sign(given[j])).count();
        }
    }
    Ok(reversed as f64 / (3 * samples * run.agents()) as f64)
}
