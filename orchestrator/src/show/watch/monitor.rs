//! Samples of a run that is going on.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use formation::config::{TextError, read_text};
use formation::data::DataSource;
use formation::scenario::Selection;
use formation::wiring::{Assembly, SCENARIO_FILE};
use lockstep::{ChannelId, Period};
use processes::{Monitor, MonitorError, RunDirectory};

use super::past::{KeptSteps, NoPast, read_past};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::show::view::{Grid, LoggedRun, panels};
use recording::Log;

/// Steps that are remembered, if a step has few numbers.
const MOST_STEPS: usize = 3000;
/// Steps that are remembered at least.
const LEAST_STEPS: usize = 200;
/// Numbers that are remembered.
const MOST_NUMBERS: usize = 2_000_000;

/// The samples of a run so far, thinned out; shared with the thread that serves pages.
pub(crate) type History = Arc<Mutex<LoggedRun>>;

/// Reads the samples of a run that is going on, without the run noticing.
pub(crate) struct RunMonitor {
    monitor: Monitor,
    /// Length of the run, s.
    pub(crate) duration: f64,
    period: Period,
    /// The newest step that was read.
    newest: Option<u64>,
    /// That step alone.
    now: LoggedRun,
    history: History,
    kept_steps: KeptSteps,
    /// Why the history begins when this joined; `None` if it begins with the run.
    pub(crate) no_past: Option<NoPast>,
}

impl RunMonitor {
    /// Joins a run whose participants are processes, and reads what it did before from its log.
    ///
    /// # Errors
    /// [`Failure`] if it is over or has no channels that can be looked at from outside.
    pub(crate) fn join(catalog: &Catalog, run: &str, log: Option<&Path>) -> Result<Self, Failure> {
        let path = RunDirectory::path_of(run).join(SCENARIO_FILE);
        let text = read_text(&path).map_err(|error| match error {
            TextError::System(error) if error.kind() == std::io::ErrorKind::NotFound => {
                Failure::Usage(format!("the run {run} is over"))
            }
            TextError::System(error) => Failure::system(format!("read {}", path.display()))(error),
            other => Failure::Usage(format!("cannot read {}: {other}", path.display())),
        })?;
        let selection = Selection { data: DataSource::Folder(RunDirectory::path_of(run)), ..Selection::default() };
        let assembly = Assembly::load(SCENARIO_FILE, &text, &selection, &catalog.roles)?;
        let (scenario, network) = (assembly.scenario, assembly.network);
        let metadata: BTreeMap<String, String> =
            [("scenario", &scenario.name), ("variant", &scenario.variant)].map(|(k, v)| (k.into(), v.clone())).into();
        let files = scenario.data.iter();
        let data = files.map(|file| (file.path.clone(), Arc::clone(&file.bytes))).collect();
        let empty = Log::live(run, &network, text, data, metadata);
        let monitor = Monitor::join(run, network).map_err(|error| match error {
            MonitorError::Over(run) => Failure::Usage(format!("the run {run} is over")),
            MonitorError::Directory(error) => error.into(),
            MonitorError::Service(error) => Failure::Usage(format!(
                "the run {run} cannot be watched: {error}; too many processes may watch it already"
            )),
        })?;
        let timing = scenario.context.timing;
        let mut kept_steps = KeptSteps::of((MOST_NUMBERS / empty.width().max(1)).clamp(LEAST_STEPS, MOST_STEPS));
        let mut history = LoggedRun::growing(empty.clone(), scenario.clone());
        let past = read_past(log, monitor.network(), &mut kept_steps, &mut history.log);
        Ok(Self {
            monitor,
            duration: timing.duration,
            period: timing.period(),
            newest: kept_steps.last(),
            kept_steps,
            now: LoggedRun::growing(empty, scenario),
            history: Arc::new(Mutex::new(history)),
            no_past: past.err(),
        })
    }

    /// Whether the run has ended. What it did last can still be looked at.
    pub(crate) fn is_over(&self) -> bool {
        self.monitor.is_over()
    }

    /// Looks at the run; whether there was anything new.
    pub(crate) fn look(&mut self) -> bool {
        let Some(step) = self.monitor.look().filter(|step| self.newest.is_none_or(|newest| *step > newest)) else {
            return false;
        };
        self.newest = Some(step);
        let monitor = &self.monitor;
        let samples = || (0..monitor.network().channels.len()).map(move |channel| monitor.sample(ChannelId(channel)));
        self.now.log.clear();
        self.now.log.push(self.period.time_ns(step), samples());
        self.kept_steps.take(&mut lock(&self.history).log, step, self.period.time_ns(step), samples());
        true
    }

    /// The step that was seen last.
    pub(crate) fn newest(&self) -> Option<u64> {
        self.newest
    }

    /// The step that was seen last, with nothing before it; `None` if none was.
    pub(crate) fn now(&self) -> Option<&LoggedRun> {
        (self.now.samples() > 0).then_some(&self.now)
    }

    /// All samples that are kept.
    pub(crate) fn history(&self) -> History {
        self.history.clone()
    }

    /// The tracking error of each agent now; none if the scenario has no such thing.
    pub(crate) fn errors(&self) -> Option<Errors> {
        self.now().and_then(Errors::of)
    }

    /// The same of all samples that are kept.
    pub(crate) fn past_errors(&self) -> Option<Errors> {
        Errors::of(&lock(&self.history))
    }
}

/// Tracking errors over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Errors {
    /// Times, s.
    pub(crate) times: Vec<f64>,
    /// For each agent one value per time.
    pub(crate) values: Vec<Vec<f64>>,
    /// Their unit.
    pub(crate) unit: String,
}

impl Errors {
    fn of(run: &LoggedRun) -> Option<Self> {
        let samples = run.samples();
        if samples == 0 {
            return None;
        }
        let first = panels(run, &Grid::new(samples, samples + 1)).into_iter().next()?;
        let view = (first.id == "tracking-errors").then_some(first)?.views.into_iter().next()?;
        let values = view.curves.into_iter().map(|curve| curve.values).collect();
        Some(Self { times: (0..samples).map(|sample| run.time(sample)).collect(), values, unit: view.unit })
    }
}

/// Locks a mutex, also after a panic of another thread: no change under these locks has steps that depend on each other.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
