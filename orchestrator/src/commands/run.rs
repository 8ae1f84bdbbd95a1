//! `phalanx run`.

use std::path::{Path, PathBuf};

use formation::wiring::Assembly;
use lockstep::{RunError, allowed_cores};
use serde_json::{Value, json};

use super::check::summary_line;
use super::select::assemble;
use crate::cli::RunArgs;
use crate::engine::{Placement, Stop};
use crate::failure::Failure;
use crate::log::Log;
use crate::run::{Options, Outcome, run as carry_out};
use crate::swap::Swap;
use crate::verdict::Verdict;

pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    let assembly = assemble(&args.scenario)?;
    let log = (!args.no_log).then(|| args.out.clone().unwrap_or_else(|| default_log(&assembly)));
    let swaps = parse_swaps(&args.swap, &assembly, args.placement)?;
    let options = Options {
        swaps,
        placement: args.placement,
        core: core(&args.pin, args.placement)?,
        progress: !args.quiet,
        log: log.clone(),
    };
    if !args.quiet {
        announce(&assembly, args, log.as_deref());
    }
    let outcome = carry_out(&assembly, &options, end_on_signals)?;
    let verdict = match &log {
        Some(path) => judge(&assembly, path)?,
        None => None,
    };
    if args.json {
        println!("{}", to_json(&assembly, &outcome, verdict.as_ref()));
    } else {
        show(&assembly, &outcome, verdict.as_ref());
    }
    conclude(outcome, verdict.as_ref())
}

/// The metrics; none of a log that holds no complete step.
fn judge(assembly: &Assembly, path: &Path) -> Result<Option<Verdict>, Failure> {
    let log = Log::open(path)?;
    if log.steps().is_empty() {
        return Ok(None);
    }
    Ok(Some(Verdict::of(&assembly.scenario, &log)?))
}

fn conclude(outcome: Outcome, verdict: Option<&Verdict>) -> Result<(), Failure> {
    match outcome.stopped {
        Some(RunError::Interrupted { .. }) => Err(Failure::Interrupted),
        Some(error) => Err(Failure::Run(error)),
        None if verdict.is_some_and(|verdict| !verdict.ok()) => Err(Failure::Missed),
        None => Ok(()),
    }
}

fn default_log(assembly: &Assembly) -> PathBuf {
    let scenario = &assembly.scenario;
    let variant = if scenario.variant.is_empty() { String::new() } else { format!("-{}", scenario.variant) };
    Path::new("runs").join(format!("{}{variant}.mcap", scenario.name))
}

fn parse_swaps(texts: &[String], assembly: &Assembly, placement: Placement) -> Result<Vec<Swap>, Failure> {
    if placement == Placement::Single && !texts.is_empty() {
        return Err(Failure::Usage("--swap needs processes; leave out --placement single".into()));
    }
    let names: Vec<&str> = assembly.network.nodes.iter().map(|node| node.name.as_str()).collect();
    texts.iter().map(|text| Swap::parse(text, &names).map_err(Failure::Usage)).collect()
}

/// The core that all processes share, if any.
fn core(pin: &str, placement: Placement) -> Result<Option<usize>, Failure> {
    if placement == Placement::Single {
        return Ok(None);
    }
    let cores = allowed_cores().map_err(Failure::system("ask for the cores of this machine"))?;
    match pin {
        "none" => Ok(None),
        "auto" => Ok(cores.last().copied()),
        number => match number.parse() {
            Ok(core) if cores.contains(&core) => Ok(Some(core)),
            _ => {
                let list: Vec<String> = cores.iter().map(usize::to_string).collect();
                let cores = list.join(", ");
                Err(Failure::Usage(format!("--pin {number}: expected auto, none or one of the cores {cores}")))
            }
        },
    }
}

fn announce(assembly: &Assembly, args: &RunArgs, log: Option<&Path>) {
    let scenario = &assembly.scenario;
    let timing = scenario.context.timing;
    let processes = match args.placement {
        Placement::Single => "1 process".to_string(),
        Placement::Processes => format!("{} processes", assembly.network.nodes.len() + 1),
        Placement::Agents => "a process per agent".to_string(),
    };
    eprintln!(
        "{} {}: {}; {} agents, {processes}, {} s in steps of {} s",
        scenario.name,
        scenario.variant,
        scenario.title,
        scenario.context.agents.len(),
        timing.duration,
        timing.dt
    );
    if let Some(path) = log.filter(|path| path.exists()) {
        eprintln!("replacing the log of an earlier run, {}", path.display());
    }
}

/// Ctrl-C, SIGTERM and SIGHUP end the run in order.
fn end_on_signals(stop: Stop) {
    // A second handler in one process cannot be set; a program that embeds this one has set its own then.
    let _ = ctrlc::set_handler(move || stop.request());
}

fn show(assembly: &Assembly, outcome: &Outcome, verdict: Option<&Verdict>) {
    if let Some(verdict) = verdict.filter(|verdict| !verdict.rows.is_empty()) {
        println!("{}", verdict.table());
        println!("{}", summary_line(verdict, &assembly.scenario.overrides));
    }
    println!(
        "{} steps in {:.2} s: {:.0} steps/s, {:.1} x real time, {} processes",
        outcome.steps,
        outcome.wall,
        outcome.steps_per_second(),
        outcome.simulated / outcome.wall.max(1e-9),
        outcome.processes
    );
    if let Some(log) = &outcome.log {
        let path = log.path.display();
        println!(
            "log: {path} ({:.1} MB, {} messages, sha256 {})",
            log.bytes as f64 / 1e6,
            log.messages,
            &log.sha256[..16]
        );
        println!(
            "\nNext: `phalanx info {path}` shows what is in it, `phalanx check {path}` computes this table again,"
        );
        println!("and Foxglove, Lichtblick, Rerun or PlotJuggler open the file as it is.");
    }
}

fn to_json(assembly: &Assembly, outcome: &Outcome, verdict: Option<&Verdict>) -> Value {
    let scenario = &assembly.scenario;
    json!({
        "scenario": scenario.name,
        "variant": scenario.variant,
        "steps": outcome.steps,
        "sim_s": outcome.simulated,
        "wall_s": outcome.wall,
        "steps_per_s": outcome.steps_per_second(),
        "processes": outcome.processes,
        "log": outcome.log.as_ref().map(|log| log.path.display().to_string()),
        "sha256": outcome.log.as_ref().map(|log| log.sha256.clone()),
        "metrics": verdict.map(Verdict::to_json),
        "ok": outcome.stopped.is_none() && verdict.is_none_or(Verdict::ok),
    })
}
