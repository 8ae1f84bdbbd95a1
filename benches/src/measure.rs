//! One measurement: seconds per step.

use std::collections::BTreeMap;
use std::env;
use std::error::Error;
use std::process::Command;
use std::time::{Duration, Instant};

use formation::scenario::Selection;
use formation::wiring::Assembly;
use lockstep::{Header, Local, Network, Node, Plan, Status, Store, Wake, WorkerPlan};
use orchestrator::run::placement::Placement;
use orchestrator::run::{Options, run};
use processes::{Conductor, RunDirectory, Settings};
use recording::{DEFAULT_FLUSH_EVERY, Recorder, RunInfo};
use schemes::{ROLES, SCENARIOS};

use crate::{beside_core, chain, in_thread, on_core};

/// Length of a step, ns.
const PERIOD: u64 = 1_000_000;
/// Steps before the measurement starts.
const WARM_UP: u64 = 200;

/// Steps that are never asked for: more than workers run ahead.
const SPARE: u64 = 64;

/// Whether a run is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Recording {
    /// Nothing is fetched.
    Off,
    /// Every sample of every channel goes into an MCAP file.
    On,
}

/// What a run in processes takes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Taken {
    /// Per step, s.
    pub(crate) step: f64,
    /// From the first process to the connection of the last, s.
    pub(crate) start: f64,
    /// From the last step to the end of the last process, s.
    pub(crate) end: f64,
    /// Largest private memory of a process, bytes.
    pub(crate) memory: f64,
}

/// In a process per node and one for the conductor, all on one core.
pub(crate) fn processes(agents: usize, steps: u64, core: usize, recording: Recording) -> Result<Taken, Box<dyn Error>> {
    processes_on(agents, steps, &[core], recording)
}

/// The same, moved to these cores as `phalanx run --pin auto` moves them if steps are shorter there.
pub(crate) fn processes_on(
    agents: usize,
    steps: u64,
    cores: &[usize],
    recording: Recording,
) -> Result<Taken, Box<dyn Error>> {
    processes_by(Wake::Futex, agents, steps, cores, recording)
}

/// The same, with processes that wake each other like this.
pub(crate) fn processes_by(
    wake: Wake,
    agents: usize,
    steps: u64,
    cores: &[usize],
    recording: Recording,
) -> Result<Taken, Box<dyn Error>> {
    let (core, cores) = (*cores.first().ok_or("no core")?, cores.to_vec());
    let network = chain::network(agents);
    // The thread that compresses must not share the core of the participants.
    let mut log = beside_core(core, || Log::create(&network, recording))?;
    on_core(core, move || {
        let worker = |(index, node): (usize, &Node)| WorkerPlan { name: node.name.clone(), nodes: vec![index] };
        let workers: Vec<WorkerPlan> = network.nodes.iter().enumerate().map(worker).collect();
        // Longer than it is run, so that all processes are still there when their memory is looked at.
        let plan = Plan::new("bench", network, PERIOD, WARM_UP + steps + SPARE, workers)?;
        let start = Instant::now();
        let settings = Settings { wake, ..Settings::default() };
        let mut conductor = Conductor::new(RunDirectory::create("bench")?, plan, settings)?;
        for worker in 0..chain::nodes(agents) {
            conductor.spawn(worker, Command::new(env::current_exe()?), Some(core))?;
        }
        conductor.wait_ready(Duration::from_secs(60))?;
        let start = start.elapsed().as_secs_f64();
        if cores.len() > 1 {
            let turns = (0..chain::nodes(agents)).map(|node| cores[if node < 2 { 0 } else { node % cores.len() }]);
            conductor.spread(&turns.collect::<Vec<_>>())?;
        }
        conductor.set_recording(recording == Recording::On);
        let step = time(steps, || {
            let step = conductor.step()?;
            log.record(step, conductor.store())
        })?;
        if recording == Recording::On {
            check(agents, conductor.store(), WARM_UP + steps);
        }
        let memory = (0..chain::nodes(agents)).filter_map(|worker| private_memory(conductor.pid(worker)?)).max();
        let end = Instant::now();
        conductor.finish()?;
        let end = end.elapsed().as_secs_f64();
        log.finish()?;
        Ok(Taken { step, start, end, memory: memory.unwrap_or(0) as f64 })
    })
}

/// Private memory of a process, bytes.
fn private_memory(pid: u32) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).ok()?;
    let lines = text.lines().filter(|line| line.starts_with("Private_"));
    Some(lines.filter_map(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok()).sum::<u64>() * 1024)
}

/// In this process.
pub(crate) fn single(steps: u64, recording: Recording) -> Result<f64, Box<dyn Error>> {
    let network = chain::network(chain::AGENTS);
    let mut log = Log::create(&network, recording)?;
    let participants = (0..chain::NODES).map(|node| chain::participant(chain::AGENTS, node)).collect();
    let mut local = Local::new(network, participants, PERIOD as f64 / 1e9)?;
    let seconds = time(steps, || {
        let step = local.step()?;
        log.record(step, local.store())
    })?;
    check(chain::AGENTS, local.store(), WARM_UP + steps);
    log.finish()?;
    Ok(seconds)
}

/// The six drones at 1 ms, a process each and recorded, as `phalanx run` does it: in so many steps.
pub(crate) fn uav(steps: u64) -> Result<f64, Box<dyn Error>> {
    let shipped = SCENARIOS.iter().find(|shipped| shipped.name == "uav").ok_or("there is no scenario uav")?;
    let overrides = vec!["timing.dt=0.001".into(), format!("timing.duration={}", steps as f64 / 1000.0)];
    let selection = Selection { overrides, ..Selection::default() };
    let assembly = Assembly::load(shipped.file, shipped.text, &selection, &ROLES)
        .map_err(|problems| problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))?;
    let path = env::temp_dir().join(format!("phalanx-bench-uav-{}.mcap", std::process::id()));
    // In a thread of its own, which the run leaves on the core that it takes.
    let outcome = in_thread(|| Ok(run(&assembly, &Options::new(Placement::Processes, Some(path.clone())), |_| {})?))?;
    std::fs::remove_file(path)?;
    outcome.ending.into_result()?;
    Ok(outcome.wall / outcome.steps as f64)
}

/// A fast engine that computes something else is worth nothing: known results must come out.
fn check(agents: usize, store: &Store, steps: u64) {
    let known = [(2_200, "401660ed0ae7a22d"), (20_200, "404564614da987a3"), (100_200, "406a024712dbcd3c")];
    if let Some((_, digest)) = known.iter().find(|known| known.0 == steps && agents == chain::AGENTS) {
        assert_eq!(chain::digest(agents, store, steps - 1), *digest, "after {steps} steps");
    }
}

fn time(steps: u64, mut step: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    for _ in 0..WARM_UP {
        step()?;
    }
    let start = Instant::now();
    for _ in 0..steps {
        step()?;
    }
    Ok(start.elapsed().as_secs_f64() / steps as f64)
}

/// The log of a measurement, removed with it.
struct Log {
    recorder: Option<Recorder>,
    path: std::path::PathBuf,
}

impl Log {
    fn create(network: &Network, recording: Recording) -> Result<Self, Box<dyn Error>> {
        let path = env::temp_dir().join(format!("phalanx-bench-{}.mcap", std::process::id()));
        let info = RunInfo {
            network,
            period: PERIOD.into(),
            scenario: "",
            metadata: &BTreeMap::new(),
            flush_every: DEFAULT_FLUSH_EVERY,
        };
        let recorder = match recording {
            Recording::On => Some(Recorder::create(&path, &info)?),
            Recording::Off => None,
        };
        Ok(Self { recorder, path })
    }

    fn record(&mut self, step: u64, store: &Store) -> Result<(), Box<dyn Error>> {
        let Some(recorder) = &mut self.recorder else { return Ok(()) };
        let empty = Header::new(step, PERIOD, 0, Status::Held);
        recorder.record(step, store, |channel| store.header(channel, step).copied().unwrap_or(empty))?;
        Ok(())
    }

    fn finish(self) -> Result<(), Box<dyn Error>> {
        if let Some(recorder) = self.recorder {
            recorder.finish()?;
            std::fs::remove_file(&self.path)?;
        }
        Ok(())
    }
}

/// Seconds of a step of the scenario in `text`, in this thread.
pub(crate) fn step_of(file: &str, text: &str, steps: u64) -> Result<f64, Box<dyn Error>> {
    let assembly = Assembly::load(file, text, &Selection::default(), &ROLES)
        .map_err(|problems| problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))?;
    let nodes: Vec<usize> = (0..assembly.network.nodes.len()).collect();
    let participants = assembly.participants(&nodes).map_err(|problems| problems[0].to_string())?;
    let dt = assembly.scenario.context.timing.dt;
    let mut local = Local::new(assembly.network.clone(), participants, dt)?;
    for _ in 0..WARM_UP {
        local.step()?;
    }
    let start = Instant::now();
    for _ in 0..steps {
        local.step()?;
    }
    Ok(start.elapsed().as_secs_f64() / steps as f64)
}
