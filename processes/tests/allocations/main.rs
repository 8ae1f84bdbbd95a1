//! No step takes memory once a run is warm: not of a run in one process, not of a worker, not of the conductor.
//!
//! This program is the run and its workers, so it has no test harness, and it counts what the thread that steps allocates.

#[path = "../../examples/chain14/chain.rs"]
mod chain;
mod counter;

use std::env;
use std::process::{Command, ExitCode};
use std::time::Duration;

use chain::{AGENTS, NODES};
use counter::allocations;
use lockstep::{Fault, Io, Local, Participant, Plan, Step, WorkerPlan};
use processes::{Conductor, RunDirectory, Settings};

/// Steps after which a run is warm.
const WARM: u64 = 300;
/// Steps of a run.
const STEPS: u64 = 3000;
/// Steps at the end that are not counted.
const ENDING: u64 = 20;

/// A participant whose process must not allocate.
struct Watched {
    inner: Box<dyn Participant>,
    warm: u64,
}

impl Participant for Watched {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        if step.index == WARM {
            self.warm = allocations();
        }
        // All but the last step, whose end is the end of the process.
        let count = allocations() - self.warm;
        if step.index > WARM && count > 0 {
            return Err(Fault(format!("{count} allocations in {} steps", step.index - WARM)));
        }
        self.inner.step(step, io)
    }
}

fn main() -> ExitCode {
    if env::var_os("PHALANX_WORKER").is_some() {
        let watched = |&node: &usize| {
            let inner = chain::participant(AGENTS, node);
            Box::new(Watched { inner, warm: 0 }) as Box<dyn Participant>
        };
        return processes::serve(|_, nodes| Ok(nodes.iter().map(watched).collect()));
    }
    assert_ne!(allocations(), 0, "nothing is counted");
    let (one, many) = (in_one_process(), in_processes());
    assert_eq!(one, many, "the results differ");
    println!("no allocations in {} warm steps", STEPS - ENDING - WARM);
    ExitCode::SUCCESS
}

fn in_one_process() -> String {
    let participants = (0..NODES).map(|node| chain::participant(AGENTS, node)).collect();
    let mut local = Local::new(chain::network(AGENTS), participants, 0.001).unwrap();
    let count = count(|| local.step().map(drop).map_err(|error| format!("{error:?}")));
    assert_eq!(count, 0, "allocations of a run in one process");
    chain::digest(AGENTS, local.store(), STEPS - 1)
}

fn in_processes() -> String {
    let network = chain::network(AGENTS);
    let worker = |(index, node): (usize, &lockstep::Node)| WorkerPlan { name: node.name.clone(), nodes: vec![index] };
    let workers: Vec<WorkerPlan> = network.nodes.iter().enumerate().map(worker).collect();
    let plan = Plan::new("allocations", network, 1_000_000, STEPS, workers).unwrap();
    let directory = RunDirectory::create("allocations").unwrap();
    let mut conductor = Conductor::new(directory, plan, Settings::default()).unwrap();
    for worker in 0..NODES {
        conductor.spawn(worker, Command::new(env::current_exe().unwrap()), None).unwrap();
    }
    conductor.wait_ready(Duration::from_secs(60)).unwrap();
    let count = count(|| conductor.step().map(drop).map_err(|error| error.to_string()));
    assert_eq!(count, 0, "allocations of the conductor");
    let digest = chain::digest(AGENTS, conductor.store(), STEPS - 1);
    conductor.finish().unwrap();
    digest
}

/// Runs to the end; the allocations of this thread from when it was warm to when the first worker may have ended: workers are
/// a few steps ahead of the conductor, which then looks who is dead.
fn count(mut step: impl FnMut() -> Result<(), String>) -> u64 {
    let (mut warm, mut end) = (0, 0);
    for index in 0..STEPS {
        if index == WARM {
            warm = allocations();
        }
        if index == STEPS - ENDING {
            end = allocations();
        }
        step().unwrap_or_else(|error| panic!("step {index}: {error}"));
    }
    end - warm
}
