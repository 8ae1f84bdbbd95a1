//! The checks of a program, one after the other.

use std::path::Path;
use std::time::Duration;

use formation::wiring::{Assembly, SCENARIO_FILE};
use lockstep::{Field, Layout, Network, Plan};
use processes::{Activity, RunError, Settings};

use super::inspect::{Range, departure, labels, out_of_range, speed, unlike, zeros};
use super::report::{Report, Verdict};
use super::standalone::run_standalone;
use super::test_run::{TestRun, test_run};
use crate::failure::Failure;
use crate::run::engine::warn_of_leftovers;
use crate::run::leftovers::Scratch;
use crate::trial::replay::{ReplayRun, ReplaySetup};

/// Factor that takes recorded inputs out of all bounds: their squares are infinite, and differences of these are NaN.
const ABSURD: f64 = 1e200;
/// What a program may print, bytes ...
const PRINTED: u64 = 8192;
/// ... and per step.
const PRINTED_PER_STEP: u64 = 8;
/// The checks that need a faulty run, or none.
const OF_OTHER_RUNS: [&str; 3] = ["alone", "plan", "signals"];
/// The checks that need a complete run.
const OF_A_RUN: [&str; 8] = ["outputs", "inputs", "end", "left", "output", "repeat", "stop", "absurd"];

/// What to do about a program that ...
const STILL_STARTING: &str =
    "give it more time with --patience SECONDS; a run gives a program three deadlines to connect";
const HANGS_AT_START: &str =
    "it has joined the run and does not get ready: see what it does between opening the participant and its first step";
const REFUSED: &str =
    "bind the signals that the finding lists, or try it with the scenario that it is written for: --scenario NAME";
const DIES_AT_START: &str = "start it by hand: outside a run, a program that works says only how it is started";

/// A program, and how it is tested.
pub struct ConformanceTest<'a> {
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

/// Makes all checks of a program.
///
/// # Errors
/// [`Failure`] if it cannot be tried: the log cannot be read, a process of our own cannot be started.
pub fn conform(test: &ConformanceTest) -> Result<Report, Failure> {
    let folder = Scratch::create()?;
    let (words, patience, folder) = (test.words, test.patience, folder.path());
    let (assembly, node) = (test.assembly, test.node);
    let settings =
        Settings { deadline: patience, grace: patience, forward_output: false, replacements: 0, ..Settings::default() };
    let steps = assembly.scenario.context.timing.periods() + 1;
    let setup = ReplaySetup {
        assembly,
        network: &assembly.network,
        log: test.log,
        only: node,
        robot: None,
        factor: 1.0,
        settings,
        start_timeout: patience,
        traced: u32::try_from(steps).unwrap_or(u32::MAX),
        core: test.core,
    };
    let mut report = Report::default();

    let first = test_run(&setup, words, None, folder)?;
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
    whole_run(&mut report, test, &first, complete);
    if complete {
        let second = test_run(&setup, words, None, folder)?;
        let found = unlike(&first, &second, &labels(&assembly.network, node));
        let found = if second.steps < steps { Some(format!("the second time: {}", second.reason())) } else { found };
        let same = format!("twice {} numbers", first.outputs.len());
        report.judge("repeat", found.is_none(), found.unwrap_or(same));
        let stopped = test_run(&setup, words, Some(steps / 2), folder)?;
        report.judge("stop", stopped.ended_well(), stopped.describe_end(patience));
        absurd(&mut report, &test_run(&ReplaySetup { factor: ABSURD, ..setup }, words, None, folder)?);
        report.add("reference", Verdict::Note, departure(&first));
        report.add("speed", Verdict::Note, speed(&first.lengths, assembly.scenario.context.timing.dt));
    } else {
        report.skip(&["repeat", "stop", "absurd"], "it does not answer every step");
    }
    Ok(report)
}

/// The report on a program that does not reach its first step. Its behaviour in faulty runs means nothing then.
fn not_started(mut report: Report, first: TestRun, patience: Duration) -> Result<Report, Failure> {
    let (verdict, advice) = match &first.stopped {
        Some(RunError::NotReady { missing, .. }) if missing.iter().all(|late| late.activity == Activity::Starting) => {
            (Verdict::Untried, STILL_STARTING)
        }
        Some(RunError::NotReady { .. }) => (Verdict::Fail, HANGS_AT_START),
        Some(RunError::Refused { .. }) => (Verdict::Fail, REFUSED),
        Some(RunError::Died { .. }) | None => (Verdict::Fail, DIES_AT_START),
        // Not the fault of the program.
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

/// Checks what it does outside a run, with an invalid plan, and in a run with other signals.
fn refusals(report: &mut Report, setup: &ReplaySetup, words: &[String], folder: &Path) -> Result<(), Failure> {
    let patience = setup.start_timeout;
    let alone = run_standalone(words, None, folder, patience)?;
    report.judge("alone", alone.refused(), alone.describe());
    wrong_plan(setup, folder)?;
    let plan = run_standalone(words, Some(folder), folder, patience)?;
    report.judge("plan", plan.refused(), plan.describe());
    let network = other_signals(&setup.assembly.network, setup.only);
    let other = test_run(&ReplaySetup { network: &network, ..*setup }, words, Some(0), folder)?;
    match &other.stopped {
        Some(RunError::Refused { message, .. }) => {
            report.add("signals", Verdict::Pass, format!("it says: \"{message}\""))
        }
        Some(_) => report.judge("signals", other.end.as_ref().is_some_and(|end| end.code > Some(0)), other.reason()),
        None => report.add("signals", Verdict::Fail, "it takes part in a run in which its outputs have other names"),
    }
    Ok(())
}

/// The checks of one complete run.
fn whole_run(report: &mut Report, test: &ConformanceTest, run: &TestRun, complete: bool) {
    let labels = labels(&test.assembly.network, test.node);
    if complete {
        let note = match zeros(run, &labels).as_slice() {
            [] => String::new(),
            fields => format!("; always 0, as what is not bound: {}", fields.join(", ")),
        };
        let found = format!("{} numbers at every step, all of them finite{note}", labels.len());
        report.add("outputs", Verdict::Pass, found);
    } else {
        report.skip(&["outputs"], "it does not answer every step");
    }
    if !test.ranges.is_empty() {
        let found = out_of_range(run, &labels, &test.ranges);
        report.judge("ranges", found.is_none(), found.unwrap_or_else(|| "all within".into()));
    }
    let touched = run.touched.first.as_ref();
    let touched = touched.map(|first| format!("{} {} is another at step {}", first.topic, first.field, first.step));
    report.judge("inputs", touched.is_none(), touched.unwrap_or_else(|| "all as they were played".into()));
    if complete {
        let finding = run.describe_end(test.patience);
        report.judge("end", run.ended_by_itself && run.ended_well(), finding);
    } else {
        report.skip(&["end"], "it does not answer every step");
    }
    match &run.end {
        Some(end) => {
            let finding = if end.left == 0 { "none".into() } else { format!("{} of them, killed", end.left) };
            report.judge("left", end.left == 0, finding);
            let allowed = PRINTED + PRINTED_PER_STEP * run.steps;
            let finding = format!("{} bytes in {} steps, {allowed} are allowed", end.printed, run.steps);
            report.judge("output", end.printed <= allowed, finding);
        }
        None => report.skip(&["left", "output"], "it had to be killed"),
    }
}

/// Inputs out of all bounds may make a program report a fault, but not hang or crash.
fn absurd(report: &mut Report, run: &TestRun) {
    match &run.stopped {
        None => report.add("absurd", Verdict::Pass, format!("it answers all {} steps", run.steps)),
        Some(RunError::Fault { message, .. }) => {
            report.add("absurd", Verdict::Pass, format!("it reports a fault: \"{message}\""));
        }
        Some(_) => report.add("absurd", Verdict::Fail, run.reason()),
    }
}

/// Puts a plan with a wrong digest into `folder`.
fn wrong_plan(setup: &ReplaySetup, folder: &Path) -> Result<(), Failure> {
    let replay = ReplayRun::prepare(setup)?;
    let directory = replay.conductor.directory().path();
    let failed = || Failure::system(format!("read the plan in {}", directory.display()));
    let mut plan = Plan::read(directory).map_err(RunError::from)?;
    plan.steps += 1;
    let text = serde_json::to_vec(&plan).map_err(|error| failed()(error.into()))?;
    std::fs::write(folder.join("plan.json"), text).map_err(failed())?;
    std::fs::copy(directory.join(SCENARIO_FILE), folder.join(SCENARIO_FILE)).map_err(failed())?;
    Ok(warn_of_leftovers(replay.conductor.finish())?)
}

/// The same network with other names for the outputs of the node.
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
