//! Runs one participant of a recorded run again.

use std::path::Path;
use std::process::Command;

use formation::scenario::Overrun;
use processes::RunError;

use super::Departures;
use super::replay_run::{ReplayRun, ReplaySetup};
use crate::failure::Failure;
use crate::recorded::RecordedSamples;
use crate::run::control::{Pace, RunControl, TooLate};
use crate::run::engine::warn_of_leftovers;
use crate::run::players::Player;
use crate::run::recording::{create_log, header};
use crate::run::swap::{RobotSwap, Swap};
use recording::{LogPlace, Recorder, Summary};

/// The result of such a run.
#[derive(Debug)]
pub struct Outcome {
    /// How the participant departs from the recording.
    pub departures: Departures,
    /// The log of the new run, if there is one.
    pub log: Option<Summary>,
    /// Why it ended before the recording did.
    pub stopped: Option<RunError>,
}

/// Runs the participant of `setup`, started by what `command` gives for a run in a directory, against the recording of the
/// others, and compares what it publishes. With a robot for which time passes by itself, steps keep pace with the clock.
///
/// The new run is recorded into `out`, if given, with the programs that took part. Numbers within `tolerance` (see [`Departures::new`]) count as equal.
///
/// # Errors
/// [`Failure`] if the processes cannot be started, or a log cannot be read or written.
pub fn rerun(
    setup: &ReplaySetup,
    command: impl FnOnce(&Path) -> Result<Command, Failure>,
    tolerance: f64,
    out: Option<(&Path, &[Player])>,
    stop: &RunControl,
) -> Result<Outcome, Failure> {
    let assembly = setup.assembly;
    let (network, timing) = (setup.network, assembly.scenario.context.timing);
    let mut samples = RecordedSamples::open(setup.log, &assembly.scenario, network, &[setup.only])?;
    let mut recorder =
        out.map(|(path, players)| create_log(&LogPlace::claim(path)?, assembly, network, players)).transpose()?;
    if !samples.advance_to(0)? {
        return Err(samples.over(0).into());
    }
    let ReplayRun { mut conductor, .. } = ReplayRun::start(setup, command, stop)?;
    let is_free = setup.robot.and_then(Swap::robot).is_some_and(RobotSwap::is_free);
    let overrun = assembly.scenario.overrun.unwrap_or(Overrun::Skip);
    let mut pace = is_free.then(|| Pace::new(timing.dt, 1.0, overrun));
    if is_free {
        conductor.set_ahead(0);
    }
    let mut departures = Departures::new(network, tolerance, timing.dt);
    let (mut stopped, mut too_late) = (None, None);
    for step in 0..=timing.periods() {
        if !samples.advance_to(step)? {
            break;
        }
        if let Some(pace) = &mut pace {
            if step == 0 {
                pace.restart(step);
            }
            if let Err(TooLate { late, period }) = pace.wait(step, stop) {
                too_late = Some(Failure::TooLate { step, late, period });
                break;
            }
        }
        let next = if stop.is_requested() { Err(RunError::Interrupted { step }) } else { conductor.step() };
        if let Err(error) = next {
            stopped = Some(error);
            break;
        }
        let store = conductor.store();
        for &channel in &network.nodes[setup.only].outputs {
            departures.compare(network, channel, step, samples.words(channel), store.read(channel, step));
        }
        if let Some(recorder) = &mut recorder {
            recorder.record(step, store, |channel| header(network, timing.period(), store, channel, step))?;
        }
    }
    warn_of_leftovers(conductor.finish())?;
    let log = recorder.map(Recorder::finish).transpose()?.flatten();
    too_late.map_or(Ok(()), Err)?;
    Ok(Outcome { departures, log, stopped })
}
