//! Metrics of the scenario with regulated inputs. (specification ch6-lp-regulation, section 11)

use formation::nalgebra::{Matrix3, Vector3};
use formation::wiring::Role;

use orchestrator::judge::metrics::{
    Definition, Metric, MetricError, Run, first_below_for_good, maximum, maximum_from, norm_between, square_sum,
    total_variation,
};
use recording::Series;

/// Effects of inputs that are smaller count as none, in m/s² or rad/s².
const NO_EFFECT: f64 = 1e-7;

/// The signals of all agents that the metrics need.
struct Signals<'a> {
    position: Vec<Series<'a>>,
    disturbance: Vec<Series<'a>>,
    desired: Vec<Series<'a>>,
    estimate: Vec<Series<'a>>,
    input: Vec<Series<'a>>,
    demanded: Vec<Series<'a>>,
    sliding: Vec<Series<'a>>,
    error: Vec<Series<'a>>,
    /// ξ, if the controller has a compensator.
    compensator: Option<Vec<Series<'a>>>,
}

impl<'a> Signals<'a> {
    fn read(run: &Run<'a>) -> Result<Self, MetricError> {
        // A controller with a network of its own needs no observer, and publishes the estimate itself.
        let estimator = if run.offers(Role::Observer, 0, "disturbance") { Role::Observer } else { Role::Controller };
        let compensated = run.offers(Role::Controller, 0, "xi");
        Ok(Self {
            position: run.signals(Role::Plant, "position")?,
            disturbance: run.signals(Role::Plant, "disturbance")?,
            desired: run.signals(Role::Planner, "position")?,
            estimate: run.signals(estimator, "disturbance")?,
            input: run.signals(Role::Controller, "input")?,
            demanded: run.signals(Role::Controller, "ucom")?,
            sliding: run.signals(Role::Controller, "sliding")?,
            error: run.signals(Role::Controller, "error")?,
            compensator: compensated.then(|| run.signals(Role::Controller, "xi")).transpose()?,
        })
    }
}

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new("De", "Δ_e", "m s, rad s", "Integral of the 1-norm of the local errors (6.32)."),
    Definition::new("Du", "Δ_u", "N s", "Integral of the 1-norm of the inputs (6.33)."),
    Definition::new("De_20", "Δ_e", "m s, rad s", "As `De`, to 20 s."),
    Definition::new("Du_20", "Δ_u", "N s", "As `Du`, to 20 s."),
    Definition::new(
        "wt_bound",
        "‖w̃‖",
        "m/s², rad/s²",
        "Uncertainty against its estimate; all robots, largest in the last quarter.",
    ),
    Definition::new("wt_t({level})", "t(‖w̃‖ ≤ {level})", "s", "Time from which on ‖w̃‖ stays below a level."),
    Definition::new("wt_10", "‖w̃‖(10 s)", "m/s², rad/s²", "Error of the estimated uncertainty at 10 s; all robots."),
    Definition::new("wt_end", "‖w̃‖(T)", "m/s², rad/s²", "Error of the estimated uncertainty at the end; all robots."),
    Definition::new(
        "max_wt",
        "max ‖w̃‖",
        "m/s², rad/s²",
        "Error of the estimated uncertainty, largest of the run; all robots.",
    ),
    Definition::new("S_bound", "‖S‖", "m/s, rad/s", "Sliding variable; all robots, largest in the last quarter."),
    Definition::new("ex_bound", "‖e_x‖", "m, rad", "Local error; all robots, largest in the last quarter."),
    Definition::new("dx_bound", "‖δx‖", "m, rad", "Formation error; all robots, largest in the last quarter."),
    Definition::new("S_20", "‖S‖(20 s)", "m/s, rad/s", "Sliding variable at 20 s; all robots."),
    Definition::new("ex_20", "‖e_x‖(20 s)", "m, rad", "Local error at 20 s; all robots."),
    Definition::new("dx_20", "‖δx‖(20 s)", "m, rad", "Formation error at 20 s; all robots."),
    Definition::new("ex_t({level})", "t(‖e_x‖ ≤ {level})", "s", "Time from which on ‖e_x‖ stays below a level."),
    Definition::new("tv_S5", "TV(‖S‖)", "m/s, rad/s", "Total variation of ‖S‖ in the first 5 s."),
    Definition::new("max_S", "max ‖S‖", "m/s, rad/s", "Sliding variable, largest of the run; all robots."),
    Definition::new(
        "xi_bound",
        "‖ξ‖",
        "m/s, rad/s",
        "Auxiliary variable of the compensator; all robots, largest in the last quarter.",
    ),
    Definition::new("max_u", "max |u|", "N", "Largest wheel force."),
    Definition::new(
        "rev",
        "t",
        "s",
        "Time during which inputs act against the demanded direction, summed over robots and channels.",
    ),
    Definition::new(
        "lp_excess",
        "",
        "m/s², rad/s²",
        "How far a regulated input leaves the interval between zero and what was demanded, at worst.",
    ),
    Definition::new(
        "tv_sth",
        "TV(s_θ)",
        "rad/s",
        "Total variation of the heading's sliding variable in the first 5 s, all robots.",
    ),
    Definition::new("tv_sth_{i}", "TV(s_θ{i})", "rad/s", "As `tv_sth`, of one robot."),
    Definition::new(
        "over_{i}",
        "max(−s)",
        "m/s",
        "Overshoot of the sliding variables along x and y beyond zero, one robot.",
    ),
    Definition::new("over_x_{i}", "max(−s_x)", "m/s", "Overshoot of the sliding variable along x, one robot."),
    Definition::new("over_y_{i}", "max(−s_y)", "m/s", "Overshoot of the sliding variable along y, one robot."),
    Definition::new(
        "over_theta_{i}",
        "max(−s_θ)",
        "rad/s",
        "Overshoot of the sliding variable of the heading, one robot.",
    ),
    Definition::new(
        "windup_{i}",
        "rms (s_x, s_y)",
        "m/s",
        "Root mean square of the sliding variables along x and y from 1.5 to 9 s, one robot.",
    ),
    Definition::new(
        "over_rank_{k}",
        "",
        "m/s, rad/s",
        "The three largest overshoots of all robots and channels, in descending order.",
    ),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let signals = Signals::read(run)?;
    let mut metrics = costs(run, &signals);
    metrics.extend(estimation(run, &signals));
    metrics.extend(formation_errors(run, &signals));
    metrics.extend(reverse_effect(run, &signals)?);
    metrics.extend(fluctuation(run, &signals));
    Ok(metrics)
}

/// First sample of the last quarter, floor(3K/4) of K periods.
fn last_quarter(run: &Run) -> usize {
    3 * (run.samples() - 1) / 4
}

/// Norm of a signal over all agents at every sample.
fn stacked_norm(run: &Run, series: &[Series]) -> Vec<f64> {
    run.history(|k| series.iter().map(|series| square_sum(series.row(k))).sum::<f64>().sqrt())
}

/// Norm of the difference of two signals over all agents at every sample.
fn stacked_difference(run: &Run, a: &[Series], b: &[Series]) -> Vec<f64> {
    run.history(|k| a.iter().zip(b).map(|(a, b)| norm_between(a.row(k), b.row(k)).powi(2)).sum::<f64>().sqrt())
}

fn bound(run: &Run, id: &str, history: &[f64]) -> Metric {
    Metric::new(id, maximum_from(history, last_quarter(run)))
}

/// The instant from which on `history` never exceeds `level`.
fn instant(run: &Run, id: &str, history: &[f64], level: f64) -> Metric {
    Metric::new(id, first_below_for_good(history, level).map_or(f64::NAN, |k| run.time(k)))
}

/// The value at `time` (s), if the run lasts that long.
fn value_at(run: &Run, id: &str, history: &[f64], time: f64) -> Metric {
    Metric::new(id, history.get(run.sample_at(time)).copied().unwrap_or(f64::NAN))
}

/// Δe and Δu: integrals of 1-norms by rectangles. (6.32), (6.33)
fn costs(run: &Run, s: &Signals) -> Vec<Metric> {
    let integral = |id: &str, series: &[Series], end: usize| {
        let size = |k: usize| series.iter().flat_map(|series| series.row(k)).map(|value| value.abs()).sum::<f64>();
        let complete = end < run.samples();
        Metric::new(id, if complete { run.dt() * (0..end).map(size).sum::<f64>() } else { f64::NAN })
    };
    let last = run.samples() - 1;
    let twenty = run.sample_at(20.0);
    vec![
        integral("De", &s.error, last),
        integral("Du", &s.input, last),
        integral("De_20", &s.error, twenty),
        integral("Du_20", &s.input, twenty),
    ]
}

fn estimation(run: &Run, s: &Signals) -> Vec<Metric> {
    let error = stacked_difference(run, &s.disturbance, &s.estimate);
    vec![
        bound(run, "wt_bound", &error),
        instant(run, "wt_t(0.667)", &error, 0.667),
        instant(run, "wt_t(2.85e-2)", &error, 2.85e-2),
        instant(run, "wt_t(1.12e-2)", &error, 1.12e-2),
        value_at(run, "wt_10", &error, 10.0),
        Metric::new("wt_end", error.last().copied().unwrap_or(f64::NAN)),
        Metric::new("max_wt", maximum(error)),
    ]
}

fn formation_errors(run: &Run, s: &Signals) -> Vec<Metric> {
    let sliding = stacked_norm(run, &s.sliding);
    let error = stacked_norm(run, &s.error);
    let own = stacked_difference(run, &s.position, &s.desired);
    let mut metrics = vec![
        bound(run, "S_bound", &sliding),
        bound(run, "ex_bound", &error),
        bound(run, "dx_bound", &own),
        value_at(run, "S_20", &sliding, 20.0),
        value_at(run, "ex_20", &error, 20.0),
        value_at(run, "dx_20", &own, 20.0),
        instant(run, "ex_t(0.05)", &error, 0.05),
        Metric::new("tv_S5", total_variation(sliding.iter().copied().take(run.sample_at(5.0) + 1))),
        Metric::new("max_S", maximum(sliding)),
    ];
    if let Some(compensator) = &s.compensator {
        metrics.push(bound(run, "xi_bound", &stacked_norm(run, compensator)));
    }
    let inputs = s.input.iter().flat_map(|series| series.rows()).flatten().map(|value| value.abs());
    metrics.push(Metric::new("max_u", maximum(inputs)));
    metrics
}

/// How long inputs do the opposite of what was demanded, and by how much the regulated input breaks its promise
/// `0 <= sign(g_j ucom) g_j u <= |g_j ucom|` at worst.
fn reverse_effect(run: &Run, s: &Signals) -> Result<Vec<Metric>, MetricError> {
    let mut reversed = 0_u64;
    let mut excess = 0.0_f64;
    for (i, agent) in run.scenario.context.agents.iter().enumerate() {
        let omni = agent.vehicle.omni().ok_or_else(|| MetricError::NotApplicable {
            set: run.scenario.metrics.clone(),
            reason: format!("agent {} is no planar robot", agent.number),
        })?;
        for k in 0..run.samples() {
            let effect: Matrix3<f64> = omni.matrix(s.position[i].row(k)[2]);
            let done = effect * Vector3::from_column_slice(s.input[i].row(k));
            let demanded = effect * Vector3::from_column_slice(s.demanded[i].row(k));
            for (done, demanded) in done.iter().zip(&demanded) {
                let counted = k + 1 < run.samples();
                reversed += u64::from(counted && done * demanded < 0.0 && done.abs() > NO_EFFECT);
                let part = if *demanded < 0.0 { -done } else { *done };
                excess = excess.max(-part).max(part - demanded.abs());
            }
        }
    }
    Ok(vec![Metric::new("rev", run.dt() * reversed as f64), Metric::new("lp_excess", excess)])
}

/// Fluctuation and overshoot of the sliding variables, robot by robot.
fn fluctuation(run: &Run, s: &Signals) -> Vec<Metric> {
    let five = run.sample_at(5.0) + 1;
    let turning: Vec<f64> = s.sliding.iter().map(|series| total_variation(series.component(2).take(five))).collect();
    let overshoots: Vec<[f64; 3]> =
        s.sliding.iter().map(|series| [0, 1, 2].map(|channel| overshoot(series, channel))).collect();
    let mut metrics = vec![Metric::new("tv_sth", turning.iter().sum())];
    let mut per_robot = |name: &str, values: Vec<f64>| {
        let numbered = values.into_iter().zip(1..).map(|(value, robot)| Metric::new(format!("{name}_{robot}"), value));
        metrics.extend(numbered);
    };
    per_robot("tv_sth", turning);
    per_robot("over", overshoots.iter().map(|over| over[0].max(over[1])).collect());
    for (channel, name) in ["over_x", "over_y", "over_theta"].into_iter().enumerate() {
        per_robot(name, overshoots.iter().map(|over| over[channel]).collect());
    }
    per_robot("windup", s.sliding.iter().map(|series| windup(run, series)).collect());
    let mut ranked: Vec<f64> = overshoots.into_iter().flatten().collect();
    ranked.sort_by(|a, b| b.total_cmp(a));
    metrics.extend(
        ranked.into_iter().take(3).zip(1..).map(|(value, rank)| Metric::new(format!("over_rank_{rank}"), value)),
    );
    metrics
}

/// How far a channel gets on the other side of zero than the one where it starts.
fn overshoot(series: &Series, channel: usize) -> f64 {
    let start = series.component(channel).next().unwrap_or(f64::NAN);
    let sign = if start == 0.0 { 0.0 } else { start.signum() };
    maximum(series.component(channel).map(|value| -value * sign)).max(0.0)
}

/// Root of the mean square of (s_x, s_y) between 1.5 s and 9 s.
fn windup(run: &Run, series: &Series) -> f64 {
    let (first, last) = (run.sample_at(1.5), run.sample_at(9.0));
    if last >= run.samples() {
        return f64::NAN;
    }
    let sum: f64 = (first..=last).map(|k| square_sum(&series.row(k)[..2])).sum();
    (sum / (last - first + 1) as f64).sqrt()
}
