//! How long a death goes unnoticed: kills one of 14 processes with SIGKILL in the middle of a run, again and again, and prints
//! how long it took until the conductor had its error, with name, step and last lines.
//!
//! `ROUNDS` sets how often (100).

#[path = "chain14/chain.rs"]
#[allow(dead_code, reason = "shared with chain14, which uses more of it")]
mod chain;

use std::env;
use std::error::Error;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use chain::{AGENTS, NODES};
use lockstep::{Plan, WorkerPlan};
use processes::{Conductor, RunDirectory, RunError, Settings};
use rustix::process::{Pid, Signal, kill_process};

/// Steps before the blow.
const STEPS: u64 = 50;
/// What is promised.
const BOUND: Duration = Duration::from_millis(50);

fn main() -> ExitCode {
    // The conductor starts this very program as its workers.
    if env::var_os("PHALANX_WORKER").is_some() {
        return processes::serve(|_, nodes| Ok(nodes.iter().map(|&node| chain::participant(AGENTS, node)).collect()));
    }
    match measure() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn measure() -> Result<(), Box<dyn Error>> {
    let rounds: usize = env::var("ROUNDS").map_or(Ok(100), |text| text.parse())?;
    let mut times = (0..rounds).map(|round| unnoticed(round % NODES)).collect::<Result<Vec<Duration>, _>>()?;
    times.sort();
    let at = |part: f64| times[((times.len() - 1) as f64 * part).round() as usize].as_secs_f64() * 1e3;
    let in_time = times.iter().filter(|&&time| time <= BOUND).count();
    println!(
        "of {rounds} deaths, {in_time} were known within {} ms: 50 % within {:.2} ms, 90 % within {:.2} ms, all within {:.2} ms",
        BOUND.as_millis(),
        at(0.5),
        at(0.9),
        at(1.0)
    );
    Ok(())
}

/// From the signal to the error.
fn unnoticed(victim: usize) -> Result<Duration, Box<dyn Error>> {
    let network = chain::network(AGENTS);
    let worker = |(index, node): (usize, &lockstep::Node)| WorkerPlan { name: node.name.clone(), nodes: vec![index] };
    let workers: Vec<WorkerPlan> = network.nodes.iter().enumerate().map(worker).collect();
    let plan = Plan::new("death", network, 1_000_000, u64::MAX, workers)?;
    let mut conductor = Conductor::new(RunDirectory::create("death")?, plan, Settings::default())?;
    for worker in 0..NODES {
        conductor.spawn(worker, Command::new(env::current_exe()?), None)?;
    }
    conductor.wait_ready(Duration::from_secs(30))?;
    for _ in 0..STEPS {
        conductor.step()?;
    }
    let pid = conductor.pid(victim).and_then(|pid| Pid::from_raw(pid as i32)).ok_or("the process is not there")?;
    let start = Instant::now();
    kill_process(pid, Signal::KILL)?;
    let error = loop {
        match conductor.step() {
            Ok(_) => {}
            Err(error) => break error,
        }
    };
    let time = start.elapsed();
    conductor.finish()?;
    match error {
        RunError::Died { .. } => Ok(time),
        other => Err(other.into()),
    }
}
