//! One run of a program against recorded inputs.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use lockstep::ChannelId;
use processes::RunError;

use super::supervise::End;
use crate::failure::Failure;
use crate::recorded::RecordedSamples;
use crate::run::control::RunControl;
use crate::run::engine::warn_of_leftovers;
use crate::trial::replay::{Departures, ReplayRun, ReplaySetup};

/// Longest reason that is passed on, in characters.
const LONGEST_REASON: usize = 400;

/// Its result.
pub(super) struct TestRun {
    /// How long it took to connect; `None` if it did not.
    pub(super) connected: Option<Duration>,
    /// Steps that were answered.
    pub(super) steps: u64,
    /// Why it stopped early.
    pub(super) stopped: Option<RunError>,
    /// What it published: the numbers of all its channels, step by step.
    pub(super) outputs: Vec<f64>,
    /// What was recorded in its place.
    pub(super) recorded: Vec<f64>,
    /// Where samples of others are not what was played.
    pub(super) touched: Departures,
    /// How its outputs depart from the recording.
    pub(super) departures: Departures,
    /// Durations of its steps, in no particular order.
    pub(super) lengths: Vec<Duration>,
    /// Whether it ended after the last step by itself, before it was asked to.
    pub(super) ended_by_itself: bool,
    /// How it ended; `None` if it had to be killed.
    pub(super) end: Option<End>,
}

/// Starts the program and has it do all steps, or `stop_after` of them.
pub(super) fn test_run(
    setup: &ReplaySetup,
    words: &[String],
    stop_after: Option<u64>,
    folder: &Path,
) -> Result<TestRun, Failure> {
    let (scenario, network) = (&setup.assembly.scenario, setup.network);
    let (periods, dt) = (scenario.context.timing.periods(), scenario.context.timing.dt);
    let status: PathBuf = folder.join("status.json");
    let _ = std::fs::remove_file(&status);
    let mut run = TestRun {
        connected: None,
        steps: 0,
        stopped: None,
        outputs: Vec::new(),
        recorded: Vec::new(),
        touched: Departures::new(network, 0.0, dt),
        departures: Departures::new(network, 0.0, dt),
        lengths: Vec::new(),
        ended_by_itself: false,
        end: None,
    };
    let mut command = Command::new(std::env::current_exe().map_err(Failure::system("find this program"))?);
    command.arg("supervise").arg(&status).arg("--").args(words);
    let start = Instant::now();
    let replay = match ReplayRun::start(setup, |_| Ok(command), &RunControl::new()) {
        Ok(replay) => replay,
        Err(Failure::Run(error)) => {
            run.stopped = Some(error);
            run.end = End::read(&status);
            return Ok(run);
        }
        Err(other) => return Err(other),
    };
    run.connected = Some(start.elapsed());
    let all: Vec<usize> = (0..network.nodes.len()).collect();
    // With signals of other names there is nothing to compare with; such a program should not have come this far.
    let mut samples = RecordedSamples::open(setup.log, scenario, &setup.assembly.network, &all)?;
    let mut conductor = replay.conductor;
    for step in 0..=periods {
        if stop_after.is_some_and(|last| step == last) || !samples.advance_to(step)? {
            break;
        }
        if let Err(error) = conductor.step() {
            run.stopped = Some(error);
            break;
        }
        run.steps = step + 1;
        for (node, place) in network.nodes.iter().enumerate() {
            for &channel in &place.outputs {
                let (recorded, now) = (samples.words(channel), conductor.store().read(channel, step));
                run.look(setup, node, channel, step, recorded, now);
            }
        }
    }
    if run.steps == periods + 1 {
        let limit = Instant::now() + setup.start_timeout;
        while End::read(&status).is_none() && Instant::now() < limit {
            thread::sleep(Duration::from_millis(5));
        }
        run.ended_by_itself = End::read(&status).is_some();
    }
    let spans = conductor.statistics().spans();
    run.lengths = spans.iter().filter(|span| span.worker == replay.worker).map(|span| span.length).collect();
    warn_of_leftovers(conductor.finish())?;
    run.end = End::read(&status);
    Ok(run)
}

impl TestRun {
    fn look(&mut self, setup: &ReplaySetup, node: usize, channel: ChannelId, step: u64, recorded: &[f64], now: &[f64]) {
        if node == setup.only {
            self.departures.compare(setup.network, channel, step, recorded, now);
            self.outputs.extend_from_slice(now);
            self.recorded.extend_from_slice(recorded);
        } else if setup.factor == 1.0 {
            self.touched.compare(setup.network, channel, step, recorded, now);
        }
    }

    /// Whether it ended by itself at all, with exit code 0.
    pub(super) fn ended_well(&self) -> bool {
        self.end.as_ref().is_some_and(|end| end.code == Some(0))
    }

    /// How it ended, in words.
    pub(super) fn describe_end(&self, grace: Duration) -> String {
        match &self.end {
            Some(end) => end.describe(),
            None => format!("it did not end; killed after {:.1} s", grace.as_secs_f64()),
        }
    }

    /// Why it stopped early, in words.
    pub(super) fn reason(&self) -> String {
        let crashed = self.end.as_ref().filter(|end| end.not_started.is_some() || end.signal.is_some());
        match (&self.stopped, crashed) {
            (Some(error), Some(end)) => format!("{} ({})", end.describe(), one_line(error)),
            (Some(error), None) => one_line(error),
            (None, _) => String::new(),
        }
    }
}

/// An error with the last words of the program, in one line.
fn one_line(error: &RunError) -> String {
    let text = error.to_string();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(LONGEST_REASON) {
        Some((end, _)) => format!("{} ...", &line[..end]),
        None => line,
    }
}
