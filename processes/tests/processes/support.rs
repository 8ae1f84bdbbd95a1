//! How the tests start runs and what they expect of their ends. This binary runs itself as its workers.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use lockstep::{Network, Plan, Wake, WorkerPlan};
use processes::{Conductor, RunDirectory, RunError, Settings};

/// The environment variable that tells a worker of a test what to do: see `worker`.
pub(crate) const PLAY: &str = "LOCKSTEP_TEST_PLAY";

/// This test binary, told to run only the entry point called `entry`.
pub(crate) fn this_binary(entry: &str) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args([entry, "--exact", "--nocapture", "--test-threads=1", "--quiet"]);
    command
}

/// This test binary as a worker that plays `play`.
pub(crate) fn worker_command(play: &str) -> Command {
    let mut command = this_binary("worker::worker_entry");
    command.env(PLAY, play);
    command
}

/// One worker per group of nodes, named after the first of them.
pub(crate) fn workers(network: &Network, groups: &[Vec<usize>]) -> Vec<WorkerPlan> {
    let worker = |nodes: &Vec<usize>| WorkerPlan { name: network.nodes[nodes[0]].name.clone(), nodes: nodes.clone() };
    groups.iter().map(worker).collect()
}

/// Every node by itself.
pub(crate) fn singles(network: &Network) -> Vec<Vec<usize>> {
    (0..network.nodes.len()).map(|node| vec![node]).collect()
}

/// Short deadlines, and no output of children among that of the tests.
pub(crate) fn settings() -> Settings {
    Settings { deadline: Duration::from_secs(20), forward_output: false, ..Settings::default() }
}

/// The same for each way to wake processes.
pub(crate) fn all_ways() -> [Settings; 2] {
    [Wake::Futex, Wake::Events].map(|wake| Settings { wake, ..settings() })
}

/// Prepares and spawns a run whose workers play `play`.
pub(crate) fn launch(
    name: &str,
    network: &Network,
    groups: &[Vec<usize>],
    steps: u64,
    settings: Settings,
    play: &str,
) -> Conductor {
    launch_by(name, network, groups, steps, settings, || worker_command(play))
}

/// As [`launch`], with workers that are started by these commands.
pub(crate) fn launch_by(
    name: &str,
    network: &Network,
    groups: &[Vec<usize>],
    steps: u64,
    settings: Settings,
    command: impl Fn() -> Command,
) -> Conductor {
    let plan = Plan::new(name, network.clone(), 1_000_000, steps, workers(network, groups)).unwrap();
    let mut conductor =
        Conductor::new(RunDirectory::create(&processes::run_name(name, settings.wake)).unwrap(), plan, settings)
            .unwrap();
    for worker in 0..groups.len() {
        conductor.spawn(worker, command(), None).unwrap();
    }
    conductor
}

/// As [`launch`], and waits until all are connected.
pub(crate) fn start(
    name: &str,
    network: &Network,
    groups: &[Vec<usize>],
    steps: u64,
    settings: Settings,
    play: &str,
) -> Conductor {
    let mut conductor = launch(name, network, groups, steps, settings, play);
    conductor.wait_ready(Duration::from_secs(60)).unwrap();
    conductor
}

/// Steps until something goes wrong, and returns that.
pub(crate) fn step_to_error(conductor: &mut Conductor) -> RunError {
    loop {
        if let Err(error) = conductor.step() {
            return error;
        }
    }
}

/// What a run may leave behind, to be looked for after its end.
pub(crate) struct Traces {
    run: String,
    directory: PathBuf,
    pids: Vec<u32>,
}

impl Traces {
    pub(crate) fn of(conductor: &Conductor) -> Self {
        let pids = (0..conductor.plan().workers.len()).filter_map(|worker| conductor.pid(worker)).collect();
        let directory = conductor.directory();
        Self { run: directory.name().into(), directory: directory.path().into(), pids }
    }

    /// Fails if a process or a file of the run is left.
    pub(crate) fn assert_none(&self) {
        let alive: Vec<_> = self.pids.iter().filter(|pid| Path::new(&format!("/proc/{pid}")).exists()).collect();
        assert!(alive.is_empty(), "processes left: {alive:?}");
        assert!(!self.directory.exists(), "{:?} is left", self.directory);
        let files = shared_files(&self.run);
        assert!(files.is_empty(), "files left: {files:?}");
    }
}

/// The shared memory of a run.
pub(crate) fn shared_files(run: &str) -> Vec<PathBuf> {
    let user = rustix::process::getuid().as_raw();
    let prefix = format!("phalanx{user}-{run}_");
    let files = fs::read_dir("/dev/shm").unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(&prefix)).collect()
}

/// Waits until `condition` holds, and fails if it takes more than ten seconds.
pub(crate) fn eventually(what: &str, condition: impl Fn() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < Duration::from_secs(10), "{what}: not within 10 s");
        std::thread::sleep(Duration::from_millis(2));
    }
}
