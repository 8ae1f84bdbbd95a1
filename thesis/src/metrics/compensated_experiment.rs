//! Metrics of the experiment with emulated robots. (specification ch5-compensated, section 11, emulation)
//!
//! The log of an experiment holds what a laboratory would give: commands and measured poses, not the true poses. Those are
//! computed here: the emulation is deterministic, so that the recorded commands give the poses again. That they are the right
//! ones is proved by what the cameras see of them, which has to be, bit by bit, what was recorded. Where it is not (robots in
//! real time, real robots), the measured poses stand for the true ones, and the metric `lockstep` is 0.

use formation::nalgebra::Vector3;
use formation::wiring::Role;
use plant::Laboratory;
use plant::laboratory::LaboratoryRobot;

use orchestrator::judge::metrics::{
    Definition, Metric, MetricError, Run, maximum, norm, norm_between, square_sum, total_variation,
};
use recording::Series;

/// When the formation has settled, s.
const SETTLED: f64 = 25.0;
/// Just before the first fault, s.
const QUIET: f64 = 17.5;
/// When the observers have settled, s.
const OBSERVED: f64 = 5.0;

/// Poses of all robots at one sample.
type Poses = Vec<Vector3<f64>>;

/// What the metrics mean.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition::new(
        "b_ex_{hold}",
        "‖e‖",
        "m, rad",
        "Local error after 25 s, largest outside the given seconds after a fault; all robots.",
    ),
    Definition::new("b_ex", "‖e‖", "m, rad", "Local error; all robots, largest after 25 s."),
    Definition::new("rms_e", "rms ‖e‖", "m, rad", "Root mean square of the local error after 25 s; all robots."),
    Definition::new(
        "b_x̃_6",
        "max ‖x_i − x̂_i‖",
        "m, rad",
        "Observation error after 25 s, largest outside 6 s after a fault; worst robot.",
    ),
    Definition::new("max_x̃", "max ‖x_i − x̂_i‖", "m, rad", "Observation error, largest after 5 s; worst robot."),
    Definition::new("peak_θ", "max |e_θ|", "rad", "Largest local error of a heading after 17.5 s."),
    Definition::new("TV_late", "TV(e)", "m, rad", "Total variation of the local errors after 17.5 s, all robots."),
    Definition::new(
        "V_early",
        "V",
        "m, rad",
        "Oscillation of the local errors in the first 17.5 s: total variation less net change, all robots.",
    ),
    Definition::new("final_e", "‖e‖", "m, rad", "Local error at the end; all robots."),
    Definition::new("max_u", "max |u|", "m/s", "Largest wheel speed that is commanded."),
    Definition::new("held", "", "", "Number of samples in which a robot's pose was held for lack of a measurement."),
    Definition::new(
        "lockstep",
        "",
        "",
        "1 if the emulation of the recorded commands gives the recorded poses, else 0 (real time, real robots).",
    ),
];

pub(super) fn compute(run: &Run) -> Result<Vec<Metric>, MetricError> {
    let Some(laboratory) = Laboratory::of(run.scenario) else {
        let reason = "the plant of the scenario is not a `laboratory`".to_string();
        return Err(MetricError::NotApplicable { set: run.scenario.metrics.clone(), reason });
    };
    let measured = run.signals(Role::Plant, "position")?;
    let estimated = run.signals(Role::Observer, "position")?;
    let input = run.signals(Role::Controller, "input")?;
    let statuses = run.signals(Role::Plant, "status")?;
    let truth = true_poses(run, &laboratory, &measured, &input);
    let lockstep = truth.is_some();
    let seen = |k: usize| measured.iter().map(|series| Vector3::from_column_slice(series.row(k))).collect();
    let poses = truth.unwrap_or_else(|| (0..run.samples()).map(seen).collect());
    let errors = local_errors(run, &poses)?;
    let stacked: Vec<f64> = errors.iter().map(|of| norm(of.as_flattened())).collect();
    let observed = |k: usize| {
        let each = (0..run.agents()).map(|i| norm_between(measured[i].row(k), estimated[i].row(k)));
        maximum(each)
    };
    let late = || run.sample_at(SETTLED)..run.samples();
    let undisturbed =
        |hold: f64| late().filter(|&k| !follows_a_fault(&laboratory, run.time(k), hold)).collect::<Vec<_>>();
    let variation = |from: usize, to: usize, i: usize, j: usize| total_variation((from..to).map(|k| errors[k][i][j]));
    let channels: Vec<(usize, usize)> = (0..run.agents()).flat_map(|i| (0..3).map(move |j| (i, j))).collect();
    let quiet = run.sample_at(QUIET).min(run.samples() - 1);
    let early =
        channels.iter().map(|&(i, j)| variation(0, quiet + 1, i, j) - (errors[quiet][i][j] - errors[0][i][j]).abs());
    let inputs = input.iter().flat_map(|series| series.rows()).flatten().map(|input| input.abs());
    let held = statuses.iter().flat_map(|series| series.component(0)).filter(|status| *status != 0.0).count();
    let turned = (quiet..run.samples()).flat_map(|k| errors[k].iter().map(|error| error[2].abs()));
    let count = late().len() as f64;
    let mean = late().map(|k| square_sum(errors[k].as_flattened())).sum::<f64>() / count;
    let largest = |hold: f64| maximum(undisturbed(hold).into_iter().map(|k| stacked[k]));
    Ok(vec![
        Metric::new("b_ex_4", largest(4.0)),
        Metric::new("b_ex_6", largest(6.0)),
        Metric::new("b_ex_8", largest(8.0)),
        Metric::new("b_ex_12", largest(12.0)),
        Metric::new("b_ex", maximum(late().map(|k| stacked[k]))),
        Metric::new("rms_e", mean.sqrt()),
        Metric::new("b_x̃_6", maximum(undisturbed(6.0).into_iter().map(observed))),
        Metric::new("max_x̃", maximum((run.sample_at(OBSERVED)..run.samples()).map(observed))),
        Metric::new("peak_θ", maximum(turned)),
        Metric::new("TV_late", channels.iter().map(|&(i, j)| variation(quiet, run.samples(), i, j)).sum()),
        Metric::new("V_early", early.sum()),
        Metric::new("final_e", stacked.last().copied().unwrap_or(f64::NAN)),
        Metric::new("max_u", maximum(inputs)),
        Metric::new("held", held as f64),
        Metric::new("lockstep", f64::from(u8::from(lockstep))),
    ])
}

/// Whether a fault of any robot began so shortly before `time` (`hold` s) that it still counts.
fn follows_a_fault(laboratory: &Laboratory, time: f64, hold: f64) -> bool {
    const TOLERANCE: f64 = 1e-9;
    laboratory.faults.iter().any(|fault| (fault.start - TOLERANCE..=fault.start + hold + TOLERANCE).contains(&time))
}

/// The true poses at all samples, if the emulation of the recorded commands shows what was recorded.
fn true_poses(run: &Run, laboratory: &Laboratory, measured: &[Series], input: &[Series]) -> Option<Vec<Poses>> {
    let context = &run.scenario.context;
    let ticks = laboratory.ticks(run.dt())?;
    let mut poses = vec![Vec::with_capacity(run.agents()); run.samples()];
    for agent in 0..run.agents() {
        let mut robot = LaboratoryRobot::new(laboratory, context, agent);
        let mut seen = robot.pose();
        for (k, poses) in poses.iter_mut().enumerate() {
            if k > 0 {
                let speeds = input[agent].row(k - 1);
                robot.command([speeds[0], speeds[1], speeds[2]]);
                (0..ticks).for_each(|_| robot.advance());
            }
            while let Some(sighting) = robot.take_sighting() {
                seen = sighting.pose.unwrap_or(seen);
            }
            if measured[agent].row(k) != seen {
                return None;
            }
            poses.push(Vector3::from(robot.pose()));
        }
    }
    Some(poses)
}

/// `e` of all robots at all samples.
fn local_errors(run: &Run, poses: &[Poses]) -> Result<Vec<Vec<[f64; 3]>>, MetricError> {
    let reference = run.signals(Role::Planner, "position")?;
    let of_sample = |(k, poses): (usize, &Poses)| {
        let topology = run.topology(k);
        let deviation = |i: usize| poses[i] - Vector3::from_column_slice(reference[i].row(k));
        let local = |i: usize| {
            let others = topology.neighbours(i).iter().map(|&other| deviation(other));
            topology.local_error(i, &deviation(i), others).into()
        };
        (0..poses.len()).map(local).collect()
    };
    Ok(poses.iter().enumerate().map(of_sample).collect())
}
