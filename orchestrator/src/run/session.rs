//! One run, from the first step to the closed log.

use std::time::Instant;

use formation::wiring::Assembly;
use lockstep::{Network, Period};
use processes::{RunDirectory, RunError, Tap};

use super::control::{About, Keys, Pace, RunControl, Server, TooLate};
use super::engine::{Engine, cores};
use super::monitor::AssertionMonitor;
use super::observer::{Flow, StepView};
use super::observers::Observers;
use super::options::Options;
use super::outcome::{Ending, Outcome};
use super::pinning::Affinity;
use super::players::Player;
use super::profile::write_trace;
use super::progress::Progress;
use super::recording::create_log;
use super::recovery::Recovery;
use super::robots::{RobotLog, with_hands};
use super::scene::Scene;
use super::swap::check_played;
use crate::failure::Failure;
use crate::judge::assertions::{self, Watch};
use recording::{LogPlace, Recorder};

/// Why a participant of a run that continues keeps its program.
const NOT_RECORDED: &str = "the run is not recorded, and a new program needs the steps so far: nothing was changed";

/// Runs the scenario.
///
/// # Errors
/// [`Failure`] if it cannot start, or if the log cannot be written. A run that starts but does not come to its end is an
/// [`Outcome`] whose [`Outcome::ending`] says why.
pub fn run(assembly: &Assembly, options: &Options, on_start: impl FnOnce(RunControl)) -> Result<Outcome, Failure> {
    let mut session = Session::start(assembly, options, on_start)?;
    let start = Instant::now();
    let result = (0..=session.periods).try_for_each(|step| session.advance(step));
    let ending = result.err().unwrap_or(Ending::Complete);
    let wall = start.elapsed().as_secs_f64();
    tracing::info!(steps = session.done, wall, ?ending, "the steps are done");
    session.finish(ending, wall)
}

/// A run in progress.
struct Session<'a> {
    options: &'a Options,
    /// The network of the scenario, and behind it the bridges to robots.
    network: Network,
    periods: u64,
    period: Period,
    dt: f64,
    stop: RunControl,
    engine: Engine,
    pace: Option<Pace>,
    log: Option<Recorder>,
    observers: Observers,
    progress: Progress,
    /// What takes requests from outside.
    doors: (Option<Server>, Option<Keys>),
    /// The last step that is done.
    done: u64,
}

impl<'a> Session<'a> {
    fn start(assembly: &Assembly, options: &'a Options, on_start: impl FnOnce(RunControl)) -> Result<Self, Failure> {
        if !options.stand_ins {
            check_played(assembly, &options.swaps)?;
        }
        let cores = cores()?;
        let affinity = if options.in_one_process() { Affinity::default() } else { options.pin.take()? };
        let network = with_hands(&assembly.network, &options.swaps);
        // Before the run starts: the thread that compresses must not share the core of the participants.
        let place = match (&options.place, &options.log) {
            (Some(place), _) => Some(place.clone()),
            (None, Some(path)) => Some(LogPlace::claim(path)?),
            (None, None) => None,
        };
        let open = |place| create_log(place, assembly, &network, &Player::all(&options.swaps));
        let mut log = place.as_ref().map(open).transpose()?;
        // After it, so that the compression is not urgent.
        options.priority.claim();
        let mut observers = observers(assembly, options, &network, &mut log)?;
        let timing = assembly.scenario.context.timing;
        let stop = RunControl::new();
        on_start(stop.clone());
        let mut server = None;
        let reached = |directory: &RunDirectory, processes| {
            server = serve(assembly, options, directory, processes, &stop);
        };
        let mut engine = Engine::start(assembly, options, affinity, &stop, reached).map_err(|end| ended(end, &stop))?;
        connect(&mut engine, &mut observers, &log).map_err(|error| ended(error.into(), &stop))?;
        engine.settle()?;
        if let Some(server) = &server {
            server.attach(engine.statistics());
        }
        stop.note_start();
        let keys = if options.progress { Keys::listen(&stop) } else { None };
        let pace = options.pace.map(|factor| Pace::new(timing.dt, factor, options.overrun()));
        if pace.is_none() {
            engine.balance(&cores);
        } else {
            engine.run_step_by_step();
        }
        observers.tap = options.tap.then(|| open_tap(assembly, &engine)).transpose()?;
        if log.is_none() && observers.tap.is_none() && observers.monitor.is_idle() {
            engine.fetch_nothing();
        }
        Ok(Self {
            options,
            network,
            periods: timing.periods(),
            period: timing.period(),
            dt: timing.dt,
            stop,
            engine,
            pace,
            log,
            observers,
            progress: Progress::new(options.progress, timing.periods(), timing.dt),
            doors: (server, keys),
            done: 0,
        })
    }

    /// Runs one step when its time has come, and shows it to all observers.
    fn advance(&mut self, step: u64) -> Result<(), Ending> {
        self.await_turn(step)?;
        self.step_or_mend(step)?;
        self.observe(step)
    }

    /// Waits while the run is paused, carries out swaps, and waits for the time of the step.
    fn await_turn(&mut self, step: u64) -> Result<(), Ending> {
        if let (true, Some(log)) = (self.stop.wants_attention(), &mut self.log) {
            log.show()?;
        }
        let mut waited = self.stop.await_turn(step);
        while let Some(request) = self.stop.next_swap() {
            let result = match (&mut self.observers.recovery, &self.log) {
                (Some(recovery), Some(log)) => recovery.swap(&mut self.engine, log, request.swap.clone()),
                _ => Ok(Err(NOT_RECORDED.into())),
            };
            waited = true;
            match result {
                Ok(from) => request.answer(from),
                Err(error) => {
                    request.answer(Err(error.to_string()));
                    return Err(self.ended_by(error));
                }
            }
            self.stop.await_turn(step);
        }
        if let Some(pace) = &mut self.pace {
            if waited || step == 0 {
                pace.restart(step);
            }
            pace.wait(step, &self.stop).map_err(|TooLate { late, period }| Ending::TooLate { step, late, period })?;
            if pace.last().skipped > 0 {
                tracing::warn!(step, periods = pace.last().skipped, "periods skipped: the step before took too long");
            }
        }
        Ok(())
    }

    /// Runs one step; participants that fail are replaced as their policies say.
    fn step_or_mend(&mut self, step: u64) -> Result<(), Ending> {
        let mut result =
            if self.stop.is_requested() { Err(RunError::Interrupted { step }) } else { self.engine.step() };
        loop {
            let error = match result {
                Ok(_) => return Ok(()),
                Err(error) => error,
            };
            let (Some(recovery), Some(log)) = (&mut self.observers.recovery, &self.log) else {
                return Err(self.ended_by(error));
            };
            if let Err(error) = recovery.mend(&mut self.engine, log, error) {
                return Err(self.ended_by(error));
            }
            result = self.engine.step();
        }
    }

    fn observe(&mut self, step: u64) -> Result<(), Ending> {
        let mut view = StepView {
            step,
            period: self.period,
            network: &self.network,
            store: self.engine.store(),
            start: self.pace.as_ref().map(Pace::last).unwrap_or_default(),
            say: &|text| self.progress.say(text),
            remarks: Vec::new(),
        };
        let flow = self.observers.step(&mut view, &mut self.log)?;
        self.done = step;
        self.progress.at(step);
        match flow {
            Flow::Continue => Ok(()),
            Flow::Halt => Err(Ending::Halted),
        }
    }

    fn ended_by(&self, error: RunError) -> Ending {
        match error {
            RunError::Interrupted { step } if self.stop.is_emergency() => Ending::Emergency { step },
            error => error.into(),
        }
    }

    /// Stops the processes, robots with them, and closes the log, before anything else that can fail.
    fn finish(mut self, ending: Ending, wall: f64) -> Result<Outcome, Failure> {
        self.progress.finish();
        drop(self.observers.tap.take());
        let processes = self.engine.process_count();
        let chosen = self.engine.core_findings();
        tracing::info!(chosen, "cores");
        let ended = self.engine.finish();
        let usage = ended.statistics.read();
        // Up to here the run answers that it is ending.
        drop(self.doors);
        if let Ending::LogFailed(error) = ending {
            return Err(error.into());
        }
        self.observers.end(&ending, &mut self.log)?;
        let log = self.log.map(Recorder::finish).transpose()?.flatten();
        self.stop.note_end();
        let mut leftover: Vec<Failure> = ended.result.err().map(Failure::from).into_iter().collect();
        if let (Some(path), Some(plan)) = (&self.options.trace, &ended.plan) {
            let written = write_trace(path, &ended.statistics, plan);
            leftover.extend(written.map_err(Failure::system(format!("write the trace {}", path.display()))).err());
        }
        Ok(Outcome {
            steps: self.done,
            simulated: self.done as f64 * self.dt,
            wall,
            processes,
            log,
            ending,
            findings: self.observers.monitor.findings(),
            usage,
            pacing: self.pace.map(Pace::finish),
            cores: chosen,
            replaced: self.observers.recovery.map(Recovery::into_told).unwrap_or_default(),
            leftover,
        })
    }
}

/// The observers of a run that is recorded into `log`; the tap needs the engine and comes later.
fn observers(
    assembly: &Assembly,
    options: &Options,
    network: &Network,
    log: &mut Option<Recorder>,
) -> Result<Observers, Failure> {
    let scene = match log {
        Some(log) if options.scene => Scene::new(assembly, log)?,
        _ => None,
    };
    let journal = match log {
        Some(log) if options.has_robots() => Some(RobotLog::new(network, log)?),
        _ => None,
    };
    let recovery = options.log.clone().map(|path| Recovery::new(options.on_failure.clone(), path));
    let watch = Watch::new(assertions::read(assembly)?, assembly.scenario.context.timing.dt);
    let monitor = AssertionMonitor::new(watch, log.as_mut())?;
    Ok(Observers { scene, journal, recovery, tap: None, monitor })
}

/// Waits until all processes are connected; those that fail before that are replaced as their policies say.
fn connect(engine: &mut Engine, observers: &mut Observers, log: &Option<Recorder>) -> Result<(), RunError> {
    while let Err(error) = engine.connect() {
        match (&mut observers.recovery, log) {
            (Some(recovery), Some(log)) => recovery.mend(engine, log, error)?,
            _ => return Err(error),
        }
    }
    Ok(())
}

/// Why a run ended before its first step.
fn ended(failure: Failure, stop: &RunControl) -> Failure {
    match failure {
        Failure::Interrupted if stop.is_emergency() => Failure::Emergency { step: 0 },
        failure => failure,
    }
}

/// Answers `phalanx ctl` and `phalanx top`, from the start on; a run that cannot be controlled is better than none.
fn serve(
    assembly: &Assembly,
    options: &Options,
    directory: &RunDirectory,
    processes: usize,
    stop: &RunControl,
) -> Option<Server> {
    let timing = assembly.scenario.context.timing;
    let about = About {
        run: directory.name().into(),
        scenario: assembly.scenario.name.clone(),
        variant: assembly.scenario.variant.clone(),
        dt: timing.dt,
        periods: timing.periods(),
        processes,
        log: options.log.as_ref().and_then(|log| std::path::absolute(log).ok()),
        participants: assembly.network.nodes.iter().map(|node| node.name.clone()).collect(),
    };
    Server::start(directory.path(), about, stop.clone()).ok()
}

/// Publishes what is recorded, for readers from outside.
fn open_tap(assembly: &Assembly, engine: &Engine) -> Result<Tap, Failure> {
    let nowhere =
        || Failure::Usage("--tap needs a run directory in /dev/shm, which a run in one process does not have".into());
    let directory = engine.directory().ok_or_else(nowhere)?;
    Ok(Tap::start(directory, &assembly.network, engine.core()).map_err(RunError::from)?)
}
