//! One participant in a run with the recording of all others.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use formation::wiring::{Assembly, SCENARIO_FOLDER};
use lockstep::{Network, Plan, WorkerPlan};
use processes::{Conductor, RunDirectory, RunError, Settings, pin_to_core};

use crate::failure::Failure;
use crate::run::control::RunControl;
use crate::run::robots::{place_hands, with_hands};
use crate::run::sources::write_scenario;
use crate::run::swap::{Swap, folder_of, own_program, recording_command};

/// Name of the process that plays the others.
const OTHERS: &str = "recording";

/// The recording that a participant is run with, and how.
#[derive(Clone, Copy)]
pub struct ReplaySetup<'a> {
    /// The scenario.
    pub assembly: &'a Assembly,
    /// Its network, or one with other signals for a test.
    pub network: &'a Network,
    /// The log with the samples of the others.
    pub log: &'a Path,
    /// Number of the node that is run again.
    pub only: usize,
    /// The robot that takes the place of this node, if there is one.
    pub robot: Option<&'a Swap>,
    /// Factor of the recorded samples; a large one takes inputs out of all bounds, 1 leaves them as recorded.
    pub factor: f64,
    /// Time-outs and other settings of the conductor.
    pub settings: Settings,
    /// How long they may take to connect.
    pub start_timeout: Duration,
    /// How many of its last runs each process keeps for a trace.
    pub traced: u32,
    /// The core of all processes; `None`: the operating system decides.
    pub core: Option<usize>,
}

/// A participant, a process that plays all others, and their conductor, ready for the first step.
pub struct ReplayRun {
    /// Opens every step and waits for its end.
    pub conductor: Conductor,
    /// Number of the worker that hosts the participant.
    pub worker: usize,
}

impl ReplayRun {
    /// Starts the participant, by the command that `command` gives for a run in a directory, and the others.
    ///
    /// # Errors
    /// [`Failure::Run`] if a process cannot be started or does not connect, [`Failure::System`], and those of `command`.
    pub fn start(
        setup: &ReplaySetup,
        command: impl FnOnce(&Path) -> Result<Command, Failure>,
        stop: &RunControl,
    ) -> Result<Self, Failure> {
        let mut replay = Self::prepare(setup)?;
        let mut command = command(replay.conductor.directory().path())?;
        command.env(SCENARIO_FOLDER, folder_of(&setup.assembly.scenario)?);
        stop.attach(replay.conductor.interrupt());
        let others = recording_command(&own_program()?, setup.log, setup.factor);
        replay.conductor.spawn(1 - replay.worker, others, setup.core)?;
        replay.conductor.spawn(replay.worker, command, setup.core)?;
        replay.conductor.wait_ready(setup.start_timeout)?;
        if let Some(core) = setup.core {
            pin_to_core(core).map_err(Failure::system("pin to a core"))?;
        }
        Ok(replay)
    }

    /// The run directory with all that the processes need, before any of them is started.
    ///
    /// # Errors
    /// As those of [`ReplayRun::start`].
    pub fn prepare(setup: &ReplaySetup) -> Result<Self, Failure> {
        let scenario = &setup.assembly.scenario;
        let robots = setup.robot.map(std::slice::from_ref).unwrap_or_default();
        let network = with_hands(setup.network, robots);
        let timing = scenario.context.timing;
        let others = (0..setup.network.nodes.len()).filter(|&node| node != setup.only).collect();
        let mut workers = vec![
            WorkerPlan { name: network.nodes[setup.only].name.clone(), nodes: vec![setup.only] },
            WorkerPlan { name: OTHERS.into(), nodes: others },
        ];
        place_hands(&network, &mut workers, robots);
        let plan = Plan::new(&scenario.name, network, timing.period(), timing.periods() + 1, workers);
        let mut plan = plan.map_err(RunError::from)?;
        plan.traced = setup.traced;
        let directory = RunDirectory::create(&scenario.name)?;
        write_scenario(setup.assembly, directory.path())?;
        Ok(Self { conductor: Conductor::new(directory, plan, setup.settings)?, worker: 0 })
    }
}
