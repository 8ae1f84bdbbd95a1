//! Measures the engine beside a yardstick, all through its public interface. `cargo bench` prints the table.
//!
//! The yardstick stands in the same table and is measured in the same run, since the cost of a switch between processes
//! differs by a factor of two between machines, and between hours of one machine. Every figure is the median of
//! [`ROUNDS`] rounds in which all lines take turns.

#[path = "../../processes/examples/chain14/chain.rs"]
mod chain;
mod links;
mod measure;
mod table;
mod vehicles;
mod yardstick;

use std::collections::BTreeMap;
use std::env;
use std::error::Error;
use std::process::ExitCode;

use lockstep::Wake;
use measure::{Recording, Taken, processes, processes_by, processes_on, single, uav};
use table::{Bound, Row, table};

/// Rounds of every measurement, unless `ROUNDS` says otherwise.
pub const ROUNDS: u64 = 3;

/// The whole program: measures and prints, or is one of the processes that are measured.
pub fn main() -> ExitCode {
    // A process of the drones is told so by an argument; all processes of runs have the variable.
    if env::args().nth(1).as_deref() == Some("participant") {
        return orchestrator::cli::main(&thesis::catalog(schemes::ROLES, schemes::SCENARIOS));
    }
    if env::var_os("PHALANX_WORKER").is_some() {
        return processes::serve(|plan, nodes| {
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

/// What is measured; all lines take turns.
const LINES: [Line; 21] = [
    Line("yardstick of 6 agents", |core, steps| yardstick(6, core, steps)),
    Line("6 agents", |core, steps| processes(6, steps, core, Recording::Off)),
    Line("6 agents, events", |core, steps| processes_by(Wake::Events, 6, steps, &[core], Recording::Off)),
    Line("6 agents, recording", |core, steps| processes(6, steps, core, Recording::On)),
    Line("6 agents on two cores, recording", |core, steps| processes_on(6, steps, &two(core)?, Recording::On)),
    Line("single", |core, steps| on_core(core, move || step(single(steps * 20, Recording::Off)?))),
    Line("single, recording", |_, steps| step(single(steps * 20, Recording::On)?)),
    Line("uav, recording", |_, steps| step(uav(steps)?)),
    Line("robot as code", |core, steps| on_core(core, move || step(vehicles::code(steps * 20)?))),
    Line("robot by equations", |core, steps| on_core(core, move || step(vehicles::equations(steps * 20)?))),
    Line("link", |core, steps| on_core(core, move || step(links::sample(steps)?))),
    Line("yardstick of 50 agents", |core, steps| yardstick(50, core, steps / 10)),
    Line("50 agents", |core, steps| processes(50, steps / 10, core, Recording::Off)),
    Line("50 agents on two cores", |core, steps| processes_on(50, steps / 10, &two(core)?, Recording::Off)),
    Line("50 agents, recording", |core, steps| processes(50, steps / 10, core, Recording::On)),
    Line("50 agents on two cores, recording", |core, steps| processes_on(50, steps / 10, &two(core)?, Recording::On)),
    Line("yardstick of 100 agents", |core, steps| yardstick(100, core, steps / 20)),
    Line("100 agents", |core, steps| processes(100, steps / 20, core, Recording::Off)),
    Line("100 agents on two cores", |core, steps| processes_on(100, steps / 20, &two(core)?, Recording::Off)),
    Line("100 agents, recording", |core, steps| processes(100, steps / 20, core, Recording::On)),
    Line("100 agents on two cores, recording", |core, steps| processes_on(100, steps / 20, &two(core)?, Recording::On)),
];

/// This core and another one, if there is one.
fn two(core: usize) -> Result<Vec<usize>, Box<dyn Error>> {
    let others = processes::allowed_cores()?.into_iter().filter(|&other| other != core);
    Ok(std::iter::once(core).chain(others).take(2).collect())
}

/// Its name, and how it is measured on a core in so many steps.
struct Line(&'static str, fn(usize, u64) -> Result<Taken, Box<dyn Error>>);

fn yardstick(agents: usize, core: usize, steps: u64) -> Result<Taken, Box<dyn Error>> {
    on_core(core, move || step(yardstick::measure(&[1, 1, agents, agents], steps as u32)?))
}

fn step(step: f64) -> Result<Taken, Box<dyn Error>> {
    Ok(Taken { step, ..Taken::default() })
}

fn run() -> Result<(), Box<dyn Error>> {
    let core = *processes::allowed_cores()?.last().ok_or("no core is allowed")?;
    let number = |name, default: u64| env::var(name).map_or(Ok(default), |text| text.parse());
    let (steps, rounds) = (number("STEPS", 10_000)?, number("ROUNDS", ROUNDS)?);
    // Cargo adds an option of its own; a word is a part of the names of the lines that are wanted.
    let wanted: Vec<String> = env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let is_wanted = |line: &&Line| wanted.is_empty() || wanted.iter().any(|part| line.0.contains(part.as_str()));
    let mut figures: BTreeMap<&str, Vec<Taken>> = BTreeMap::new();
    for _ in 0..rounds {
        for Line(name, measure) in LINES.iter().filter(is_wanted) {
            figures.entry(name).or_default().push(measure(core, steps)?);
        }
    }
    println!("{}", table(&rows(&Figures(figures))));
    Ok(())
}

/// What was measured in all rounds.
struct Figures(BTreeMap<&'static str, Vec<Taken>>);

impl Figures {
    /// The median of a figure of a line; `None` if the line was not wanted.
    fn median(&self, line: &str, figure: impl Fn(&Taken) -> f64) -> Option<f64> {
        let mut sorted: Vec<f64> = self.0.get(line)?.iter().map(figure).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }

    fn step(&self, line: &str) -> Option<f64> {
        self.median(line, |taken| taken.step)
    }
}

fn rows(figures: &Figures) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut row = |what, line, yardstick: Option<&str>, bound| {
        let yardstick = yardstick.map(|yardstick| figures.step(yardstick));
        if let Some(figure) = figures.step(line)
            && yardstick != Some(None)
        {
            rows.push(Row::new(what, figure, yardstick.flatten(), bound));
        }
    };
    let (small, on) = (Some("yardstick of 6 agents"), "6 agents, recording");
    row("chain14, 15 processes", "6 agents", small, Bound::Times(1.2));
    row("chain14, 15 processes, events", "6 agents, events", small, Bound::Times(2.5));
    row("chain14, 15 processes, recording", on, small, Bound::Times(1.6));
    row("chain14, 15 processes, recording", on, None, Bound::Rate(20_000.0));
    row("chain14, single", "single", None, Bound::Rate(1_000_000.0));
    row("chain14, single, recording", "single, recording", None, Bound::Rate(150_000.0));
    row("uav at 1 ms, 15 processes, recording", "uav, recording", None, Bound::Rate(15_000.0));
    row("a vehicle by equations, beside code", "robot by equations", Some("robot as code"), Bound::Times(3.0));
    row("a sample over a link", "link", None, Bound::Rate(20e6));
    row("chain14 on two cores, recording", "6 agents on two cores, recording", small, Bound::Times(1.6));
    // Per process, beside what one of 6 agents takes on the one core that is best for them.
    let crowds = [
        ("50 agents", 50, "yardstick of 50 agents"),
        ("50 agents on two cores", 50, "yardstick of 50 agents"),
        ("50 agents, recording", 50, "yardstick of 50 agents"),
        ("50 agents on two cores, recording", 50, "yardstick of 50 agents"),
        ("100 agents", 100, "yardstick of 100 agents"),
        ("100 agents on two cores", 100, "yardstick of 100 agents"),
        ("100 agents, recording", 100, "yardstick of 100 agents"),
        ("100 agents on two cores, recording", 100, "yardstick of 100 agents"),
    ];
    for (line, agents, yardstick) in crowds {
        let few = figures.step(if line.ends_with("recording") { on } else { "6 agents" });
        if let (Some(crowd), Some(few)) = (figures.step(line), few) {
            let growth = crowd / chain::nodes(agents) as f64 / (few / chain::NODES as f64);
            row(line, line, Some(yardstick), Bound::Growth(growth, 1.3));
        }
    }
    let crowd = "100 agents, recording";
    let whole = [
        ("start of 203 processes", figures.median(crowd, |taken| taken.start), Bound::Seconds(5.0)),
        ("end of 203 processes", figures.median(crowd, |taken| taken.end), Bound::Seconds(2.0)),
        ("largest private memory of a process", figures.median(crowd, |taken| taken.memory), Bound::Bytes(15e6)),
    ];
    let known = whole.into_iter().filter_map(|(what, figure, bound)| Some(Row::new(what, figure?, None, bound)));
    rows.extend(known);
    rows
}

/// Does `work` in a thread of its own that stays on a core, with all that it starts.
fn on_core<R: Send>(core: usize, work: impl FnOnce() -> Result<R, Box<dyn Error>> + Send) -> Result<R, Box<dyn Error>> {
    in_thread(move || {
        processes::pin_to_core(core)?;
        work()
    })
}

/// Does `work` in a thread of its own that stays off a core, with all that it starts.
fn beside_core<R: Send>(
    core: usize,
    work: impl FnOnce() -> Result<R, Box<dyn Error>> + Send,
) -> Result<R, Box<dyn Error>> {
    in_thread(move || {
        processes::keep_off_core(core)?;
        work()
    })
}

fn in_thread<R: Send>(work: impl FnOnce() -> Result<R, Box<dyn Error>> + Send) -> Result<R, Box<dyn Error>> {
    let work = move || work().map_err(|error| error.to_string());
    let result = std::thread::scope(|scope| scope.spawn(work).join());
    Ok(result.map_err(|_| "a measurement panicked")??)
}
