//! Measures the engine beside a yardstick, all through its public interface. `cargo bench` prints the table.
//!
//! The yardstick stands in the same table and is measured in the same run, since the cost of a switch between processes
//! differs by a factor of two between machines, and between hours of one machine. Every figure is the median of
//! [`ROUNDS`] rounds in which all lines take turns.

#[path = "../../lockstep/examples/chain14/chain.rs"]
mod chain;
mod measure;
mod table;
mod yardstick;

use std::env;
use std::error::Error;
use std::process::ExitCode;

use measure::{Recording, processes, single};
use table::{Bound, Row, table};

/// Rounds of every measurement.
pub const ROUNDS: usize = 3;

/// The whole program: measures and prints, or is one of the processes that are measured.
pub fn main() -> ExitCode {
    if env::var_os("PHALANX_WORKER").is_some() {
        return lockstep::serve(|plan, nodes| {
            let agents = (plan.network.nodes.len() - 2) / 2;
            Ok(nodes.iter().map(|&node| chain::participant(agents, node)).collect())
        });
    }
    let result = yardstick::serve().map_err(Into::into).and_then(|served| if served { Ok(()) } else { run() });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let core = *lockstep::allowed_cores()?.last().ok_or("no core is allowed")?;
    let steps: u64 = env::var("STEPS").map_or(Ok(10_000), |text| text.parse())?;
    let mut figures: Vec<Vec<f64>> = vec![Vec::new(); 12];
    for _ in 0..ROUNDS {
        let barrier = |agents: usize, steps: u64| {
            on_core(core, move || Ok(yardstick::measure(&[1, 1, agents, agents], steps as u32)?))
        };
        let crowd = processes(100, steps / 20, core, Recording::On)?;
        let round = [
            barrier(6, steps)?,
            processes(6, steps, core, Recording::Off)?.step,
            processes(6, steps, core, Recording::On)?.step,
            on_core(core, || single(steps * 20, Recording::Off))?,
            single(steps * 20, Recording::On)?,
            barrier(50, steps / 10)?,
            processes(50, steps / 10, core, Recording::On)?.step,
            barrier(100, steps / 20)?,
            crowd.step,
            crowd.start,
            crowd.end,
            crowd.memory,
        ];
        figures.iter_mut().zip(round).for_each(|(figures, figure)| figures.push(figure));
    }
    let median = |index: usize| {
        let mut sorted = figures[index].clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    let [barrier, off, on, single_off, single_on] = [0, 1, 2, 3, 4].map(median);
    let [barrier_50, on_50, barrier_100, on_100, start, end, memory] = [5, 6, 7, 8, 9, 10, 11].map(median);
    let grown = |seconds: f64, agents: usize| {
        let per_process = seconds / chain::nodes(agents) as f64;
        Bound::Growth(per_process / (on / chain::NODES as f64), 1.3)
    };
    let rows = [
        Row::new("chain14, 15 processes", off, Some(barrier), Bound::Times(1.2)),
        Row::new("chain14, 15 processes, recording", on, Some(barrier), Bound::Times(1.6)),
        Row::new("chain14, 15 processes, recording", on, None, Bound::Rate(20_000.0)),
        Row::new("chain14, single", single_off, None, Bound::Rate(1_000_000.0)),
        Row::new("chain14, single, recording", single_on, None, Bound::Rate(150_000.0)),
        Row::new("50 agents, 103 processes, recording", on_50, Some(barrier_50), grown(on_50, 50)),
        Row::new("100 agents, 203 processes, recording", on_100, Some(barrier_100), grown(on_100, 100)),
        Row::new("start of 203 processes", start, None, Bound::Seconds(5.0)),
        Row::new("end of 203 processes", end, None, Bound::Seconds(2.0)),
        Row::new("largest private memory of a process", memory, None, Bound::Bytes(15e6)),
    ];
    println!("{}", table(&rows));
    Ok(())
}

/// Does `work` in a thread of its own that stays on a core, with all that it starts.
fn on_core<R: Send>(core: usize, work: impl FnOnce() -> Result<R, Box<dyn Error>> + Send) -> Result<R, Box<dyn Error>> {
    in_thread(move || {
        lockstep::pin_to_core(core)?;
        work()
    })
}

/// Does `work` in a thread of its own that stays off a core, with all that it starts.
fn beside_core<R: Send>(
    core: usize,
    work: impl FnOnce() -> Result<R, Box<dyn Error>> + Send,
) -> Result<R, Box<dyn Error>> {
    in_thread(move || {
        lockstep::keep_off_core(core)?;
        work()
    })
}

fn in_thread<R: Send>(work: impl FnOnce() -> Result<R, Box<dyn Error>> + Send) -> Result<R, Box<dyn Error>> {
    let work = move || work().map_err(|error| error.to_string());
    let result = std::thread::scope(|scope| scope.spawn(work).join());
    Ok(result.map_err(|_| "a measurement panicked")??)
}
