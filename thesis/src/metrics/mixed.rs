//! Metrics of the cluster of mixed order. (specification ch7-mixed, section 11)

use formation::wiring::Role;

use orchestrator::judge::metrics::{
    Definition, Metric, MetricError, Run, first_below_for_good, maximum, maximum_from, norm, norm_between,
};
use recording::Series;

/// Norms of every robot over time: outer index the robot, inner one the sample.
struct Norms {
    tracking: Vec<Vec<f64>>,
    total: Vec<Vec<f64>>,
    virtual_error: Vec<Vec<f64>>,
    virtual_sliding: Vec<Vec<f64>>,
    disturbance: Vec<Vec<f64>>,
    /// Robots of order 2 only.
    sliding: Vec<Vec<f64>>,
}

impl Norms {
    fn read(run: &Run) -> Result<Self, MetricError> {
        let position = run.signals(Role::Plant, "position")?;
        let disturbance = run.signals(Role::Plant, "disturbance")?;
        let virtual_position = run.signals(Role::Planner, "position")?;
        let desired = run.signals(Role::Planner, "desired_position")?;
        let virtual_sliding = run.signals(Role::Planner, "sliding")?;
        let network = run.signals(Role::Controller, "network")?;
        let sliding = run.signals(Role::Controller, "sliding")?;
        let between = |a: &[Series], b: &[Series]| -> Vec<Vec<f64>> {
            a.iter().zip(b).map(|(a, b)| a.rows().zip(b.rows()).map(|(a, b)| norm_between(a, b)).collect()).collect()
        };
        let of = |series: &Series| series.rows().map(norm).collect();
        Ok(Self {
            tracking: between(&position, &virtual_position),
            total: between(&position, &desired),
            virtual_error: between(&virtual_position, &desired),
            virtual_sliding: virtual_sliding.iter().map(of).collect(),
            disturbance: between(&disturbance, &network),
            sliding: sliding.iter().enumerate().filter(|(i, _)| order(run, *i) == 2).map(|(_, s)| of(s)).collect(),
        })
    }
}

fn order(run: &Run, agent: usize) -> usize {
    run.scenario.context.agents[agent].vehicle.order()
}

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new(
        "dx",
        "max ‖x − x̄‖",
        "m, rad",
        "Robot against its virtual agent; worst robot, largest in the last quarter.",
    ),
    Definition::new(
        "s",
        "max ‖s‖",
        "m/s, rad/s",
        "Sliding variable of the second-order robots; worst robot, largest in the last quarter.",
    ),
    Definition::new(
        "w_til",
        "max ‖w − ŵ‖",
        "m/s^n, rad/s^n",
        "Uncertainty against its estimate, n the order of the robot; worst robot, largest in the last quarter.",
    ),
    Definition::new(
        "track",
        "max ‖x − x_d‖",
        "m, rad",
        "Robot against its desired position; worst robot, largest in the last quarter.",
    ),
    Definition::new(
        "dbar_x",
        "max ‖δ̄x‖",
        "m, rad",
        "Virtual agent against its desired position; worst agent, largest in the last quarter.",
    ),
    Definition::new(
        "s_bar",
        "max ‖s̄‖",
        "m/s, rad/s",
        "Sliding variable of the virtual agents; worst agent, largest in the last quarter.",
    ),
    Definition::new("dx_first", "max ‖x − x̄‖", "m, rad", "As `dx`, of the first-order robots."),
    Definition::new("dx_second", "max ‖x − x̄‖", "m, rad", "As `dx`, of the second-order robots."),
    Definition::new("track_first", "max ‖x − x_d‖", "m, rad", "As `track`, of the first-order robots."),
    Definition::new("track_second", "max ‖x − x_d‖", "m, rad", "As `track`, of the second-order robots."),
    Definition::new("w_til_first", "max ‖w − ŵ‖", "m/s, rad/s", "As `w_til`, of the first-order robots."),
    Definition::new("w_til_second", "max ‖w − ŵ‖", "m/s², rad/s²", "As `w_til`, of the second-order robots."),
    Definition::new(
        "t_dbar_x",
        "t(‖δ̄x‖ ≤ 4e-2)",
        "s",
        "Time from which on every virtual agent keeps the thesis's bound of `dbar_x`.",
    ),
    Definition::new(
        "t_s_bar",
        "t(‖s̄‖ ≤ 6e-3)",
        "s",
        "Time from which on every virtual agent keeps the thesis's bound of `s_bar`.",
    ),
    Definition::new(
        "t_dx",
        "t(‖x − x̄‖ ≤ 2e-3)",
        "s",
        "Time from which on every robot keeps the thesis's bound of `dx`.",
    ),
    Definition::new(
        "t_s",
        "t(‖s‖ ≤ 4e-3)",
        "s",
        "Time from which on every second-order robot keeps the thesis's bound of `s`.",
    ),
    Definition::new(
        "t_w_til",
        "t(‖w − ŵ‖ ≤ 1e-2)",
        "s",
        "Time from which on every robot keeps the thesis's bound of `w_til`.",
    ),
    Definition::new(
        "t_track",
        "t(‖x − x_d‖ ≤ 6e-3)",
        "s",
        "Time from which on every robot keeps the thesis's bound of `track`.",
    ),
    Definition::new(
        "peak_dx",
        "max ‖x − x̄‖",
        "m, rad",
        "Robot against its virtual agent; worst robot, largest of the run.",
    ),
    Definition::new(
        "peak_w_til",
        "max ‖w − ŵ‖",
        "m/s^n, rad/s^n",
        "Uncertainty against its estimate; worst robot, largest of the run.",
    ),
    Definition::new("peak_u", "max |u|", "m/s^n, rad/s^n", "Largest component of any input."),
    Definition::new(
        "final_track",
        "max ‖x − x_d‖",
        "m, rad",
        "Robot against its desired position; worst robot, at the end.",
    ),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let norms = Norms::read(run)?;
    let mut metrics = settled(run, &norms);
    metrics.extend(by_order(run, &norms));
    metrics.extend(instants(run, &norms));
    metrics.extend(extremes(run, &norms)?);
    Ok(metrics)
}

/// Largest value of any robot from sample `first` on; nothing if there is no robot.
fn largest<'a>(id: &str, robots: impl IntoIterator<Item = &'a Vec<f64>>, first: usize) -> Option<Metric> {
    let mut robots = robots.into_iter().peekable();
    robots.peek()?;
    Some(Metric::new(id, maximum(robots.map(|history| maximum_from(history, first)))))
}

fn settled(run: &Run, norms: &Norms) -> Vec<Metric> {
    let quarter = run.last_quarter();
    let bounds = [
        ("dx", &norms.tracking),
        ("s", &norms.sliding),
        ("w_til", &norms.disturbance),
        ("track", &norms.total),
        ("dbar_x", &norms.virtual_error),
        ("s_bar", &norms.virtual_sliding),
    ];
    bounds.into_iter().filter_map(|(id, robots)| largest(id, robots, quarter)).collect()
}

fn by_order(run: &Run, norms: &Norms) -> Vec<Metric> {
    let mut metrics = Vec::new();
    for (id, robots) in [("dx", &norms.tracking), ("track", &norms.total), ("w_til", &norms.disturbance)] {
        for (suffix, wanted) in [("first", 1), ("second", 2)] {
            let chosen =
                robots.iter().enumerate().filter(|(i, _)| order(run, *i) == wanted).map(|(_, history)| history);
            metrics.extend(largest(&format!("{id}_{suffix}"), chosen, run.last_quarter()));
        }
    }
    metrics
}

/// When every robot has come below the bound of the thesis for good.
fn instants(run: &Run, norms: &Norms) -> Vec<Metric> {
    let bounds = [
        ("t_dbar_x", &norms.virtual_error, 4e-2),
        ("t_s_bar", &norms.virtual_sliding, 6e-3),
        ("t_dx", &norms.tracking, 2e-3),
        ("t_s", &norms.sliding, 4e-3),
        ("t_w_til", &norms.disturbance, 1e-2),
        ("t_track", &norms.total, 6e-3),
    ];
    let present = bounds.into_iter().filter(|(_, robots, _)| !robots.is_empty());
    let instant = |history: &Vec<f64>, level| first_below_for_good(history, level).map_or(f64::NAN, |k| run.time(k));
    present
        .map(|(id, robots, level)| Metric::new(id, maximum(robots.iter().map(|history| instant(history, level)))))
        .collect()
}

fn extremes(run: &Run, norms: &Norms) -> Result<Vec<Metric>, MetricError> {
    let input = run.signals(Role::Controller, "input")?;
    let peak = maximum(input.iter().flat_map(|series| series.rows()).flatten().map(|value| value.abs()));
    let last = run.samples() - 1;
    let mut metrics: Vec<Metric> = Vec::new();
    metrics.extend(largest("peak_dx", &norms.tracking, 0));
    metrics.extend(largest("peak_w_til", &norms.disturbance, 0));
    metrics.push(Metric::new("peak_u", peak));
    metrics.extend(largest("final_track", &norms.total, last));
    Ok(metrics)
}
