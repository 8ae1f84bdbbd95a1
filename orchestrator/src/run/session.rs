//! One run, from the first step to the closed log.

use std::path::PathBuf;
use std::time::Instant;

use formation::scenario::FailurePolicy;
use formation::wiring::Assembly;
use lockstep::{RunError, Snapshot, Tap, Wake};

use crate::failure::Failure;
use crate::judge::assertions::{self, Findings, Guard, Watch};
use crate::log::{Recorder, Summary};
use crate::run::control::{About, Keys, Pace, Pacing, Server, Stop};
use crate::run::engine::{Engine, Staging, cores};
use crate::run::pinning::{Home, Pin};
use crate::run::placement::Placement;
use crate::run::profile::{TRACED_RUNS, write_trace};
use crate::run::progress::Progress;
use crate::run::recording::{create_log, record};
use crate::run::recovery::Recovery;
use crate::run::robots::{Journal, with_hands};
use crate::run::scene::Scene;
use crate::run::stress::Stress;
use crate::run::swap::{RobotSwap, Swap};
use crate::run::urgency::Urgency;

/// Why a participant of a run that goes on keeps its program.
const NOT_RECORDED: &str = "the run is not recorded, and a new program needs the steps so far: nothing was changed";

/// How a run is carried out. None of it changes a bit of the log.
#[derive(Clone, Debug)]
pub struct Options {
    /// How the participants are spread over processes.
    pub placement: Placement,
    /// Where the log goes; `None`: nothing is recorded.
    pub log: Option<PathBuf>,
    /// Whether the log shows the scene to viewers, besides the signals.
    pub scene: bool,
    /// Which cores the processes use.
    pub pin: Pin,
    /// Participants that are programs of the user.
    pub swaps: Vec<Swap>,
    /// Whether progress is shown, and keys of the terminal are listened to.
    pub progress: bool,
    /// Simulated seconds per second; `None`: as fast as possible.
    pub pace: Option<f64>,
    /// Where a trace of the last steps goes; `None`: nothing is traced.
    pub trace: Option<PathBuf>,
    /// What is done when a participant fails.
    pub on_failure: FailurePolicy,
    /// What is done to make the run stumble.
    pub stress: Option<Stress>,
    /// What its processes wake each other with.
    pub wake: Wake,
    /// Whether every sample is published, too, for whoever looks on.
    pub tap: bool,
    /// How urgent its processes are.
    pub urgency: Urgency,
    /// Folder of a file per process with what it printed.
    pub log_dir: Option<PathBuf>,
}

impl Options {
    /// As fast as possible, without a word, recorded into `log` with its scene if there is one.
    pub fn new(placement: Placement, log: Option<PathBuf>) -> Self {
        let (pin, swaps) = (Pin::Auto, Vec::new());
        let (on_failure, urgency) = (FailurePolicy::default(), Urgency::default());
        let (scene, progress, tap) = (true, false, false);
        let (pace, trace, stress, log_dir) = (None, None, None, None);
        let wake = Wake::default();
        Self {
            placement,
            log,
            scene,
            pin,
            swaps,
            progress,
            pace,
            trace,
            on_failure,
            stress,
            wake,
            tap,
            urgency,
            log_dir,
        }
    }

    /// Whether somebody takes part for whom time passes by itself.
    fn has_robots(&self) -> bool {
        self.swaps.iter().any(|swap| swap.robot().is_some_and(RobotSwap::is_free))
    }

    fn staging(&self) -> Staging {
        Staging {
            placement: self.placement,
            swaps: self.swaps.clone(),
            on_failure: self.on_failure.clone(),
            stress: self.stress,
            wake: self.wake,
            urgency: self.urgency,
            log_dir: self.log_dir.clone(),
            traced: if self.trace.is_some() { TRACED_RUNS } else { 0 },
        }
    }
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
    /// Whether that was an emergency stop.
    pub emergency: bool,
    /// What became of the assertions of the scenario.
    pub findings: Findings,
    /// An assertion ended it before its time; the log reaches up to there.
    pub halted: bool,
    /// Where its time went.
    pub usage: Snapshot,
    /// How well it kept the times that it was to keep.
    pub pacing: Option<Pacing>,
    /// How the cores were chosen, if they were.
    pub cores: Option<String>,
    /// Participants that others took the place of, in words.
    pub replaced: Vec<String>,
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
    let cores = cores()?;
    let home = if options.placement == Placement::Single { Home::default() } else { options.pin.take()? };
    let network = with_hands(&assembly.network, &options.swaps);
    // Before the run starts: the thread that compresses must not share the core of the participants.
    let mut recorder = match &options.log {
        Some(path) => Some(create_log(path, assembly, &network)?),
        None => None,
    };
    let mut recovery = options.log.clone().map(|path| Recovery::new(options.on_failure.clone(), path));
    // After it, so that the compression is not urgent.
    options.urgency.claim();
    let mut scene = match &mut recorder {
        Some(recorder) if options.scene => Scene::new(assembly, recorder)?,
        _ => None,
    };
    let timing = assembly.scenario.context.timing;
    let mut journal = match &mut recorder {
        Some(recorder) if options.has_robots() => Some(Journal::new(&network, timing.period_ns(), recorder)?),
        _ => None,
    };
    let watch = Watch::new(assertions::read(assembly)?, timing.dt);
    let mut guard = Guard::new(watch, timing.period_ns(), recorder.as_mut())?;
    let stop = Stop::new();
    on_start(stop.clone());
    let mut engine = Engine::start(assembly, &options.staging(), home, &stop)?;
    let server = serve(assembly, &engine, &stop);
    let keys = if options.progress { Keys::listen(&stop) } else { None };
    let mut pace = options.pace.map(|factor| Pace::new(timing.dt, factor));
    if pace.is_none() {
        engine.balance(&cores);
    } else {
        engine.run_step_by_step();
    }
    let tap = match options.tap {
        true => Some(open_tap(assembly, &engine)?),
        false => None,
    };
    if recorder.is_none() && tap.is_none() && guard.is_idle() {
        engine.fetch_nothing();
    }
    let mut progress = Progress::new(options.progress, timing.periods(), timing.dt);
    let start = Instant::now();
    let mut done = 0;
    let mut stopped = None;
    let mut halted = false;
    let mut failure = None;
    for step in 0..=timing.periods() {
        if let (true, Some(recorder)) = (stop.wants_attention(), &mut recorder)
            && let Err(error) = recorder.show()
        {
            failure = Some(error.into());
            break;
        }
        let mut waited = stop.await_turn(step);
        while let Some(request) = stop.next_swap() {
            let result = match (&mut recovery, &recorder) {
                (Some(recovery), Some(recorder)) => recovery.swap(&mut engine, recorder, request.swap.clone()),
                _ => Ok(Err(NOT_RECORDED.into())),
            };
            waited = true;
            match result {
                Ok(from) => request.answer(from),
                Err(error) => {
                    request.answer(Err(error.to_string()));
                    stopped = Some(error);
                }
            }
            stop.await_turn(step);
        }
        if stopped.is_some() {
            break;
        }
        if let Some(pace) = &mut pace {
            if waited || step == 0 {
                pace.restart(step);
            }
            pace.wait(step, &stop);
        }
        let mut result = if stop.is_requested() { Err(RunError::Interrupted { step }) } else { engine.step() };
        while let (Err(error), Some(recovery), Some(recorder)) = (&mut result, &mut recovery, &recorder) {
            let error = std::mem::replace(error, RunError::Over { steps: step });
            result = match recovery.mend(&mut engine, recorder, error) {
                Ok(()) => engine.step(),
                Err(error) => {
                    stopped = Some(error);
                    break;
                }
            };
        }
        if stopped.is_some() {
            break;
        }
        if let Err(error) = result {
            stopped = Some(error);
            break;
        }
        if let Some(recorder) = &mut recorder
            && let Err(error) = record(&network, timing.period_ns(), step, engine.store(), recorder, scene.as_mut())
        {
            failure = Some(error.into());
            break;
        }
        if let (Some(journal), Some(recovery), Some(recorder)) = (&mut journal, &mut recovery, &mut recorder) {
            let start = pace.as_ref().map(Pace::last).unwrap_or_default();
            if let Err(error) = journal.note(step, start, engine.store(), recorder, recovery) {
                failure = Some(error.into());
                break;
            }
        }
        if let (Some(recovery), Some(recorder)) = (&mut recovery, &mut recorder)
            && let Err(error) = recovery.note(&assembly.network, engine.store(), step, timing.period_ns(), recorder)
        {
            failure = Some(error.into());
            break;
        }
        if let Some(tap) = &tap {
            tap.publish(engine.store(), step);
        }
        done = step;
        progress.at(step);
        match guard.check(step, engine.store(), recorder.as_mut(), |text| progress.say(text)) {
            Ok(true) => {}
            Ok(false) => {
                halted = true;
                break;
            }
            Err(error) => {
                failure = Some(error.into());
                break;
            }
        }
    }
    let wall = start.elapsed().as_secs_f64();
    tracing::info!(steps = done, wall, "the steps are done");
    progress.finish();
    drop((server, keys, tap));
    let (processes, usage) = (engine.process_count(), engine.gauge().read());
    if let (Some(path), Engine::Processes { conductor, .. }) = (&options.trace, &engine) {
        let written = write_trace(path, &conductor.gauge(), conductor.plan());
        written.map_err(Failure::system(format!("write the trace {}", path.display())))?;
    }
    let chosen = engine.balanced();
    tracing::info!(chosen, "cores");
    engine.finish()?;
    if let Some(failure) = failure {
        return Err(failure);
    }
    if let (Some(recorder), Some(scene)) = (&mut recorder, &mut scene) {
        scene.close(stopped.as_ref(), recorder)?;
    }
    let findings = guard.conclude(recorder.as_mut())?;
    let log = recorder.map(Recorder::finish).transpose()?;
    let simulated = done as f64 * timing.dt;
    let pacing = pace.map(Pace::finish);
    let replaced = recovery.map(Recovery::into_told).unwrap_or_default();
    Ok(Outcome {
        steps: done,
        simulated,
        wall,
        processes,
        log,
        stopped,
        emergency: stop.is_emergency(),
        findings,
        halted,
        usage,
        pacing,
        cores: chosen,
        replaced,
    })
}

/// Listens for `phalanx ctl` and `phalanx top`; a run that nobody can control is better than none.
fn serve(assembly: &Assembly, engine: &Engine, stop: &Stop) -> Option<Server> {
    let directory = engine.directory()?;
    let timing = assembly.scenario.context.timing;
    let about = About {
        run: directory.name().into(),
        scenario: assembly.scenario.name.clone(),
        variant: assembly.scenario.variant.clone(),
        dt: timing.dt,
        periods: timing.periods(),
        processes: engine.process_count(),
        participants: assembly.network.nodes.iter().map(|node| node.name.clone()).collect(),
    };
    Server::start(directory.path(), about, stop.clone(), engine.gauge()).ok()
}

/// Publishes what is recorded, for readers from outside.
fn open_tap(assembly: &Assembly, engine: &Engine) -> Result<Tap, Failure> {
    let nowhere = || Failure::Usage("--tap needs a run directory in /dev/shm, and there is none".into());
    let directory = engine.directory().ok_or_else(nowhere)?;
    Ok(Tap::start(directory, &assembly.network, engine.core()).map_err(RunError::from)?)
}
