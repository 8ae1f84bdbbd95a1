//! Metrics of formation control with limited information. (specification ch4-limited-information, section 11)

use formation::scenario::Context;
use formation::wiring::Role;

use orchestrator::judge::metrics::{
    Definition, Metric, MetricError, Run, first_below_for_good, maximum, maximum_from, norm_between, square_sum,
    total_variation,
};
use recording::Series;

/// The signals of all agents that the metrics need.
struct Signals<'a> {
    position: Vec<Series<'a>>,
    velocity: Vec<Series<'a>>,
    disturbance: Vec<Series<'a>>,
    reference: Vec<Series<'a>>,
    reference_velocity: Vec<Series<'a>>,
    estimated_position: Vec<Series<'a>>,
    estimated_velocity: Vec<Series<'a>>,
    estimate: Vec<Series<'a>>,
    rebuilt_velocity: Vec<Series<'a>>,
    input: Vec<Series<'a>>,
    error: Vec<Series<'a>>,
    sliding: Vec<Series<'a>>,
    adjacency: Vec<Series<'a>>,
}

impl<'a> Signals<'a> {
    fn read(run: &Run<'a>) -> Result<Self, MetricError> {
        Ok(Self {
            position: run.signals(Role::Plant, "position")?,
            velocity: run.signals(Role::Plant, "velocity")?,
            disturbance: run.signals(Role::Plant, "disturbance")?,
            reference: run.signals(Role::Planner, "position")?,
            reference_velocity: run.signals(Role::Planner, "velocity")?,
            estimated_position: run.signals(Role::Observer, "position")?,
            estimated_velocity: run.signals(Role::Observer, "velocity")?,
            estimate: run.signals(Role::Observer, "disturbance")?,
            rebuilt_velocity: run.signals(Role::Observer, "reference_velocity")?,
            input: run.signals(Role::Controller, "input")?,
            error: run.signals(Role::Controller, "error")?,
            sliding: run.signals(Role::Controller, "sliding")?,
            adjacency: run.signals(Role::Controller, "adjacency")?,
        })
    }
}

/// Limits of the window `mid`, s.
const MID: (f64, f64) = (6.0, 30.0);

/// Length of the window in which the variation of the estimate is taken, s.
const START: f64 = 4.0;

/// From here on no link but the static ones should be left, s.
const LATE: f64 = 10.0;

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new(
        "Nx_mid",
        "Σ‖x_i − x̂_i‖",
        "m, rad",
        "Errors of the observed positions, sum over the robots, largest from 6 to 30 s.",
    ),
    Definition::new(
        "Nx_end",
        "Σ‖x_i − x̂_i‖",
        "m, rad",
        "Errors of the observed positions, sum over the robots, largest in the last quarter.",
    ),
    Definition::new(
        "Nv_mid",
        "Σ‖v_i − v̂_i‖",
        "m/s, rad/s",
        "Errors of the observed velocities, sum over the robots, largest from 6 to 30 s.",
    ),
    Definition::new(
        "Nv_end",
        "Σ‖v_i − v̂_i‖",
        "m/s, rad/s",
        "Errors of the observed velocities, sum over the robots, largest in the last quarter.",
    ),
    Definition::new(
        "Nw_mid",
        "Σ‖w_i − ŵ_i‖",
        "m/s², rad/s²",
        "Errors of the estimated uncertainties, sum over the robots, largest from 6 to 30 s.",
    ),
    Definition::new(
        "Nw_end",
        "Σ‖w_i − ŵ_i‖",
        "m/s², rad/s²",
        "Errors of the estimated uncertainties, sum over the robots, largest in the last quarter.",
    ),
    Definition::new("t_{level}", "t(Nw ≤ {level})", "s", "Time from which on Nw stays below a level until 30 s."),
    Definition::new(
        "TV",
        "TV(ŵ)",
        "m/s², rad/s²",
        "Total variation of the estimated uncertainties in the first 4 s, all robots.",
    ),
    Definition::new(
        "TV_true",
        "TV(w)",
        "m/s², rad/s²",
        "Total variation of the true uncertainties in the first 4 s, all robots.",
    ),
    Definition::new("dx_end", "‖δx‖", "m, rad", "Formation error; all robots, largest in the last quarter."),
    Definition::new("ex_end", "‖e_x‖", "m, rad", "Local error; all robots, largest in the last quarter."),
    Definition::new(
        "S_end",
        "‖S‖",
        "m/s, rad/s",
        "Sliding variable made of the true velocities; all robots, largest in the last quarter.",
    ),
    Definition::new(
        "Ŝ_end",
        "‖Ŝ‖",
        "m/s, rad/s",
        "Sliding variable that the controllers use; all robots, largest in the last quarter.",
    ),
    Definition::new("margin_{ij}", "min d_{ij}", "m", "Smallest clearance between two robots; below zero: collision."),
    Definition::new("margin_min", "min d_ij", "m", "Smallest clearance between any two robots."),
    Definition::new("collisions", "", "", "Number of pairs that collide."),
    Definition::new(
        "z_to_r_lo",
        "min z_ij/r_ij",
        "",
        "Smallest distance of a pair relative to the inner boundary of its potential.",
    ),
    Definition::new("a2pk_{ij}", "max a²_{ij}", "", "Largest weight of the distance-dependent link of a pair."),
    Definition::new("a2_late", "max a²_ij", "", "Largest weight of any distance-dependent link after 10 s."),
    Definition::new("u_max", "max |u|", "N, N m", "Largest component of any input."),
    Definition::new(
        "t_ref",
        "t(‖γ_2 − ẋ_d‖ ≤ 1e-3)",
        "s",
        "Time from which on the differentiated reference stays within 1e-3 of the true one.",
    ),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let planar = |run: &Run| run.scenario.context.agents.iter().all(|agent| agent.vehicle.omni().is_some());
    if !planar(run) {
        return Err(MetricError::NotApplicable {
            set: run.scenario.metrics.clone(),
            reason: "they are made for planar robots with a radius".into(),
        });
    }
    let signals = Signals::read(run)?;
    let mut metrics = estimation(run, &signals);
    metrics.extend(formation(run, &signals));
    metrics.extend(distances(run, &signals));
    metrics.extend(links(run, &signals));
    let largest = signals.input.iter().flat_map(|series| series.rows()).flatten().map(|force| force.abs());
    metrics.push(Metric::new("u_max", maximum(largest)));
    let rebuilt =
        stacked(run, |i, k| norm_between(signals.rebuilt_velocity[i].row(k), signals.reference_velocity[i].row(k)));
    metrics.push(Metric::new("t_ref", instant(run, &rebuilt, 1e-3)));
    Ok(metrics)
}

/// First time from which on the history never exceeds `level`; NaN if there is none.
fn instant(run: &Run, history: &[f64], level: f64) -> f64 {
    first_below_for_good(history, level).map_or(f64::NAN, |k| run.time(k))
}

/// Norm of the vector of all agents, given the norm of each.
fn stacked(run: &Run, norm: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    run.history(|k| (0..run.agents()).map(|i| norm(i, k).powi(2)).sum::<f64>().sqrt())
}

/// Samples from 0 up to and including `time`, at most all.
fn samples_to(run: &Run, time: f64) -> usize {
    ((time / run.dt() + 1e-9).floor() as usize + 1).min(run.samples())
}

/// Nx, Nv, Nw, the instants at which Nw is settled, and how much the estimate varies at the start.
fn estimation(run: &Run, s: &Signals) -> Vec<Metric> {
    let summed = |true_value: &[Series], estimate: &[Series]| {
        run.history(|k| true_value.iter().zip(estimate).map(|(a, b)| norm_between(a.row(k), b.row(k))).sum())
    };
    let histories = [
        ("Nx", summed(&s.position, &s.estimated_position)),
        ("Nv", summed(&s.velocity, &s.estimated_velocity)),
        ("Nw", summed(&s.disturbance, &s.estimate)),
    ];
    let until = samples_to(run, MID.1);
    let mut metrics = Vec::new();
    for (name, history) in &histories {
        metrics.push(Metric::new(format!("{name}_mid"), maximum_from(&history[..until], run.sample_at(MID.0))));
        metrics.push(Metric::new(format!("{name}_end"), maximum_from(history, run.last_quarter())));
    }
    let [_, _, (_, disturbance)] = &histories;
    for level in [1.1, 2.3, 4.1] {
        metrics.push(Metric::new(format!("t_{level}"), instant(run, &disturbance[..until], level)));
    }
    // Changes that start at a time up to START: one sample more than times.
    let samples = samples_to(run, START) + 1;
    let variation = |series: &[Series]| -> f64 {
        let one = |series: &Series, column| total_variation(series.component(column).take(samples));
        series.iter().map(|series| (0..series.width()).map(|column| one(series, column)).sum::<f64>()).sum()
    };
    metrics.push(Metric::new("TV", variation(&s.estimate)));
    metrics.push(Metric::new("TV_true", variation(&s.disturbance)));
    metrics
}

/// Bounds of δx, e_x, S and Ŝ.
fn formation(run: &Run, s: &Signals) -> Vec<Metric> {
    let quarter = run.last_quarter();
    let bound = |id: &str, history: &[f64]| Metric::new(id, maximum_from(history, quarter));
    let norm = |series: &[Series], i: usize, k: usize| square_sum(series[i].row(k)).sqrt();
    vec![
        bound("dx_end", &stacked(run, |i, k| norm_between(s.position[i].row(k), s.reference[i].row(k)))),
        bound("ex_end", &stacked(run, |i, k| norm(&s.error, i, k))),
        bound("S_end", &stacked(run, |i, k| true_sliding(run, s, i, k))),
        bound("Ŝ_end", &stacked(run, |i, k| norm(&s.sliding, i, k))),
    ]
}

/// ‖s_i‖, made of the true velocities and the graph of the instant.
fn true_sliding(run: &Run, s: &Signals, i: usize, k: usize) -> f64 {
    let slope = run.scenario.section("controller.lam").and_then(|node| node.as_f64()).unwrap_or(f64::NAN);
    let weights = s.adjacency[i].row(k);
    let error = |j: usize, column: usize| s.velocity[j].row(k)[column] - s.reference_velocity[j].row(k)[column];
    let sliding = |column: usize| {
        let own = error(i, column);
        let relative: f64 = weights.iter().enumerate().map(|(j, weight)| weight * (own - error(j, column))).sum();
        relative + run.topology(k).b(i) * own + slope * s.error[i].row(k)[column]
    };
    square_sum(&[sliding(0), sliding(1), sliding(2)]).sqrt()
}

/// ‖s_i‖ of every agent at every sample, as [`true_sliding`] makes it.
pub(super) fn sliding(run: &Run) -> Result<Vec<Vec<f64>>, MetricError> {
    let signals = Signals::read(run)?;
    Ok((0..run.agents()).map(|i| run.history(|k| true_sliding(run, &signals, i, k))).collect())
}

/// How close every pair came: to a collision, and relative to the inner boundary of the potentials.
fn distances(run: &Run, s: &Signals) -> Vec<Metric> {
    let eps1 = run.scenario.section("controller.eps1").and_then(|node| node.as_f64()).unwrap_or(f64::NAN);
    let (mut margins, mut ratios) = (Vec::new(), Vec::new());
    let mut metrics = Vec::new();
    for i in 0..run.agents() {
        for j in i + 1..run.agents() {
            let nearest = run.history(|k| norm_between(&s.position[i].row(k)[..2], &s.position[j].row(k)[..2]));
            let nearest = -maximum(nearest.into_iter().map(|distance| -distance));
            let radii = radius(&run.scenario.context, i) + radius(&run.scenario.context, j);
            margins.push(nearest - radii);
            ratios.push(nearest / (eps1 * radii));
            metrics.push(Metric::new(format!("margin_{}", pair(run, i, j)), nearest - radii));
        }
    }
    let minimum = |values: &[f64]| -maximum(values.iter().map(|value| -value));
    metrics.push(Metric::new("margin_min", minimum(&margins)));
    metrics.push(Metric::new("collisions", margins.iter().filter(|margin| **margin < 0.0).count() as f64));
    metrics.push(Metric::new("z_to_r_lo", minimum(&ratios)));
    metrics
}

fn radius(context: &Context, agent: usize) -> f64 {
    context.agents[agent].vehicle.omni().map_or(f64::NAN, |omni| omni.radius)
}

/// `16`, or `1_10` where there are ten agents or more.
fn pair(run: &Run, i: usize, j: usize) -> String {
    let between = if run.agents() < 10 { "" } else { "_" };
    format!("{}{between}{}", i + 1, j + 1)
}

/// The links that depend on the distance.
fn links(run: &Run, s: &Signals) -> Vec<Metric> {
    // A static link rules out another one between the same agents.
    let added =
        |i: usize, j: usize, k: usize| if run.topology(k).a(i, j) > 0.0 { 0.0 } else { s.adjacency[i].row(k)[j] };
    let peak = |i: usize, j: usize| maximum(run.history(|k| added(i, j, k)));
    let shown = [(1, 6), (5, 4), (2, 3)].into_iter().filter(|&(i, j)| i.max(j) <= run.agents());
    let mut metrics: Vec<Metric> =
        shown.map(|(i, j)| Metric::new(format!("a2pk_{i}{j}"), peak(i - 1, j - 1))).collect();
    let all = |k: usize| {
        maximum((0..run.agents()).flat_map(|i| (0..run.agents()).map(move |j| (i, j))).map(|(i, j)| added(i, j, k)))
    };
    let late = maximum_from(&run.history(all), samples_to(run, LATE));
    metrics.push(Metric::new("a2_late", late));
    metrics
}
