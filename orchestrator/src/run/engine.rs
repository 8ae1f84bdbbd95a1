//! The two ways to run a scenario: in this process, or in one process per participant.

use std::path::{Path, PathBuf};
use std::process::Command;

use formation::wiring::{Assembly, SCENARIO_FOLDER};
use lockstep::{Local, Plan, StepError, Store};
use processes::{Conductor, RunDirectory, RunError, Settings, Statistics, allowed_cores, pin_to_core, run_name};

use crate::failure::Failure;
use crate::logging;
use crate::run::control::RunControl;
use crate::run::options::Options;
use crate::run::pinning::{Affinity, describe};
use crate::run::priority::Priority;
use crate::run::robots::{Robots, place_hands, with_hands};
use crate::run::sources::write_scenario;
use crate::run::stress::Stress;
use crate::run::swap::{Swap, folder_of};

/// All processes together may take so many deadlines of a step to connect.
const START_DEADLINES: u32 = 3;

/// A run that is ready for its first step.
pub enum Engine {
    /// In this process.
    Local {
        /// What runs.
        local: Box<Local>,
        /// Where its control socket is; a run without one is as good, but cannot be controlled.
        directory: Option<RunDirectory>,
    },
    /// In processes of their own.
    Processes {
        /// Runs the processes.
        conductor: Box<Conductor>,
        /// Where they run.
        affinity: Affinity,
        /// The programs of the participants.
        programs: Programs,
    },
}

/// Which program plays which participant.
pub struct Programs {
    /// This program.
    program: PathBuf,
    swaps: Vec<Swap>,
    /// The emulators that were started for it; they end after the bridges.
    robots: Robots,
    stress: Option<Stress>,
    priority: Priority,
    /// The folder that paths of the scenario start from.
    folder: PathBuf,
    /// The core that all start on.
    pub core: Option<usize>,
}

impl Programs {
    /// The command of the worker of this name, for the run in `directory`; the emulator of a robot is started first.
    ///
    /// # Errors
    /// [`Failure`] if that does not start.
    pub fn command(&mut self, worker: &str, directory: &Path) -> Result<Command, Failure> {
        let mut command = match self.swaps.iter().find(|swap| swap.node == worker) {
            Some(swap) => self.robots.bridge(&self.program, directory, swap, self.priority)?,
            None => self.own_program(),
        };
        self.priority.apply(&mut command);
        command.env(SCENARIO_FOLDER, &self.folder);
        if let Some(stress) = &self.stress {
            stress.disturb(&mut command);
        }
        Ok(command)
    }

    /// Whether the worker of this name is the bridge to a robot.
    pub fn is_robot(&self, worker: &str) -> bool {
        self.swaps.iter().any(|swap| swap.node == worker && swap.robot().is_some())
    }

    /// This program as a participant.
    pub fn own_program(&self) -> Command {
        let mut command = Command::new(&self.program);
        command.arg("participant").env(logging::FILTER, logging::chosen());
        command
    }
}

/// How often every process may be started anew for swaps while the run goes on, besides its restarts. One that succeeds takes
/// one start, one that fails two.
const SWAPS: u32 = 16;

impl Engine {
    /// Builds all participants in this process, or starts the processes, which `connect` waits for. `stop`
    /// ends both the start and the run. `reached` is given the directory of the run as soon as it is there, and the number of
    /// processes.
    ///
    /// # Errors
    /// [`Failure::Invalid`] if a component cannot be built, [`Failure::Run`] if a process cannot be started or does not
    /// connect.
    pub fn start(
        assembly: &Assembly,
        options: &Options,
        affinity: Affinity,
        stop: &RunControl,
        reached: impl FnOnce(&RunDirectory, usize),
    ) -> Result<Self, Failure> {
        if options.in_one_process() {
            Self::local(assembly, reached)
        } else {
            Self::processes(assembly, options, affinity, stop, reached)
        }
    }

    fn local(assembly: &Assembly, reached: impl FnOnce(&RunDirectory, usize)) -> Result<Self, Failure> {
        let directory = RunDirectory::create(&assembly.scenario.name).ok();
        if let Some(directory) = &directory {
            reached(directory, 1);
        }
        let nodes: Vec<usize> = (0..assembly.network.nodes.len()).collect();
        let participants = assembly.participants(&nodes)?;
        let dt = assembly.scenario.context.timing.dt;
        let local = Local::new(assembly.network.clone(), participants, dt)
            .map_err(|error| vec![assembly.scenario.problem("", error.to_string())])?;
        Ok(Self::Local { local: Box::new(local), directory })
    }

    fn processes(
        assembly: &Assembly,
        options: &Options,
        affinity: Affinity,
        stop: &RunControl,
        reached: impl FnOnce(&RunDirectory, usize),
    ) -> Result<Self, Failure> {
        let timing = assembly.scenario.context.timing;
        let mut workers = options.placement.workers(assembly, &options.swaps);
        if let Some(stress) = &options.stress {
            stress.shuffle(&mut workers);
        }
        let count = workers.len();
        let network = with_hands(&assembly.network, &options.swaps);
        place_hands(&network, &mut workers, &options.swaps);
        let mut plan = Plan::new(&assembly.scenario.name, network, timing.period(), timing.periods() + 1, workers)
            .map_err(RunError::from)?;
        plan.traced = options.traced_runs();
        let directory = RunDirectory::create(&run_name(&assembly.scenario.name, options.wake))?;
        reached(&directory, count + 1);
        plan.bind_source(&write_scenario(assembly, directory.path())?);
        let program = std::env::current_exe().map_err(Failure::system("find this program"))?;
        let settings = Settings {
            deadline: lockstep::duration(options.on_failure.deadline),
            replacements: options.on_failure.restarts + SWAPS,
            wake: options.wake,
            ..Settings::default()
        };
        let mut programs = Programs {
            program,
            swaps: options.swaps.clone(),
            robots: Robots::default(),
            stress: options.stress,
            priority: options.priority,
            folder: folder_of(&assembly.scenario)?,
            core: affinity.core,
        };
        let mut conductor = Conductor::new(directory, plan, settings)?;
        stop.attach(conductor.interrupt());
        if let Some(folder) = &options.log_dir {
            conductor.keep_output(folder)?;
        }
        for worker in 0..count {
            if stop.is_requested() {
                return Err(RunError::Interrupted { step: 0 }.into());
            }
            let name = &conductor.plan().workers[worker].name;
            let command = programs.command(name, conductor.directory().path())?;
            let pid = conductor.spawn(worker, command, programs.core)?;
            tracing::debug!(process = conductor.plan().workers[worker].name, pid, "started");
            if let Some(stress) = &options.stress {
                stress.set_priority(worker, pid);
            }
        }
        Ok(Self::Processes { conductor: Box::new(conductor), affinity, programs })
    }

    /// Waits until all processes are connected.
    ///
    /// # Errors
    /// [`RunError`] if one fails before that, or is not connected in time; it may be replaced then, and this called again.
    pub(crate) fn connect(&mut self) -> Result<(), RunError> {
        let Self::Processes { conductor, .. } = self else { return Ok(()) };
        conductor.wait_ready(conductor.settings().deadline * START_DEADLINES)?;
        let (processes, run) = (conductor.plan().workers.len(), conductor.directory().name());
        tracing::info!(processes, run, "all processes are connected");
        Ok(())
    }

    /// Pins this thread to the core that the processes start on, if one was chosen.
    ///
    /// # Errors
    /// [`Failure::System`] if the operating system refuses.
    pub(crate) fn settle(&self) -> Result<(), Failure> {
        match self.core() {
            Some(core) => pin_to_core(core).map_err(Failure::system("pin to a core")),
            None => Ok(()),
        }
    }

    /// Tries from now on how many of `cores` make steps shortest, unless the user has set the core affinity of the processes.
    pub fn balance(&mut self, cores: &[usize]) {
        if let Self::Processes { conductor, affinity: Affinity { slot: Some(slot), .. }, .. } = self {
            let others = cores.iter().copied().filter(|&core| core != slot.core);
            conductor.tune_cores(std::iter::once(slot.core).chain(others).collect());
        }
    }

    /// Where the processes are and why, if that was tried.
    pub fn core_findings(&self) -> Option<String> {
        match self {
            Self::Processes { conductor, affinity: Affinity { slot: Some(slot), .. }, .. } => {
                describe(&conductor.core_findings()?, slot.shared)
            }
            _ => None,
        }
    }

    /// Runs one step of all participants and returns its number.
    ///
    /// # Errors
    /// [`RunError`]; the run is over then.
    pub fn step(&mut self) -> Result<u64, RunError> {
        match self {
            Engine::Local { local, .. } => local.step().map_err(|StepError { node, step, fault }| RunError::Fault {
                node,
                step,
                message: fault.to_string(),
            }),
            Engine::Processes { conductor, .. } => conductor.step(),
        }
    }

    /// The workers that have failed and can be replaced.
    pub(crate) fn failed_workers(&self, error: &RunError) -> Vec<usize> {
        match self {
            Engine::Local { .. } => Vec::new(),
            Engine::Processes { conductor, .. } => conductor.failed_workers(error),
        }
    }

    /// The names of the participants that a worker hosts.
    pub(crate) fn hosted(&self, worker: usize) -> impl Iterator<Item = &str> {
        let plan = match self {
            Engine::Local { .. } => None,
            Engine::Processes { conductor, .. } => Some(conductor.plan()),
        };
        plan.into_iter()
            .flat_map(move |plan| plan.workers[worker].nodes.iter().map(|&node| plan.network.nodes[node].name.as_str()))
    }

    /// Whether a worker is the bridge to a robot.
    pub(crate) fn is_robot(&self, worker: usize) -> bool {
        match self {
            Engine::Local { .. } => false,
            Engine::Processes { programs, .. } => programs.is_robot(&self.worker_name(worker)),
        }
    }

    /// The name of a worker.
    pub(crate) fn worker_name(&self, worker: usize) -> String {
        match self {
            Engine::Local { .. } => String::new(),
            Engine::Processes { conductor, .. } => conductor.plan().workers[worker].name.clone(),
        }
    }

    /// The worker that hosts this participant alone.
    pub(crate) fn worker_of(&self, node: &str) -> Option<usize> {
        let Engine::Processes { conductor, programs, .. } = self else { return None };
        let is_shared = programs.swaps.iter().any(|swap| swap.node == node && swap.shared.is_some());
        conductor.plan().workers.iter().position(|worker| worker.name == node && !is_shared)
    }

    /// How often a worker may still be replaced.
    pub(crate) fn replacements_left(&self, worker: usize) -> u32 {
        match self {
            Engine::Local { .. } => 0,
            Engine::Processes { conductor, .. } => conductor.replacements_left(worker),
        }
    }

    /// From now on this program plays the participant, or with `None` ours. Returns which one did before.
    pub(crate) fn take_on(&mut self, node: &str, swap: Option<Swap>) -> Option<Swap> {
        let Engine::Processes { programs, .. } = self else { return None };
        let before =
            programs.swaps.iter().position(|other| other.node == node).map(|place| programs.swaps.remove(place));
        programs.swaps.extend(swap);
        before
    }

    /// How many steps are done.
    pub(crate) fn steps_done(&self) -> u64 {
        self.statistics().read().completed
    }

    /// The samples of the step that ran last.
    pub fn store(&self) -> &Store {
        match self {
            Engine::Local { local, .. } => local.store(),
            Engine::Processes { conductor, .. } => conductor.store(),
        }
    }

    /// Number of processes, this one included.
    pub fn process_count(&self) -> usize {
        match self {
            Engine::Local { .. } => 1,
            Engine::Processes { conductor, .. } => conductor.plan().workers.len() + 1,
        }
    }

    /// The counters of the run.
    pub fn statistics(&self) -> Statistics {
        match self {
            Engine::Local { local, .. } => Statistics::from(&**local),
            Engine::Processes { conductor, .. } => conductor.statistics(),
        }
    }

    /// The core that the processes started on, if one was chosen.
    pub fn core(&self) -> Option<usize> {
        match self {
            Engine::Local { .. } => None,
            Engine::Processes { affinity, .. } => affinity.core,
        }
    }

    /// Where the run keeps what belongs to it.
    pub fn directory(&self) -> Option<&RunDirectory> {
        match self {
            Engine::Local { directory, .. } => directory.as_ref(),
            Engine::Processes { conductor, .. } => Some(conductor.directory()),
        }
    }

    /// No worker runs ahead of the requested step.
    pub fn run_step_by_step(&mut self) {
        if let Engine::Processes { conductor, .. } = self {
            conductor.set_ahead(0);
        }
    }

    /// Nothing is fetched from the processes, for a run that is not recorded.
    pub fn fetch_nothing(&mut self) {
        if let Engine::Processes { conductor, .. } = self {
            conductor.set_recording(false);
        }
    }

    /// Ends all processes and removes what they shared.
    pub fn finish(self) -> Ended {
        let statistics = self.statistics();
        match self {
            Engine::Local { directory, .. } => {
                let result = directory.map_or(Ok(()), |directory| Ok(directory.close()?));
                Ended { statistics, plan: None, result: warn_of_leftovers(result) }
            }
            Engine::Processes { conductor, .. } => {
                let plan = conductor.plan().clone();
                Ended { statistics, plan: Some(plan), result: warn_of_leftovers(conductor.finish()) }
            }
        }
    }
}

/// A file of the run that cannot be removed at its end takes nothing from its result.
///
/// # Errors
/// All others.
pub(crate) fn warn_of_leftovers(finished: Result<(), RunError>) -> Result<(), RunError> {
    match finished {
        Err(RunError::Directory(error)) => {
            tracing::warn!("the run is over, but something of it is left: {error}; `phalanx doctor` tries again");
            Ok(())
        }
        other => other,
    }
}

/// What is left of an engine whose processes have ended.
pub struct Ended {
    /// The counters of the run.
    pub statistics: Statistics,
    /// The plan, if there were processes.
    pub plan: Option<Plan>,
    /// Whether everything that they shared was removed.
    pub result: Result<(), RunError>,
}

/// The cores of this machine that a run may use. To be asked before any thread is pinned.
///
/// # Errors
/// [`Failure::System`] if the operating system does not tell.
pub fn cores() -> Result<Vec<usize>, Failure> {
    allowed_cores().map_err(Failure::system("ask for the cores of this machine"))
}
