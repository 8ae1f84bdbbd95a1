//! Metrics of the drone scenario. (specification ch7-uav, section 11)

use formation::wiring::Role;

use orchestrator::judge::metrics::{
    Definition, Metric, MetricError, Run, first_below_for_good, maximum, maximum_from, median, norm_between,
    square_sum, total_variation,
};
use recording::Series;

/// The signals of all agents that the metrics need.
struct Signals<'a> {
    position: Vec<Series<'a>>,
    disturbance: Vec<Series<'a>>,
    virtual_position: Vec<Series<'a>>,
    virtual_velocity: Vec<Series<'a>>,
    virtual_input: Vec<Series<'a>>,
    virtual_sliding: Vec<Series<'a>>,
    desired: Vec<Series<'a>>,
    estimate: Vec<Series<'a>>,
    network: Vec<Series<'a>>,
    estimated_position: Vec<Series<'a>>,
    observer_sliding: Vec<Series<'a>>,
    input: Vec<Series<'a>>,
    attitude_reference: Vec<Series<'a>>,
    sliding_position: Vec<Series<'a>>,
    sliding_attitude: Vec<Series<'a>>,
}

impl<'a> Signals<'a> {
    fn read(run: &Run<'a>) -> Result<Self, MetricError> {
        Ok(Self {
            position: run.signals(Role::Plant, "position")?,
            disturbance: run.signals(Role::Plant, "disturbance")?,
            virtual_position: run.signals(Role::Planner, "position")?,
            virtual_velocity: run.signals(Role::Planner, "velocity")?,
            virtual_input: run.signals(Role::Planner, "acceleration")?,
            virtual_sliding: run.signals(Role::Planner, "sliding")?,
            desired: run.signals(Role::Planner, "desired_position")?,
            estimate: run.signals(Role::Observer, "disturbance")?,
            network: run.signals(Role::Observer, "network")?,
            estimated_position: run.signals(Role::Observer, "position")?,
            observer_sliding: run.signals(Role::Observer, "sliding")?,
            input: run.signals(Role::Controller, "input")?,
            attitude_reference: run.signals(Role::Controller, "attitude_reference")?,
            sliding_position: run.signals(Role::Controller, "sliding_position")?,
            sliding_attitude: run.signals(Role::Controller, "sliding_attitude")?,
        })
    }
}

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new(
        "x_til",
        "‖x − x̂‖",
        "m, rad",
        "Position and attitude against the observer's estimate; all vehicles, largest in the last quarter.",
    ),
    Definition::new(
        "s_til",
        "‖s̃‖",
        "m/s, rad/s",
        "Sliding variable of the observer; all vehicles, largest in the last quarter.",
    ),
    Definition::new(
        "w_til",
        "‖w − ŵ‖",
        "m/s², rad/s²",
        "Uncertainty against its estimate; all vehicles, largest in the last quarter.",
    ),
    Definition::new(
        "w_til_nn",
        "‖w − Ŵᵀφ‖",
        "m/s², rad/s²",
        "Uncertainty against the output of the neural network alone; all vehicles, largest in the last quarter.",
    ),
    Definition::new(
        "dx_p",
        "‖p − x̄‖",
        "m",
        "Position against that of the virtual agent; all vehicles, largest in the last quarter.",
    ),
    Definition::new(
        "s_p",
        "‖s_p‖",
        "m/s",
        "Sliding variable of the position loop; all vehicles, largest in the last quarter.",
    ),
    Definition::new(
        "dx_a",
        "‖a − a_d‖",
        "rad",
        "Attitude against the desired attitude; all vehicles, largest in the last quarter.",
    ),
    Definition::new(
        "s_a_hat",
        "‖ŝ_a‖",
        "rad/s",
        "Sliding variable of the attitude loop; all vehicles, largest in the last quarter.",
    ),
    Definition::new(
        "s_a_hat_median",
        "median ‖ŝ_a‖",
        "rad/s",
        "Sliding variable of the attitude loop; all vehicles, median over the last quarter.",
    ),
    Definition::new(
        "track",
        "‖p − x_d‖",
        "m",
        "Position against the desired position in the formation; all vehicles, largest in the last quarter.",
    ),
    Definition::new("psi_err", "|ψ − ψ_d|", "rad", "Yaw error of the worst vehicle, largest in the last quarter."),
    Definition::new(
        "dbar_x",
        "‖δ̄x‖",
        "m",
        "Virtual agents against the desired positions; all agents, largest in the last quarter.",
    ),
    Definition::new(
        "s_bar",
        "‖s̄‖",
        "m/s",
        "Sliding variable of the virtual agents; all agents, largest in the last quarter.",
    ),
    Definition::new(
        "t_virtual",
        "t(‖δ̄x‖ ≤ 0.01)",
        "s",
        "Time from which on the virtual agents stay within 1 cm of the formation.",
    ),
    Definition::new(
        "t_track",
        "t(‖p − x_d‖ ≤ 0.01)",
        "s",
        "Time from which on the vehicles stay within 1 cm of the formation.",
    ),
    Definition::new("overshoot_virtual", "max ‖δ̄x‖", "m", "Largest error of the virtual agents after 10 s."),
    Definition::new("peak_v_bar", "max |v̄|", "m/s", "Largest component of the velocity of any virtual agent."),
    Definition::new("peak_u_bar", "max |ū|", "m/s²", "Largest component of the acceleration of any virtual agent."),
    Definition::new("max_tilt_deg", "max |φ|, |θ|", "°", "Largest roll or pitch of any vehicle."),
    Definition::new("max_tilt_ref_deg", "max |φ_d|, |θ_d|", "°", "Largest desired roll or pitch of any vehicle."),
    Definition::new(
        "obs_peak_ratio_0_2s",
        "max ‖ŵ‖/‖w‖",
        "",
        "Largest ratio of estimated to true uncertainty in the first 2 s.",
    ),
    Definition::new(
        "tv_what_0_2s",
        "TV(ŵ)",
        "m/s², rad/s²",
        "Total variation of the estimated uncertainty from 0 to 2 s, all vehicles.",
    ),
    Definition::new(
        "tv_what_2_4s",
        "TV(ŵ)",
        "m/s², rad/s²",
        "Total variation of the estimated uncertainty from 2 to 4 s, all vehicles.",
    ),
    Definition::new(
        "w_til_at_2s",
        "‖w − ŵ‖(2 s)",
        "m/s², rad/s²",
        "Error of the estimated uncertainty at 2 s, all vehicles.",
    ),
    Definition::new("tv4_T", "TV(T)", "N", "Total variation of the thrust in the first 4 s, all vehicles."),
    Definition::new("tv4_tau{j}", "TV(τ{j})", "N m", "Total variation of a torque in the first 4 s, all vehicles."),
    Definition::new(
        "tvq_uav{i}",
        "TV(τ1) + TV(τ2)",
        "N m",
        "Total variation of roll and pitch torque of one vehicle in the last quarter: chatter.",
    ),
    Definition::new("peak_ui_min", "min f", "N", "Smallest force of any motor."),
    Definition::new("peak_ui_max", "max f", "N", "Largest force of any motor."),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let signals = Signals::read(run)?;
    let mut metrics = settled(run, &signals)?;
    metrics.extend(transient(run, &signals));
    metrics.extend(inputs(run, &signals));
    Ok(metrics)
}

/// Norm over all agents of `difference(agent, k)`.
fn stacked(run: &Run, between: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    run.history(|k| (0..run.agents()).map(|i| between(i, k).powi(2)).sum::<f64>().sqrt())
}

fn stacked_norm(run: &Run, series: &[Series]) -> Vec<f64> {
    run.history(|k| series.iter().map(|series| square_sum(series.row(k))).sum::<f64>().sqrt())
}

fn settled(run: &Run, s: &Signals) -> Result<Vec<Metric>, MetricError> {
    let quarter = run.last_quarter();
    let bound = |id: &str, history: &[f64]| Metric::new(id, maximum_from(history, quarter));
    let attitude_error = stacked(run, |i, k| norm_between(&s.position[i].row(k)[3..], s.attitude_reference[i].row(k)));
    let sliding_attitude = stacked_norm(run, &s.sliding_attitude);
    let desired_yaw = |i: usize, k: usize| s.attitude_reference[i].row(k)[2];
    let yaw = run.history(|k| maximum((0..run.agents()).map(|i| (s.position[i].row(k)[5] - desired_yaw(i, k)).abs())));
    Ok(vec![
        bound("x_til", &stacked(run, |i, k| norm_between(s.position[i].row(k), s.estimated_position[i].row(k)))),
        bound("s_til", &stacked_norm(run, &s.observer_sliding)),
        bound("w_til", &stacked(run, |i, k| norm_between(s.disturbance[i].row(k), s.estimate[i].row(k)))),
        bound("w_til_nn", &stacked(run, |i, k| norm_between(s.disturbance[i].row(k), s.network[i].row(k)))),
        bound("dx_p", &stacked(run, |i, k| norm_between(s.position[i].row(k), s.virtual_position[i].row(k)))),
        bound("s_p", &stacked_norm(run, &s.sliding_position)),
        bound("dx_a", &attitude_error),
        bound("s_a_hat", &sliding_attitude),
        Metric::new("s_a_hat_median", median(&sliding_attitude[quarter..])),
        bound("track", &track(run, s)),
        bound("psi_err", &yaw),
        bound("dbar_x", &virtual_error(run, s)),
        bound("s_bar", &stacked_norm(run, &s.virtual_sliding)),
    ])
}

/// ‖p - xd‖ over all agents.
fn track(run: &Run, s: &Signals) -> Vec<f64> {
    stacked(run, |i, k| norm_between(s.position[i].row(k), s.desired[i].row(k)))
}

/// ‖x̄ - xd‖ over all agents.
fn virtual_error(run: &Run, s: &Signals) -> Vec<f64> {
    stacked(run, |i, k| norm_between(s.virtual_position[i].row(k), s.desired[i].row(k)))
}

fn transient(run: &Run, s: &Signals) -> Vec<Metric> {
    let instant = |history: &[f64]| first_below_for_good(history, 0.01).map_or(f64::NAN, |k| run.time(k));
    let virtual_error = virtual_error(run, s);
    let largest = |series: &[Series]| {
        maximum(series.iter().flat_map(|series| series.rows()).map(|row| maximum(row.iter().map(|v| v.abs()))))
    };
    let tilt = |series: &[Series], columns: std::ops::Range<usize>| {
        let rows = series.iter().flat_map(|series| series.rows());
        maximum(rows.flat_map(|row| row[columns.clone()].iter().map(|angle| angle.abs()))).to_degrees()
    };
    let ratio = run.history(|k| {
        let square = |series: &[Series]| series.iter().map(|series| square_sum(series.row(k))).sum::<f64>();
        (square(&s.estimate) / square(&s.disturbance)).sqrt()
    });
    let two = run.sample_at(2.0).min(run.samples() - 1);
    let four = run.sample_at(4.0).min(run.samples() - 1);
    let error_of_estimate = stacked(run, |i, k| norm_between(s.disturbance[i].row(k), s.estimate[i].row(k)));
    vec![
        Metric::new("t_virtual", instant(&virtual_error)),
        Metric::new("t_track", instant(&track(run, s))),
        Metric::new("overshoot_virtual", maximum_from(&virtual_error, run.sample_at(10.0) + 1)),
        Metric::new("peak_v_bar", largest(&s.virtual_velocity)),
        Metric::new("peak_u_bar", largest(&s.virtual_input)),
        Metric::new("max_tilt_deg", tilt(&s.position, 3..5)),
        Metric::new("max_tilt_ref_deg", tilt(&s.attitude_reference, 0..2)),
        Metric::new("obs_peak_ratio_0_2s", maximum(ratio[..=two].iter().copied())),
        Metric::new("tv_what_0_2s", variation(&s.estimate, 0..6, 0, two)),
        Metric::new("tv_what_2_4s", variation(&s.estimate, 0..6, two, four)),
        Metric::new("w_til_at_2s", error_of_estimate[two]),
    ]
}

/// Total variation of some components of all agents between two samples, both included.
fn variation(series: &[Series], columns: std::ops::Range<usize>, first: usize, last: usize) -> f64 {
    let one =
        |series: &Series, column: usize| total_variation(series.component(column).skip(first).take(last - first + 1));
    series.iter().map(|series| columns.clone().map(|column| one(series, column)).sum::<f64>()).sum()
}

fn inputs(run: &Run, s: &Signals) -> Vec<Metric> {
    let last = run.samples() - 1;
    let four = run.sample_at(4.0).min(last);
    let mut metrics: Vec<Metric> = ["T", "tau1", "tau2", "tau3"]
        .iter()
        .enumerate()
        .map(|(j, name)| Metric::new(format!("tv4_{name}"), variation(&s.input, j..j + 1, 0, four)))
        .collect();
    for i in 0..run.agents() {
        let late = variation(&s.input[i..=i], 1..3, run.last_quarter(), last);
        metrics.push(Metric::new(format!("tvq_uav{}", i + 1), late));
    }
    let forces = (0..run.agents()).flat_map(|i| {
        let quadcopter = run.scenario.context.agents[i].vehicle.quadcopter();
        s.input[i].rows().filter_map(move |row| Some(quadcopter?.motor_forces(&[row[0], row[1], row[2], row[3]])))
    });
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for force in forces.flatten() {
        least = least.min(force);
        most = most.max(force);
    }
    metrics.push(Metric::new("peak_ui_min", least));
    metrics.push(Metric::new("peak_ui_max", most));
    metrics
}
