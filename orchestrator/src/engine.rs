//! The two ways to run a scenario: in this process, or in one process per participant.

use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use formation::wiring::{Assembly, SCENARIO_FILE};
use lockstep::{
    Conductor, Interrupt, Local, Plan, RunDirectory, RunError, Settings, StepError, Store, WorkerPlan, pin_to_core,
};

use crate::failure::Failure;
use crate::swap::Swap;

/// How the participants are spread over processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Placement {
    /// Every participant is a process of its own.
    Processes,
    /// Observer and controller of an agent share a process.
    Agents,
    /// All participants run in this process.
    Single,
}

/// How long all processes together may take to connect.
const START_TIMEOUT: Duration = Duration::from_secs(30);

/// A run that is ready for its first step.
pub enum Engine {
    /// In this process.
    Local(Box<Local>),
    /// In processes of their own.
    Processes(Box<Conductor>),
}

/// Ends a run from another thread.
#[derive(Clone)]
pub struct Stop {
    requested: Arc<AtomicBool>,
    interrupt: Option<Interrupt>,
}

impl Stop {
    /// Makes the current or the next step return as interrupted.
    pub fn request(&self) {
        self.requested.store(true, Ordering::SeqCst);
        if let Some(interrupt) = &self.interrupt {
            interrupt.raise();
        }
    }

    /// Whether the end was requested.
    pub fn is_requested(&self) -> bool {
        self.requested.load(Ordering::Relaxed)
    }
}

impl Engine {
    /// Builds all participants in this process.
    ///
    /// # Errors
    /// [`Failure::Invalid`] if a component cannot be built.
    pub fn local(assembly: &Assembly) -> Result<Self, Failure> {
        let nodes: Vec<usize> = (0..assembly.network.nodes.len()).collect();
        let participants = assembly.participants(&nodes)?;
        let dt = assembly.scenario.context.timing.dt;
        let local = Local::new(assembly.network.clone(), participants, dt)
            .map_err(|error| vec![assembly.scenario.problem("", error.to_string())])?;
        Ok(Self::Local(Box::new(local)))
    }

    /// Starts a process for every group of participants and waits until all are connected.
    ///
    /// # Errors
    /// [`Failure::Run`] if a process cannot be started or does not connect.
    pub fn processes(
        assembly: &Assembly,
        placement: Placement,
        core: Option<usize>,
        swaps: &[Swap],
    ) -> Result<Self, Failure> {
        let timing = assembly.scenario.context.timing;
        let workers = groups(assembly, placement, swaps);
        let count = workers.len();
        let plan = Plan::new(
            &assembly.scenario.name,
            assembly.network.clone(),
            timing.period_ns(),
            timing.periods() + 1,
            workers,
        )
        .map_err(RunError::from)?;
        RunDirectory::sweep()?;
        let directory = RunDirectory::create(&assembly.scenario.name)?;
        let path = directory.path().join(SCENARIO_FILE);
        std::fs::write(&path, assembly.scenario.to_toml())
            .map_err(Failure::system(format!("write {}", path.display())))?;
        let program = std::env::current_exe().map_err(Failure::system("find this program"))?;
        let mut conductor = Conductor::new(directory, plan, Settings::default())?;
        for worker in 0..count {
            let name = &conductor.plan().workers[worker].name;
            let command = match swaps.iter().find(|swap| swap.node == *name) {
                Some(swap) => swap.command(),
                None => {
                    let mut command = Command::new(&program);
                    command.arg("participant");
                    command
                }
            };
            conductor.spawn(worker, command, core)?;
        }
        conductor.wait_ready(START_TIMEOUT)?;
        if let Some(core) = core {
            pin_to_core(core).map_err(Failure::system("pin to a core"))?;
        }
        Ok(Self::Processes(Box::new(conductor)))
    }

    /// Runs one step of everybody and returns its number.
    ///
    /// # Errors
    /// [`RunError`]; the run is over then.
    pub fn step(&mut self) -> Result<u64, RunError> {
        match self {
            Engine::Local(local) => local.step().map_err(|StepError { node, step, fault }| RunError::Fault {
                node,
                step,
                message: fault.to_string(),
            }),
            Engine::Processes(conductor) => conductor.step(),
        }
    }

    /// The samples of the step that ran last.
    pub fn store(&self) -> &Store {
        match self {
            Engine::Local(local) => local.store(),
            Engine::Processes(conductor) => conductor.store(),
        }
    }

    /// Number of processes, this one included.
    pub fn process_count(&self) -> usize {
        match self {
            Engine::Local(_) => 1,
            Engine::Processes(conductor) => conductor.plan().workers.len() + 1,
        }
    }

    /// A handle that ends the run.
    pub fn stop(&self) -> Stop {
        let interrupt = match self {
            Engine::Local(_) => None,
            Engine::Processes(conductor) => Some(conductor.interrupt()),
        };
        Stop { requested: Arc::new(AtomicBool::new(false)), interrupt }
    }

    /// Ends all processes and removes what they shared.
    ///
    /// # Errors
    /// [`RunError`] if something cannot be removed.
    pub fn finish(self) -> Result<(), RunError> {
        match self {
            Engine::Local(_) => Ok(()),
            Engine::Processes(conductor) => conductor.finish(),
        }
    }
}

/// The processes of a placement and the nodes that each hosts.
fn groups(assembly: &Assembly, placement: Placement, swaps: &[Swap]) -> Vec<WorkerPlan> {
    let mut workers: Vec<WorkerPlan> = Vec::new();
    for (index, (node, role)) in assembly.network.nodes.iter().zip(&assembly.nodes).enumerate() {
        let swapped = swaps.iter().any(|swap| swap.node == node.name);
        let name = match (placement, role.agents.as_slice()) {
            _ if swapped => node.name.clone(),
            (Placement::Single, _) => "all".to_string(),
            (Placement::Agents, [agent]) if node.name.contains('_') => format!("agent_{}", agent + 1),
            _ => node.name.clone(),
        };
        match workers.iter_mut().find(|worker| worker.name == name) {
            Some(worker) => worker.nodes.push(index),
            None => workers.push(WorkerPlan { name, nodes: vec![index] }),
        }
    }
    workers
}
