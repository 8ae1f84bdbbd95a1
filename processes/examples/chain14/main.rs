//! Measures the steps per second of a small formation: in 14 processes and a conductor, all on one core, and in one process.
//!
//! `STEPS` sets how many steps are measured (2000), `CORE` which core is used (the last one that is allowed). Prints
//! `RESULT|<name>|<processes>|<steps per second>|<digest>` for both.

mod chain;

use std::env;
use std::error::Error;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use chain::{AGENTS, NODES};
use lockstep::{Local, Plan, WorkerPlan};
use processes::{Conductor, RunDirectory, Settings};

const WARM_UP: u64 = 200;

fn main() -> ExitCode {
    // The conductor starts this very program as its workers.
    if env::var_os("PHALANX_WORKER").is_some() {
        return processes::serve(|_, nodes| Ok(nodes.iter().map(|&node| participant(node)).collect()));
    }
    match measure() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn participant(node: usize) -> Box<dyn lockstep::Participant> {
    chain::participant(AGENTS, node)
}

fn measure() -> Result<(), Box<dyn Error>> {
    let steps: u64 = env::var("STEPS").map_or(Ok(2000), |text| text.parse())?;
    let core = match env::var("CORE") {
        Ok(text) => text.parse()?,
        Err(_) => *processes::allowed_cores()?.last().ok_or("no core is allowed")?,
    };
    processes::pin_to_core(core)?;
    in_processes(steps, core)?;
    in_one_process(steps)
}

fn in_processes(steps: u64, core: usize) -> Result<(), Box<dyn Error>> {
    let network = chain::network(AGENTS);
    let worker = |(index, node): (usize, &lockstep::Node)| WorkerPlan { name: node.name.clone(), nodes: vec![index] };
    let workers: Vec<WorkerPlan> = network.nodes.iter().enumerate().map(worker).collect();
    let processes = workers.len() + 1;
    let plan = Plan::new("chain14", network, 1_000_000, WARM_UP + steps, workers)?;
    let mut conductor = Conductor::new(RunDirectory::create("chain14")?, plan, Settings::default())?;
    for worker in 0..NODES {
        conductor.spawn(worker, Command::new(env::current_exe()?), Some(core))?;
    }
    conductor.wait_ready(Duration::from_secs(30))?;
    let (rate, last) = time(steps, || conductor.step())?;
    let digest = chain::digest(AGENTS, conductor.store(), last);
    conductor.finish()?;
    println!("RESULT|phalanx-processes|{processes}|{rate:.0}|{digest}");
    Ok(())
}

fn in_one_process(steps: u64) -> Result<(), Box<dyn Error>> {
    let mut local = Local::new(chain::network(AGENTS), (0..NODES).map(participant).collect(), 1e-3)?;
    let (rate, last) = time(steps, || local.step())?;
    println!("RESULT|phalanx-single|1|{rate:.0}|{}", chain::digest(AGENTS, local.store(), last));
    Ok(())
}

/// Steps per second after the warm-up, and the number of the last step.
fn time<E>(steps: u64, mut step: impl FnMut() -> Result<u64, E>) -> Result<(f64, u64), E> {
    let mut last = 0;
    for _ in 0..WARM_UP {
        last = step()?;
    }
    let start = Instant::now();
    for _ in 0..steps {
        last = step()?;
    }
    Ok((steps as f64 / start.elapsed().as_secs_f64(), last))
}
