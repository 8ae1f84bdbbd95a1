//! The points of the contract, one after the other.

use std::path::Path;
use std::time::Duration;

use formation::wiring::{Assembly, SCENARIO_FILE};
use lockstep::{Field, Layout, Network, Plan};
use processes::{Activity, RunError, Settings};

use super::inspect::{Range, departure, labels, out_of_range, speed, unlike, zeros};
use super::point::{Report, Verdict};
use super::probe::probe;
use super::trial::{Trial, attempt};
use crate::failure::Failure;
use crate::run::engine::warn_of_leftovers;
use crate::run::leftovers::Scratch;
use crate::trial::replay::{Duet, Setup};

/// What recorded inputs are multiplied by to be out of all bounds: squares of them are infinite, and differences of those are
/// no numbers at all.
const ABSURD: f64 = 1e200;
/// What a program may print, bytes ...
const PRINTED: u64 = 8192;
/// ... and per step.
const PRINTED_PER_STEP: u64 = 8;
/// The points that are tried in other runs than a good one.
const OF_OTHER_RUNS: [&str; 3] = ["alone", "plan", "signals"];
/// The points that need a whole run.
const OF_A_RUN: [&str; 8] = ["outputs", "inputs", "end", "left", "output", "repeat", "stop", "absurd"];

/// What to do about a program that ...
const STILL_STARTING: &str =
    "give it more time with --patience SECONDS; a run gives a program three deadlines to connect";
const HANGS_AT_START: &str =
    "it has joined the run and does not get ready: see what it does between opening the participant and its first step";
const REFUSED: &str =
    "bind the signals that the finding lists, or try it with the scenario that it is written for: --scenario NAME";
const DIES_AT_START: &str = "start it by hand: outside a run, a program that works says only how it is started";

/// What is tried, and what is asked of it.
pub struct Demands<'a> {
    /// The scenario, as long as the program is to be tried.
    pub assembly: &'a Assembly,
    /// A log of it.
    pub log: &'a Path,
    /// Number of the node that the program plays.
    pub node: usize,
    /// The program and its arguments.
    pub words: &'a [String],
    /// How long the program may take to start, for a step, and to end.
    pub patience: Duration,
    /// Ranges of its outputs.
    pub ranges: Vec<Range>,
    /// The core of all processes; `None`: the operating system decides.
    pub core: Option<usize>,
}

/// Tries a program, point by point.
///
/// # Errors
/// [`Failure`] if it cannot be tried: the log cannot be read, a process of our own cannot be started.
pub fn conform(demands: &Demands) -> Result<Report, Failure> {
    let folder = Scratch::create()?;
    let (words, patience, folder) = (demands.words, demands.patience, folder.path());
    let (assembly, node) = (demands.assembly, demands.node);
    let settings =
        Settings { deadline: patience, grace: patience, forward_output: false, replacements: 0, ..Settings::default() };
    let steps = assembly.scenario.context.timing.periods() + 1;
    let setup = Setup {
        assembly,
        network: &assembly.network,
        log: demands.log,
        only: node,
        robot: None,
        factor: 1.0,
        settings,
        start_timeout: patience,
        traced: u32::try_from(steps).unwrap_or(u32::MAX),
        core: demands.core,
    };
    let mut report = Report::default();

    let first = attempt(&setup, words, None, folder)?;
    if let Some(reason) = first.end.as_ref().and_then(|end| end.not_started.as_ref()) {
        return Err(Failure::Usage(format!("cannot start {}: {reason}", words[0])));
    }
    let Some(connected) = first.connected else {
        return not_started(report, first, patience);
    };
    report.add("start", Verdict::Pass, format!("after {:.0} ms", connected.as_secs_f64() * 1e3));
    refusals(&mut report, &setup, words, folder)?;
    let complete = first.steps == steps;
    let answered = if complete { format!("all {steps}") } else { first.reason() };
    report.judge("steps", complete, answered);
    whole_run(&mut report, demands, &first, complete);
    if complete {
        let second = attempt(&setup, words, None, folder)?;
        let found = unlike(&first, &second, &labels(&assembly.network, node));
        let found = if second.steps < steps { Some(format!("the second time: {}", second.reason())) } else { found };
        let same = format!("twice {} numbers", first.outputs.len());
        report.judge("repeat", found.is_none(), found.unwrap_or(same));
        let stopped = attempt(&setup, words, Some(steps / 2), folder)?;
        report.judge("stop", stopped.ended_well(), stopped.describe_end(patience));
        absurd(&mut report, &attempt(&Setup { factor: ABSURD, ..setup }, words, None, folder)?);
        report.add("reference", Verdict::Note, departure(&first));
        report.add("speed", Verdict::Note, speed(&first.lengths, assembly.scenario.context.timing.dt));
    } else {
        report.skip(&["repeat", "stop", "absurd"], "it does not answer every step");
    }
    Ok(report)
}

/// A program that does not get as far as its first step. What it does in other runs says nothing then.
fn not_started(mut report: Report, first: Trial, patience: Duration) -> Result<Report, Failure> {
    let (verdict, advice) = match &first.stopped {
        Some(RunError::NotReady { missing, .. }) if missing.iter().all(|late| late.activity == Activity::Starting) => {
            (Verdict::Untried, STILL_STARTING)
        }
        Some(RunError::NotReady { .. }) => (Verdict::Fail, HANGS_AT_START),
        Some(RunError::Refused { .. }) => (Verdict::Fail, REFUSED),
        Some(RunError::Died { .. }) | None => (Verdict::Fail, DIES_AT_START),
        // Nothing that the program could help.
        Some(_) => return Err(first.stopped.map_or(Failure::Interrupted, Failure::from)),
    };
    let finding = match verdict {
        Verdict::Untried => format!(
            "it has not opened its place in the run after {:.1} s: it is still starting, or is no participant",
            patience.as_secs_f64()
        ),
        _ => first.reason(),
    };
    report.add_with("start", verdict, finding, advice);
    let reason = if verdict == Verdict::Untried { "it is still starting" } else { "it does not start" };
    report.skip(&OF_OTHER_RUNS, reason);
    report.skip(&["steps"], reason);
    report.skip(&OF_A_RUN, reason);
    Ok(report)
}

/// What it does without a run, with a plan that is not right, and in a run of other signals.
fn refusals(report: &mut Report, setup: &Setup, words: &[String], folder: &Path) -> Result<(), Failure> {
    let patience = setup.start_timeout;
    let alone = probe(words, None, folder, patience)?;
    report.judge("alone", alone.refused(), alone.describe(patience));
    wrong_plan(setup, folder)?;
    let plan = probe(words, Some(folder), folder, patience)?;
    report.judge("plan", plan.refused(), plan.describe(patience));
    let network = other_signals(&setup.assembly.network, setup.only);
    let other = attempt(&Setup { network: &network, ..*setup }, words, Some(0), folder)?;
    match &other.stopped {
        Some(RunError::Refused { message, .. }) => {
            report.add("signals", Verdict::Pass, format!("it says: \"{message}\""))
        }
        Some(_) => report.judge("signals", other.end.as_ref().is_some_and(|end| end.code > Some(0)), other.reason()),
        None => report.add("signals", Verdict::Fail, "it takes part in a run in which its outputs have other names"),
    }
    Ok(())
}

/// What one run tells.
fn whole_run(report: &mut Report, demands: &Demands, trial: &Trial, complete: bool) {
    let labels = labels(&demands.assembly.network, demands.node);
    if complete {
        let note = match zeros(trial, &labels).as_slice() {
            [] => String::new(),
            fields => format!("; always 0, as what is not bound: {}", fields.join(", ")),
        };
        let found = format!("{} numbers at every step, all of them finite{note}", labels.len());
        report.add("outputs", Verdict::Pass, found);
    } else {
        report.skip(&["outputs"], "it does not answer every step");
    }
    if !demands.ranges.is_empty() {
        let found = out_of_range(trial, &labels, &demands.ranges);
        report.judge("ranges", found.is_none(), found.unwrap_or_else(|| "all within".into()));
    }
    let touched = trial.touched.first.as_ref();
    let touched = touched.map(|first| format!("{} {} is another at step {}", first.topic, first.field, first.step));
    report.judge("inputs", touched.is_none(), touched.unwrap_or_else(|| "all as they were played".into()));
    if complete {
        let finding = trial.describe_end(demands.patience);
        report.judge("end", trial.ended_by_itself && trial.ended_well(), finding);
    } else {
        report.skip(&["end"], "it does not answer every step");
    }
    match &trial.end {
        Some(end) => {
            let finding = if end.left == 0 { "none".into() } else { format!("{} of them, killed", end.left) };
            report.judge("left", end.left == 0, finding);
            let allowed = PRINTED + PRINTED_PER_STEP * trial.steps;
            let finding = format!("{} bytes in {} steps, {allowed} are allowed", end.printed, trial.steps);
            report.judge("output", end.printed <= allowed, finding);
        }
        None => report.skip(&["left", "output"], "it had to be killed"),
    }
}

/// Numbers out of all bounds may make a program report a fault; they may not hang or crash it.
fn absurd(report: &mut Report, trial: &Trial) {
    match &trial.stopped {
        None => report.add("absurd", Verdict::Pass, format!("it answers all {} steps", trial.steps)),
        Some(RunError::Fault { message, .. }) => {
            report.add("absurd", Verdict::Pass, format!("it reports a fault: \"{message}\""));
        }
        Some(_) => report.add("absurd", Verdict::Fail, trial.reason()),
    }
}

/// Puts a plan into `folder` whose digest does not fit it.
fn wrong_plan(setup: &Setup, folder: &Path) -> Result<(), Failure> {
    let duet = Duet::prepare(setup)?;
    let directory = duet.conductor.directory().path();
    let failed = || Failure::system(format!("read the plan in {}", directory.display()));
    let mut plan = Plan::read(directory).map_err(RunError::from)?;
    plan.steps += 1;
    let text = serde_json::to_vec(&plan).map_err(|error| failed()(error.into()))?;
    std::fs::write(folder.join("plan.json"), text).map_err(failed())?;
    std::fs::copy(directory.join(SCENARIO_FILE), folder.join(SCENARIO_FILE)).map_err(failed())?;
    Ok(warn_of_leftovers(duet.conductor.finish())?)
}

/// The same network, but for the names of what the node publishes.
fn other_signals(network: &Network, node: usize) -> Network {
    let mut network = network.clone();
    for channel in network.nodes[node].outputs.clone() {
        let layout = &mut network.channels[channel.0].layout;
        let renamed =
            layout.fields().iter().map(|field| Field { name: format!("other_{}", field.name), ..field.clone() });
        *layout = Layout::new(renamed.collect::<Vec<_>>());
    }
    network
}
