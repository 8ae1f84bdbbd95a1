//! Metrics of the dynamic sliding mode scenarios. (specification ch2-dsm, section 11)
//!
//! Norms are per agent over its three components. A bound holds for all agents over the last quarter of the run; of a run that
//! broke off before that it is not a number.

use formation::formula::Jet;
use formation::wiring::Role;

use orchestrator::judge::metrics::{
    Definition, Metric, MetricError, Run, first_below_for_good, maximum, norm, norm_between,
};
use recording::Series;

/// Coordinates of an agent.
const D: usize = 3;

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new("dx_bound", "max ‖δx_i‖", "m, rad", "Formation error; worst agent, largest in the last quarter."),
    Definition::new(
        "xi_bound",
        "max ‖ξ_i‖",
        "m/s², rad/s²",
        "Sliding variable; worst agent, largest in the last quarter.",
    ),
    Definition::new(
        "dx_conv_1e-2",
        "t(‖δx_i‖ ≤ 1e-2)",
        "s",
        "Time from which on every formation error stays below 0.01.",
    ),
    Definition::new(
        "dx_conv_5e-2",
        "t(‖δx_i‖ ≤ 5e-2)",
        "s",
        "Time from which on every formation error stays below 0.05.",
    ),
    Definition::new("u_max", "max |u|", "m/s², rad/s²", "Largest component of any input."),
    Definition::new(
        "u_slew",
        "max |Δu|/dt",
        "m/s³, rad/s³",
        "Fastest change of any input component in the last quarter: chatter.",
    ),
    Definition::new("dx_20_27", "max ‖δx_i‖", "m, rad", "Formation error; worst agent, largest from 20 to 27 s."),
    Definition::new("xi_20_27", "max ‖ξ_i‖", "m/s², rad/s²", "Sliding variable; worst agent, largest from 20 to 27 s."),
    Definition::new(
        "w_err_bound",
        "max ‖w_i − ŵ_i‖",
        "m/s², rad/s²",
        "Uncertainty against the observer's estimate; worst agent, largest in the last quarter.",
    ),
    Definition::new(
        "wdot_err_bound",
        "max ‖ẇ_i − γ_3i‖",
        "m/s³, rad/s³",
        "Rate of the uncertainty against its estimate; worst agent, largest in the last quarter.",
    ),
    Definition::new(
        "w_err_conv",
        "t(‖w_i − ŵ_i‖ ≤ 0.05)",
        "s",
        "Time from which on every error of the estimated uncertainty stays below 0.05.",
    ),
    Definition::new(
        "E_err_bound",
        "max ‖E_i − Ê_i‖",
        "m/s³, rad/s³",
        "Learned quantity E = ẇ + (k + λ) w against the network; worst agent, largest in the last quarter.",
    ),
    Definition::new("E_err_bound_{i}", "max ‖E_{i} − Ê_{i}‖", "m/s³, rad/s³", "As `E_err_bound`, of one agent."),
    Definition::new("E_err_20_27", "max ‖E_i − Ê_i‖", "m/s³, rad/s³", "As `E_err_bound`, from 20 to 27 s."),
    Definition::new("W_norm_max", "max ‖W_i‖_F", "", "Largest Frobenius norm of the weights of any agent."),
    Definition::new(
        "zeta_gap",
        "max |ζ − ζ̄|",
        "",
        "Hysteresis state of the actuators against that of the inverse model, largest of the run.",
    ),
    Definition::new(
        "h_minus_pi",
        "max |h − π|",
        "m/s², rad/s²",
        "Input that the actuators give against the one that was commanded, largest of the run.",
    ),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let mut metrics = tracking(run)?;
    if (0..run.agents()).all(|agent| run.offers(Role::Observer, agent, "disturbance_rate")) {
        metrics.extend(observer(run)?);
    }
    if (0..run.agents()).all(|agent| run.offers(Role::Controller, agent, "network")) {
        metrics.extend(network(run)?);
        metrics.extend(compensation(run)?);
    }
    Ok(metrics)
}

/// The samples of the last quarter of the run as it was planned.
fn last_quarter(run: &Run) -> std::ops::Range<usize> {
    run.sample_at(0.75 * run.scenario.context.timing.duration)..run.samples()
}

/// The samples between 20 s and 27 s, where all four robots of section 2.5 are away from the origin.
fn window(run: &Run) -> std::ops::Range<usize> {
    let last = (27.0 / run.dt() + 1e-9).floor() as usize;
    run.sample_at(20.0)..run.samples().min(last + 1)
}

/// The largest value of some samples; NaN if there are none.
fn largest(history: &[f64], samples: std::ops::Range<usize>) -> f64 {
    maximum(history.get(samples).unwrap_or_default().iter().copied())
}

/// The largest of all agents at each sample.
fn worst(run: &Run, of: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    run.history(|k| maximum((0..run.agents()).map(|agent| of(agent, k))))
}

/// The time from which on a history stays below `level`; NaN if it does not, or if the run ended before that is known.
fn settling(run: &Run, history: &[f64], level: f64) -> f64 {
    let complete = run.samples() as u64 == run.scenario.context.timing.periods() + 1;
    let first = first_below_for_good(history, level).filter(|_| complete);
    first.map_or(f64::NAN, |k| run.time(k))
}

fn tracking(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let position = run.signals(Role::Plant, "position")?;
    let reference = run.signals(Role::Planner, "position")?;
    let sliding = run.signals(Role::Controller, "sliding")?;
    let input = run.signals(Role::Controller, "input")?;
    let error = worst(run, |agent, k| norm_between(position[agent].row(k), reference[agent].row(k)));
    let sliding = worst(run, |agent, k| norm(sliding[agent].row(k)));
    let slew = worst(run, |agent, k| {
        let before = input[agent].row(k.max(1) - 1);
        let changes = input[agent].row(k).iter().zip(before).map(|(now, before)| (now - before).abs());
        maximum(changes) / run.dt()
    });
    let mut metrics = vec![
        Metric::new("dx_bound", largest(&error, last_quarter(run))),
        Metric::new("xi_bound", largest(&sliding, last_quarter(run))),
        Metric::new("dx_conv_1e-2", settling(run, &error, 1e-2)),
        Metric::new("dx_conv_5e-2", settling(run, &error, 5e-2)),
        Metric::new("u_max", largest_component(&input)),
        Metric::new("u_slew", largest(&slew, last_quarter(run))),
    ];
    if run.scenario.context.timing.duration >= 27.0 {
        metrics.push(Metric::new("dx_20_27", largest(&error, window(run))));
        metrics.push(Metric::new("xi_20_27", largest(&sliding, window(run))));
    }
    Ok(metrics)
}

fn largest_component(series: &[Series]) -> f64 {
    maximum(series.iter().flat_map(|series| series.rows()).flatten().map(|value| value.abs()))
}

/// The uncertainty of one agent and its rate, at every sample.
struct Uncertainty<'a> {
    value: Series<'a>,
    rate: Vec<[f64; D]>,
}

impl<'a> Uncertainty<'a> {
    /// The rate is the derivative of the scenario's formulas along the recorded motion. The acceleration at an instant is that
    /// under the command of this instant, whose effect the actuators show at the next sample.
    fn of(run: &Run<'a>, agent: usize) -> Result<Self, MetricError> {
        let value = run.signal(Role::Plant, agent, "disturbance")?;
        let [position, velocity, actuator] =
            ["position", "velocity", "actuator"].map(|name| run.signal(Role::Plant, agent, name));
        let (position, velocity, actuator) = (position?, velocity?, actuator?);
        let formulas = &run.scenario.context.disturbance[agent].matched;
        let moving = |value: f64, rate: f64| Jet { value, rate, ..Jet::default() };
        let at = |k: usize| {
            let mut arguments = [Jet::time(run.time(k)); 1 + 2 * D];
            let input = actuator.row((k + 1).min(run.samples() - 1));
            for j in 0..D {
                let v = velocity.row(k)[j];
                arguments[1 + j] = moving(position.row(k)[j], v);
                arguments[1 + D + j] = moving(v, input[j] + value.row(k)[j]); // (2.4)
            }
            let mut rate = [0.0; D];
            for (rate, formula) in rate.iter_mut().zip(formulas) {
                *rate = formula.evaluate_jet(&arguments).rate;
            }
            rate
        };
        Ok(Self { value, rate: (0..run.samples()).map(at).collect() })
    }

    fn all(run: &Run<'a>) -> Result<Vec<Self>, MetricError> {
        (0..run.agents()).map(|agent| Self::of(run, agent)).collect()
    }
}

fn observer(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let truth = Uncertainty::all(run)?;
    let estimate = run.signals(Role::Observer, "disturbance")?;
    let rate = run.signals(Role::Observer, "disturbance_rate")?;
    let error = worst(run, |agent, k| norm_between(truth[agent].value.row(k), estimate[agent].row(k)));
    let rate_error = worst(run, |agent, k| norm_between(&truth[agent].rate[k], rate[agent].row(k)));
    Ok(vec![
        Metric::new("w_err_bound", largest(&error, last_quarter(run))),
        Metric::new("wdot_err_bound", largest(&rate_error, last_quarter(run))),
        Metric::new("w_err_conv", settling(run, &error, 0.05)),
    ])
}

/// The parameter `name` of the controller.
fn gain(run: &Run, name: &str) -> Result<f64, MetricError> {
    let section = run.scenario.section("controller");
    let value = section.and_then(|section| section.at(name)).and_then(|node| node.as_f64());
    value.ok_or_else(|| MetricError::NotApplicable {
        set: run.scenario.metrics.clone(),
        reason: format!("its controller learns the uncertainty but has no gain `{name}`"),
    })
}

/// What the network learns, `E = dw/dt + (k + λ) w`, and what it says of it.
struct Learning<'a> {
    slope: f64,
    truth: Vec<Uncertainty<'a>>,
    estimate: Vec<Series<'a>>,
}

impl<'a> Learning<'a> {
    fn of(run: &Run<'a>) -> Result<Self, MetricError> {
        let slope = gain(run, "k")? + gain(run, "lam")?;
        Ok(Self { slope, truth: Uncertainty::all(run)?, estimate: run.signals(Role::Controller, "network")? })
    }

    /// ‖E_i - Ê_i‖ of an agent at sample `k`.
    fn error(&self, agent: usize, k: usize) -> f64 {
        let Uncertainty { value, rate } = &self.truth[agent];
        let mut learned = rate[k];
        for (learned, value) in learned.iter_mut().zip(value.row(k)) {
            *learned += self.slope * value;
        }
        norm_between(&learned, self.estimate[agent].row(k))
    }
}

/// ‖E_i - Ê_i‖ of every agent at every sample.
pub(super) fn network_error(run: &Run) -> Result<Vec<Vec<f64>>, MetricError> {
    let learning = Learning::of(run)?;
    Ok((0..run.agents()).map(|agent| run.history(|k| learning.error(agent, k))).collect())
}

fn network(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let learning = Learning::of(run)?;
    let weights = run.signals(Role::Controller, "weight_norm")?;
    let of_agent = |agent: usize, k: usize| learning.error(agent, k);
    let bound = |agent: usize| largest(&run.history(|k| of_agent(agent, k)), last_quarter(run));
    let bounds: Vec<f64> = (0..run.agents()).map(bound).collect();
    let mut metrics = vec![Metric::new("E_err_bound", maximum(bounds.iter().copied()))];
    metrics.extend(bounds.iter().zip(1..).map(|(bound, number)| Metric::new(format!("E_err_bound_{number}"), *bound)));
    if run.scenario.context.timing.duration >= 27.0 {
        metrics.push(Metric::new("E_err_20_27", largest(&worst(run, of_agent), window(run))));
    }
    metrics.push(Metric::new("W_norm_max", largest_component(&weights)));
    Ok(metrics)
}

/// The inverse model against the actuators. What the plant shows at a step is what the command of the step before made of it.
fn compensation(run: &Run) -> Result<Vec<Metric>, MetricError> {
    if !(0..run.agents()).all(|agent| run.offers(Role::Plant, agent, "memory")) {
        return Ok(Vec::new());
    }
    let pairs = [("zeta_gap", "memory", "memory"), ("h_minus_pi", "actuator", "nominal")];
    let gap = |(id, actual, imagined): (&str, &str, &str)| {
        let actual = run.signals(Role::Plant, actual)?;
        let imagined = run.signals(Role::Controller, imagined)?;
        let gaps = actual.iter().zip(&imagined).flat_map(|(actual, imagined)| {
            let pairs = actual.rows().skip(1).zip(imagined.rows());
            pairs.map(|(actual, imagined)| maximum(actual.iter().zip(imagined).map(|(a, b)| (a - b).abs())))
        });
        Ok(Metric::new(id, maximum(gaps)))
    };
    pairs.into_iter().map(gap).collect()
}
