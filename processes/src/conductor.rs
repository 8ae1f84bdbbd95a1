//! The process that runs the others: creates what they share, starts them, beats the time, ends them.

mod affinity;
mod child;
mod core_tuning;
mod damage;
mod error;
mod output_reader;
mod poll;
mod ports;
mod replace;
mod statistics;
mod status;
mod supervisor;
mod wait;
mod worker_processes;
mod yield_tuning;

use std::collections::BTreeSet;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub use affinity::CoreFindings;
pub use error::{Activity, Death, Late, RunError};
pub use replace::History;
pub use statistics::{PhaseUsage, Snapshot, Span, Statistics, WorkerUsage};
pub use status::Interrupt;

use affinity::CoreAffinity;
use damage::Allowance;
use error::system;
use ports::Ports;
use status::RunStatus;
use supervisor::Supervisor;
use worker_processes::WorkerProcesses;
use yield_tuning::YieldTuning;

use crate::board::RING;
use crate::board_parts::BoardParts;
use crate::descendants::Descendants;
use crate::page::{Events, Page};
use crate::{RunDirectory, bus, directory};
use lockstep::{Plan, Store, Wake};

/// How a conductor treats its workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// How long a phase may take.
    pub deadline: Duration,
    /// How long workers may take to end by themselves before they are killed.
    pub grace: Duration,
    /// Whether what workers print is passed on to stderr, with their names.
    pub forward_output: bool,
    /// How often every worker may be replaced while the run goes on: shared memory has places for so many readers.
    pub replacements: u32,
    /// What the processes wake each other with.
    pub wake: Wake,
}

impl Default for Settings {
    /// A deadline of 10 s, a grace of 2 s, output passed on, eight replacements, futexes.
    fn default() -> Self {
        let (deadline, grace) = (Duration::from_secs(10), Duration::from_secs(2));
        Self { deadline, grace, forward_output: true, replacements: 8, wake: Wake::Futex }
    }
}

/// Runs a plan in processes.
///
/// Create it, [`spawn`](Self::spawn) every worker, [`wait_ready`](Self::wait_ready), [`step`](Self::step) as often as you
/// like, [`finish`](Self::finish). Dropping it in between also ends all processes and removes all files.
///
/// The processes die with the thread that spawned them; that is why a conductor cannot be sent to another thread.
pub struct Conductor {
    // Dropped in this order: first the processes, then what they share, last the directory.
    workers: WorkerProcesses,
    ports: Ports,
    parts: BoardParts,
    /// How many processes read from each service, by worker and service.
    reader_counts: Vec<Vec<usize>>,
    store: Store,
    plan: Plan,
    directory: RunDirectory,
    settings: Settings,
    recording: bool,
    yield_tuning: YieldTuning,
    affinity: CoreAffinity,
    /// How many steps the workers may be ahead of the step that is returned next.
    ahead: u64,
    /// What the page must say about that.
    allowance: Allowance,
    /// The shared memory of the run, with its sizes.
    segments: Vec<(PathBuf, u64)>,
    ready: bool,
    /// Whether a step has failed.
    failed: bool,
    next: u64,
    stays_in_its_thread: PhantomData<*mut ()>,
}

impl Conductor {
    /// Prepares a run of `plan` in `directory`, after which it is named. All services exist when this returns.
    ///
    /// # Errors
    /// [`RunError`] if the operating system or iceoryx2 refuse something.
    pub fn new(directory: RunDirectory, mut plan: Plan, settings: Settings) -> Result<Self, RunError> {
        plan.run = directory.name().into();
        plan.wake = settings.wake;
        directory.write_plan(&plan)?;
        // Early: it has a copy of what this process has in memory.
        let descendants = Descendants::new();
        directory.note_descendants(descendants)?;
        let supervisor = Supervisor::start(descendants).map_err(system("start the process that guards the run"))?;
        bus::stand_in_for_missing_memory();
        let mut ports = Ports::open(directory.path(), &plan.run)?;
        let parts = BoardParts::of(&plan);
        let reader_counts = reader_counts(&parts, &plan, settings.replacements as usize);
        ports.extend(|boards, readers| {
            for part in parts.all() {
                let processes = reader_counts[part.worker][part.number];
                readers.extend(boards.create(&plan, part, 0, processes)?.readers(|_| true)?);
            }
            readers.sort_by_key(|reader| reader.channel);
            Ok::<(), RunError>(())
        })?;
        let events = match plan.wake {
            Wake::Futex => None,
            Wake::Events => Some(Events::create(directory.path(), &plan, settings.replacements as usize)?),
        };
        directory.protect()?;
        directory::require_room(room_of_workers(&parts, &plan)).map_err(system("start the processes of the run"))?;
        let page = Page::create(&plan).map_err(system("create the shared page"))?;
        page.use_events(events);
        let status = Arc::new(RunStatus::new(page, plan.workers.len()));
        let workers =
            WorkerProcesses::new(&plan, status, settings.grace, settings.forward_output, (descendants, supervisor))?;
        let segments = directory.segments();
        let store = Store::of(&plan.network);
        Ok(Self {
            workers,
            ports,
            parts,
            reader_counts,
            store,
            plan,
            directory,
            settings,
            recording: true,
            yield_tuning: YieldTuning::new(),
            affinity: CoreAffinity::default(),
            ahead: RING - 1,
            allowance: Allowance::default(),
            segments,
            ready: false,
            failed: false,
            next: 0,
            stays_in_its_thread: PhantomData,
        })
    }

    /// Keeps all that the workers print in the folder `folder`, a file `<worker>.log` each. To be called before they are spawned.
    ///
    /// # Errors
    /// [`RunError::System`] if the folder cannot be created.
    pub fn keep_output(&mut self, folder: &Path) -> Result<(), RunError> {
        self.workers.keep_output(folder)
    }

    /// Starts the process of worker number `worker` with `command`, pinned to `cpu` if one is given, and returns its pid.
    ///
    /// The program must call [`serve`](crate::serve). It finds its place by the environment variables `PHALANX_RUN_DIR`,
    /// `PHALANX_WORKER` and `PHALANX_PAGE_FD`. Its stdin is empty; stdout and stderr are read by the conductor.
    ///
    /// # Errors
    /// [`RunError::System`] if the program cannot be started.
    ///
    /// # Panics
    /// If the plan has no such worker.
    pub fn spawn(&mut self, worker: usize, command: Command, cpu: Option<usize>) -> Result<u32, RunError> {
        self.workers.spawn(worker, command, cpu, self.directory.path(), None)
    }

    /// Waits until all workers are connected.
    ///
    /// # Errors
    /// [`RunError::Refused`] or [`RunError::Died`] as soon as one fails, [`RunError::NotReady`] after `timeout`.
    pub fn wait_ready(&mut self, timeout: Duration) -> Result<(), RunError> {
        let start = Instant::now();
        let workers = 0..self.plan.workers.len();
        loop {
            let page = &self.workers.status.page;
            let rings = page.rings();
            if page.ready_count() == workers.len() {
                self.ready = true;
                return Ok(());
            }
            self.look_around(0, None)?;
            let left = timeout.saturating_sub(start.elapsed());
            if left.is_zero() {
                let missing =
                    workers.filter(|&worker| !page.is_ready(worker)).map(|worker| self.workers.late(worker, None));
                return Err(RunError::NotReady { missing: missing.collect(), waited: timeout });
            }
            page.sleep(rings, left);
        }
    }

    /// Waits for the next step and returns its number. If recording, all its samples are in [`store`](Self::store) then.
    ///
    /// The workers may be ahead of it, see [`set_ahead`](Self::set_ahead).
    ///
    /// # Errors
    /// [`RunError`]; the run is over then.
    pub fn step(&mut self) -> Result<u64, RunError> {
        let step = self.next;
        if self.failed || step >= self.plan.steps {
            return Err(RunError::Over { steps: step });
        }
        // Cleared again if all goes well.
        self.failed = true;
        if !self.ready {
            self.wait_ready(Duration::ZERO)?;
        }
        self.look_at_page(step)?;
        self.allowance.allow(&self.workers.status.page, (step + self.ahead + 1).min(self.plan.steps));
        self.await_step(step).map_err(|error| self.explain(step, error))?;
        self.yield_tuning.at(step, &self.workers.status.page);
        self.adjust_cores(step);
        if self.recording {
            for reader in self.ports.readers.iter() {
                if let Err(bad) = reader.fetch(&self.plan.network, &mut self.store, step) {
                    let error = RunError::Recording { step, message: bad.describe(&self.plan.network) };
                    return Err(self.explain(step, error));
                }
            }
        }
        self.next += 1;
        self.failed = false;
        Ok(step)
    }

    /// Lets the workers be up to `steps` ahead of the step that [`step`](Self::step) returns next; more than 7, which is the
    /// default, counts as 7. It changes no bit of the result, and a run that fails still returns all steps before.
    ///
    /// The further ahead, the less often the conductor has to be woken. With 0 no worker runs before `step` is called: for
    /// steps at given times, or if the participants are inspected in between. Steps that were allowed before still run.
    pub fn set_ahead(&mut self, steps: u64) {
        self.ahead = steps.min(RING - 1);
    }

    /// Whether [`step`](Self::step) fetches all samples (it does from the start). Without, a step is a little faster.
    pub fn set_recording(&mut self, recording: bool) {
        self.recording = recording;
    }

    /// The samples of the last two recorded steps.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// What runs.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// How it treats its workers.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Where it runs.
    pub fn directory(&self) -> &RunDirectory {
        &self.directory
    }

    /// The process of a worker, once it is spawned.
    pub fn pid(&self, worker: usize) -> Option<u32> {
        self.workers.pid(worker)
    }

    /// A handle to interrupt the run from another thread.
    pub fn interrupt(&self) -> Interrupt {
        Interrupt(Arc::clone(&self.workers.status))
    }

    /// A handle to look at the run's counters, also from another thread.
    pub fn statistics(&self) -> Statistics {
        Statistics::new(Arc::clone(&self.workers.status), &self.plan)
    }

    /// Ends the run in order: tells all workers, gives them the grace period, kills who remains, removes all files.
    ///
    /// # Errors
    /// [`RunError::Directory`] if a file cannot be removed.
    pub fn finish(self) -> Result<(), RunError> {
        let Self { workers, ports, directory, .. } = self;
        drop(workers);
        drop(ports);
        Ok(directory.close()?)
    }
}

/// Bytes of shared memory that the workers will take for themselves: a small file for every service that each uses, and some.
fn room_of_workers(parts: &BoardParts, plan: &Plan) -> usize {
    /// What a file takes at least.
    const FILE: usize = 4 << 10;
    /// Files of a worker besides those of services.
    const OTHERS: usize = 4;
    let events = usize::from(plan.wake == Wake::Events);
    let written = parts.all().count();
    let read: usize = parts.readers(plan).iter().flatten().map(BTreeSet::len).sum();
    // With events, a file for every gate that it listens at, and those of one more node.
    let listeners = |nodes: &Vec<usize>| events * (nodes.len() + OTHERS);
    let others: usize = plan.workers.iter().map(|worker| listeners(&worker.nodes) + OTHERS).sum();
    (written + read + others) * FILE
}

/// How many worker processes read from each service, by worker and service, if each is replaced so often.
fn reader_counts(parts: &BoardParts, plan: &Plan, replacements: usize) -> Vec<Vec<usize>> {
    // A successor of the writer reads what was published before it; so does the conductor once more.
    let with_successors = |readers: &BTreeSet<usize>| (readers.len() + 1) * (replacements + 1) + replacements;
    let of_worker = |readers: &Vec<BTreeSet<usize>>| readers.iter().map(with_successors).collect();
    parts.readers(plan).iter().map(of_worker).collect()
}
