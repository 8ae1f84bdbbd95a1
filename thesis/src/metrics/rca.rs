//! Metrics of the scenario with reference correction. (specification ch3-rca, section 11)

use formation::nalgebra::Vector2;
use formation::scenario::Boundary;
use formation::wiring::Role;

use orchestrator::judge::metrics::{
    Definition, Metric, MetricError, Run, edges, first_below_for_good, maximum, maximum_from, norm, norm_between,
    one_norm_between,
};
use recording::Series;

/// A reference that moves farther than this within one step has jumped, m.
const JUMP: f64 = 0.05;

/// Bounds for the convergence times of the two observation errors.
const FOUND_MISMATCHED: f64 = 0.02;
const FOUND_MATCHED: f64 = 0.05;

/// The signals of one agent that the metrics need.
struct Signals<'a> {
    position: Series<'a>,
    reference: Series<'a>,
    given: Series<'a>,
    flag: Series<'a>,
    sliding: Series<'a>,
    input: Series<'a>,
    mismatched: [Series<'a>; 2],
    disturbance: [Series<'a>; 2],
    boundaries: Vec<Boundary>,
}

impl<'a> Signals<'a> {
    fn read(run: &Run<'a>, agent: usize) -> Result<Self, MetricError> {
        let signal = |role, field| run.signal(role, agent, field);
        let context = &run.scenario.context;
        let radius = context.agents[agent].vehicle.omni().map_or(0.0, |omni| omni.radius);
        Ok(Self {
            position: signal(Role::Plant, "position")?,
            reference: signal(Role::Planner, "position")?,
            given: signal(Role::Planner, "desired_position")?,
            flag: signal(Role::Planner, "flag")?,
            sliding: signal(Role::Controller, "sliding")?,
            input: signal(Role::Controller, "input")?,
            mismatched: [signal(Role::Plant, "mismatched")?, signal(Role::Observer, "mismatched")?],
            disturbance: [signal(Role::Plant, "disturbance")?, signal(Role::Observer, "disturbance")?],
            boundaries: context.obstacles.as_ref().map_or_else(Vec::new, |obstacles| obstacles.boundaries(radius)),
        })
    }

    /// ‖δx‖ at every sample, against the corrected reference.
    fn deviation(&self, run: &Run) -> Vec<f64> {
        run.history(|k| norm_between(self.position.row(k), self.reference.row(k)))
    }

    fn sliding(&self, run: &Run) -> Vec<f64> {
        run.history(|k| norm(self.sliding.row(k)))
    }

    /// The obstacle that the flag names at every sample; 0: none.
    fn flags(&self) -> Vec<f64> {
        self.flag.component(0).collect()
    }
}

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new(
        "Delta_{i}",
        "Δ_{i}",
        "m s, rad s",
        "Integral of the 1-norm of the deviation from the corrected reference, one agent (3.19).",
    ),
    Definition::new(
        "Delta_given_{i}",
        "Δ_{i}",
        "m s, rad s",
        "Integral of the 1-norm of the deviation from the reference as given, one agent.",
    ),
    Definition::new(
        "gap_min_{i}",
        "min d_{i}",
        "m",
        "Smallest distance to an inner boundary of an obstacle; below zero: collision.",
    ),
    Definition::new("flag_time_{i}", "t", "s", "How long the agent's correction is active."),
    Definition::new("flag_on_{i}", "t", "s", "Time at which the correction first becomes active; -1: never."),
    Definition::new("flag_edges_{i}", "", "", "Number of times that the correction starts or ends."),
    Definition::new(
        "flag_obstacle_{i}",
        "",
        "",
        "Number of the obstacle that triggers the correction; 0: none, -1: several.",
    ),
    Definition::new("ref_jumps_{i}", "", "", "Number of steps in which the corrected reference moves more than 5 cm."),
    Definition::new(
        "dx_max_5s_{i}",
        "max ‖δx_{i}‖",
        "m, rad",
        "Deviation from the corrected reference, largest after 5 s.",
    ),
    Definition::new("s_max_5s_{i}", "max ‖s_{i}‖", "m/s, rad/s", "Sliding variable, largest after 5 s."),
    Definition::new(
        "dx_quiet",
        "max ‖δx_i‖",
        "m, rad",
        "Deviation from the corrected reference; worst agent, largest in the last tenth.",
    ),
    Definition::new("s_quiet", "max ‖s_i‖", "m/s, rad/s", "Sliding variable; worst agent, largest in the last tenth."),
    Definition::new(
        "d_err_bound",
        "max ‖d_i − d̂_i‖",
        "m/s, rad/s",
        "Mismatched disturbance against its estimate; worst agent, largest in the last tenth.",
    ),
    Definition::new(
        "w_err_bound",
        "max ‖w_i − ŵ_i‖",
        "m/s², rad/s²",
        "Matched uncertainty against its estimate; worst agent, largest in the last tenth.",
    ),
    Definition::new(
        "d_err_conv",
        "t(‖d_i − d̂_i‖ ≤ 0.02)",
        "s",
        "Time from which on every error of the mismatched estimate stays below 0.02.",
    ),
    Definition::new(
        "w_err_conv",
        "t(‖w_i − ŵ_i‖ ≤ 0.05)",
        "s",
        "Time from which on every error of the matched estimate stays below 0.05.",
    ),
    Definition::new("u_max", "max |u|", "m/s², rad/s²", "Largest component of any input."),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let agents: Vec<Signals> = (0..run.agents()).map(|agent| Signals::read(run, agent)).collect::<Result<_, _>>()?;
    let mut metrics = Vec::new();
    let mut each = |name: &str, value: &dyn Fn(&Signals) -> Option<f64>| {
        let values = (1..).zip(&agents).filter_map(|(number, agent)| Some((number, value(agent)?)));
        metrics.extend(values.map(|(number, value): (usize, f64)| Metric::new(format!("{name}_{number}"), value)));
    };
    let periods = run.samples() - 1;
    each("Delta", &|agent| Some(deviation_integral(run, &agent.position, &agent.reference))); // (3.19)
    each("Delta_given", &|agent| Some(deviation_integral(run, &agent.position, &agent.given)));
    each("gap_min", &smallest_gap);
    each("flag_time", &|agent| {
        Some(agent.flags()[..periods].iter().filter(|flag| **flag != 0.0).count() as f64 * run.dt())
    });
    each("flag_on", &|agent| {
        let first = agent.flags().iter().position(|flag| *flag != 0.0);
        Some(first.map_or(-1.0, |k| run.time(k)))
    });
    each("flag_edges", &|agent| Some(edges(agent.flags().iter().map(|flag| *flag != 0.0)) as f64));
    each("flag_obstacle", &|agent| Some(flagged_obstacle(&agent.flags())));
    each("ref_jumps", &|agent| Some(jumps(&agent.reference)));
    each("dx_max_5s", &|agent| Some(maximum_from(&agent.deviation(run), run.sample_at(5.0))));
    each("s_max_5s", &|agent| Some(maximum_from(&agent.sliding(run), run.sample_at(5.0))));
    metrics.extend(overall(run, &agents));
    Ok(metrics)
}

/// What concerns all agents: the largest over them.
fn overall(run: &Run, agents: &[Signals]) -> Vec<Metric> {
    let worst = |of: &dyn Fn(&Signals) -> Vec<f64>| {
        let histories: Vec<Vec<f64>> = agents.iter().map(of).collect();
        run.history(|k| maximum(histories.iter().map(|history| history[k])))
    };
    let error = |[truth, estimate]: &[Series; 2]| run.history(|k| norm_between(truth.row(k), estimate.row(k)));
    let mismatched = worst(&|agent| error(&agent.mismatched));
    let matched = worst(&|agent| error(&agent.disturbance));
    let quiet = |history: &[f64]| maximum_from(history, run.sample_at(0.9 * run.time(run.samples() - 1)));
    let found = |history: &[f64], bound| first_below_for_good(history, bound).map_or(f64::NAN, |k| run.time(k));
    let inputs = agents.iter().flat_map(|agent| agent.input.rows()).flatten();
    vec![
        Metric::new("dx_quiet", quiet(&worst(&|agent| agent.deviation(run)))),
        Metric::new("s_quiet", quiet(&worst(&|agent| agent.sliding(run)))),
        Metric::new("d_err_bound", quiet(&mismatched)),
        Metric::new("w_err_bound", quiet(&matched)),
        Metric::new("d_err_conv", found(&mismatched, FOUND_MISMATCHED)),
        Metric::new("w_err_conv", found(&matched, FOUND_MATCHED)),
        Metric::new("u_max", maximum(inputs.map(|input| input.abs()))),
    ]
}

/// Σ dt ‖position - reference‖₁ over all periods.
fn deviation_integral(run: &Run, position: &Series, reference: &Series) -> f64 {
    (0..run.samples() - 1).map(|k| run.dt() * one_norm_between(position.row(k), reference.row(k))).sum()
}

/// Smallest distance to an inner boundary; `None` if there are no obstacles.
fn smallest_gap(agent: &Signals) -> Option<f64> {
    let gap =
        |row: &[f64], boundary: &Boundary| (Vector2::new(row[0], row[1]) - boundary.centre).norm() - boundary.inner;
    let gaps = agent.boundaries.iter().flat_map(|boundary| agent.position.rows().map(move |row| gap(row, boundary)));
    gaps.reduce(|a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) })
}

/// The obstacle that all flags name; 0 without flags, -1 if they name several.
fn flagged_obstacle(flags: &[f64]) -> f64 {
    let mut named = flags.iter().filter(|flag| **flag != 0.0);
    let first = named.next().copied().unwrap_or(0.0);
    if named.all(|flag| *flag == first) { first } else { -1.0 }
}

/// Number of steps within which a reference jumped in the plane.
fn jumps(reference: &Series) -> f64 {
    let moves = reference.rows().zip(reference.rows().skip(1));
    moves.filter(|(before, now)| norm_between(&before[..2], &now[..2]) > JUMP).count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_name_one_obstacle_or_several() {
        assert_eq!(flagged_obstacle(&[0.0, 0.0]), 0.0);
        assert_eq!(flagged_obstacle(&[0.0, 2.0, 2.0, 0.0]), 2.0);
        assert_eq!(flagged_obstacle(&[1.0, 0.0, 2.0]), -1.0);
    }
}
