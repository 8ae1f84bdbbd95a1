//! One run, from the first step to the closed log.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use formation::wiring::Assembly;
use lockstep::{ChannelId, Header, RunError, Status, Store};

use crate::engine::{Engine, Placement, Stop};
use crate::failure::Failure;
use crate::log::{DEFAULT_FLUSH_EVERY, Recorder, RunInfo, Summary};
use crate::progress::Progress;
use crate::swap::Swap;

/// How a run is carried out. None of it changes a bit of the log.
#[derive(Clone, Debug)]
pub struct Options {
    /// How the participants are spread over processes.
    pub placement: Placement,
    /// Where the log goes; `None`: nothing is recorded.
    pub log: Option<PathBuf>,
    /// The core for all processes; `None`: the operating system places them.
    pub core: Option<usize>,
    /// Participants that are programs of the user.
    pub swaps: Vec<Swap>,
    /// Whether progress is shown.
    pub progress: bool,
}

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Number of periods that were simulated.
    pub steps: u64,
    /// Simulated time, s.
    pub simulated: f64,
    /// Time that it took, start and end of the processes not counted, s.
    pub wall: f64,
    /// Number of processes, the orchestrator included.
    pub processes: usize,
    /// The log, if there is one.
    pub log: Option<Summary>,
    /// Why it ended before its time; the log reaches up to there.
    pub stopped: Option<RunError>,
}

impl Outcome {
    /// Steps per second of wall-clock time.
    pub fn steps_per_second(&self) -> f64 {
        self.steps as f64 / self.wall.max(1e-9)
    }
}

/// Runs the scenario.
///
/// # Errors
/// [`Failure`] if it cannot start, or if the log cannot be written. A run that starts but does not come to its end is an
/// [`Outcome`] with [`Outcome::stopped`].
pub fn run(assembly: &Assembly, options: &Options, on_start: impl FnOnce(Stop)) -> Result<Outcome, Failure> {
    // Created first: its thread must not inherit the pinning of this one.
    let mut recorder = match &options.log {
        Some(path) => Some(create_log(path, assembly)?),
        None => None,
    };
    let mut engine = match options.placement {
        Placement::Single => Engine::local(assembly)?,
        placement => Engine::processes(assembly, placement, options.core, &options.swaps)?,
    };
    let stop = engine.stop();
    on_start(stop.clone());
    let timing = assembly.scenario.context.timing;
    let mut progress = Progress::new(options.progress, timing.periods(), timing.dt);
    let start = Instant::now();
    let mut done = 0;
    let mut stopped = None;
    let mut log_error = None;
    for step in 0..=timing.periods() {
        let result = if stop.is_requested() { Err(RunError::Interrupted { step }) } else { engine.step() };
        if let Err(error) = result {
            stopped = Some(error);
            break;
        }
        if let Some(recorder) = &mut recorder
            && let Err(error) =
                recorder.record(step, engine.store(), |channel| header(assembly, engine.store(), channel, step))
        {
            log_error = Some(error);
            break;
        }
        done = step;
        progress.at(step);
    }
    let wall = start.elapsed().as_secs_f64();
    progress.finish();
    let processes = engine.process_count();
    engine.finish()?;
    if let Some(error) = log_error {
        return Err(error.into());
    }
    let log = recorder.map(Recorder::finish).transpose()?;
    Ok(Outcome { steps: done, simulated: done as f64 * timing.dt, wall, processes, log, stopped })
}

fn create_log(path: &Path, assembly: &Assembly) -> Result<Recorder, Failure> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(Failure::system(format!("create the folder {}", folder.display())))?;
    }
    let scenario = &assembly.scenario;
    let text = scenario.to_toml();
    let metadata = BTreeMap::from([
        ("scenario".to_string(), scenario.name.clone()),
        ("variant".to_string(), scenario.variant.clone()),
        ("overrides".to_string(), scenario.overrides.join("\n")),
        ("phalanx".to_string(), env!("CARGO_PKG_VERSION").to_string()),
        ("format".to_string(), "1".to_string()),
    ]);
    let info = RunInfo {
        network: &assembly.network,
        period_ns: scenario.context.timing.period_ns(),
        scenario: &text,
        metadata: &metadata,
        flush_every: DEFAULT_FLUSH_EVERY,
    };
    Ok(Recorder::create(path, &info)?)
}

/// The header of a sample; for a channel whose writer has not run yet, that of the zeros that its readers see.
fn header(assembly: &Assembly, store: &Store, channel: ChannelId, step: u64) -> Header {
    let period_ns = assembly.scenario.context.timing.period_ns();
    let agent = assembly.network.channels[channel.0].agent;
    store.header(channel, step).copied().unwrap_or_else(|| Header::new(step, period_ns, agent, Status::Held))
}
