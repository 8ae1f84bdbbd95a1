//! `phalanx conform`.

use std::path::{Path, PathBuf};

use clap::Args;
use formation::scenario::Selection;
use formation::wiring::Assembly;
use serde_json::json;

use super::arguments::{ScenarioArgs, wait_time};
use super::select::{assemble, from_head};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::run::leftovers::Scratch;
use crate::run::pinning::Pin;
use crate::run::placement::Placement;
use crate::run::swap::{node_called, program_problem};
use crate::run::{Options, run};
use crate::trial::conform::{ConformanceTest, Range, Report, Verdict, conform as try_all, supervise as watch};

#[derive(Debug, Args)]
pub(crate) struct ConformArgs {
    /// The participant whose place the program is to take: controller.3, observer_2, plant
    pub(crate) node: String,
    /// Scenario to take the inputs from: a shipped one (see `phalanx list`) or a file
    #[arg(long, default_value = "triangle", conflicts_with = "log")]
    pub(crate) scenario: String,
    /// Variant of the scenario
    #[arg(long, conflicts_with = "log")]
    pub(crate) variant: Option<String>,
    /// Change a field of the scenario: --set NAME=VALUE; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", conflicts_with = "log")]
    pub(crate) set: Vec<String>,
    /// The same for a field that only some variants have: in the others it does nothing
    #[arg(long, value_name = "NAME=VALUE", conflicts_with = "log")]
    pub(crate) set_if_present: Vec<String>,
    /// Take the inputs from this log instead
    #[arg(long, value_name = "LOG.mcap")]
    pub(crate) log: Option<PathBuf>,
    /// Steps of each trial, at most; fewer if the scenario has fewer
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(10..=100_000))]
    pub(crate) steps: u64,
    /// How long the program may take to start, for a step, and to end, in s
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = wait_time)]
    pub(crate) patience: f64,
    /// An interval for all numbers of an output: --range input=-20..20; may be repeated
    #[arg(long, value_name = "FIELD=LOW..HIGH", allow_hyphen_values = true)]
    pub(crate) range: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// The program with its arguments, behind --
    #[arg(last = true, required = true, value_name = "COMMAND")]
    pub(crate) command: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct SuperviseArgs {
    /// Where to write how the program ended
    pub(crate) status: PathBuf,
    /// The program with its arguments
    #[arg(last = true, required = true)]
    pub(crate) command: Vec<std::ffi::OsString>,
}

pub(crate) fn conform(catalog: &Catalog, args: &ConformArgs) -> Result<(), Failure> {
    let assembly = short_scenario(catalog, args)?;
    let names: Vec<&str> = assembly.network.nodes.iter().map(|node| node.name.as_str()).collect();
    let name = node_called(&args.node, &names).map_err(|reason| Failure::Usage(format!("{}: {reason}", args.node)))?;
    let node = names.iter().position(|other| *other == name).unwrap_or_default();
    let ranges = args.range.iter().map(|text| range(text, &assembly, node)).collect::<Result<_, _>>()?;
    if let Some(problem) = args.command.first().and_then(|program| program_problem(program, Path::new(""))) {
        return Err(Failure::Usage(format!("cannot start {problem}")));
    }
    let recorded = Recorded::of(args, &assembly)?;
    let affinity = Pin::Auto.take()?;
    let report = try_all(&ConformanceTest {
        assembly: &assembly,
        log: &recorded.path,
        node,
        words: &args.command,
        patience: lockstep::duration(args.patience),
        ranges,
        core: affinity.core,
    })?;
    if args.json {
        println!("{}", to_json(&name, &report));
    } else {
        print!("{}", text_of(&name, &report));
    }
    if report.ok() { Ok(()) } else { Err(Failure::Nonconforming) }
}

pub(crate) fn supervise(args: &SuperviseArgs) -> std::process::ExitCode {
    watch(&args.status, &args.command)
}

/// The scenario of the log, or the one that is named, as long as the program is to be tried.
fn short_scenario(catalog: &Catalog, args: &ConformArgs) -> Result<Assembly, Failure> {
    let whole = match &args.log {
        Some(log) => from_head(catalog, log, &Selection::default())?,
        None => assemble(catalog, &scenario_args(args, None))?,
    };
    let timing = whole.scenario.context.timing;
    let periods = (args.steps - 1).min(timing.periods());
    let duration = timing.period().time(periods);
    match &args.log {
        Some(log) => {
            let overrides = vec![format!("timing.duration={duration}")];
            from_head(catalog, log, &Selection { overrides, ..Selection::default() })
        }
        None => assemble(catalog, &scenario_args(args, Some(duration.to_string()))),
    }
}

fn scenario_args(args: &ConformArgs, duration: Option<String>) -> ScenarioArgs {
    ScenarioArgs {
        scenario: args.scenario.clone(),
        variant: args.variant.clone(),
        set: args.set.clone(),
        set_if_present: args.set_if_present.clone(),
        duration,
        ..ScenarioArgs::default()
    }
}

/// `input=-20..20`.
fn range(text: &str, assembly: &Assembly, node: usize) -> Result<Range, Failure> {
    let wrong = |reason: String| Failure::Usage(format!("--range {text}: {reason}"));
    let expected = || wrong("expected FIELD=LOW..HIGH, such as input=-20..20".into());
    let (field, bounds) = text.split_once('=').ok_or_else(expected)?;
    let (low, high) = bounds.split_once("..").ok_or_else(expected)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| expected());
    let mut channels = assembly.network.nodes[node].outputs.iter();
    if !channels.any(|channel| assembly.network.channels[channel.0].layout.find(field.trim()).is_some()) {
        return Err(wrong(format!("{} publishes no such field", assembly.network.nodes[node].name)));
    }
    Ok(Range { field: field.trim().into(), low: number(low)?, high: number(high)? })
}

/// The log with the inputs.
struct Recorded {
    path: PathBuf,
    /// Where it is if it was recorded for this trial only.
    _folder: Option<Scratch>,
}

impl Recorded {
    fn of(args: &ConformArgs, assembly: &Assembly) -> Result<Self, Failure> {
        if let Some(log) = &args.log {
            return Ok(Self { path: log.clone(), _folder: None });
        }
        let folder = Scratch::create()?;
        let path = folder.path().join("inputs.mcap");
        let options = Options { stand_ins: true, ..Options::new(Placement::Single, Some(path.clone())) };
        let outcome = run(assembly, &options, |_| {})?;
        outcome.ending.into_result()?;
        Ok(Self { path, _folder: Some(folder) })
    }
}

fn text_of(node: &str, report: &Report) -> String {
    let mut text = String::new();
    for check in &report.checks {
        text.push_str(&format!(
            "{}  {:<9} {}: {}\n",
            check.verdict.word(),
            check.name,
            check.requirement,
            check.finding
        ));
        if !check.advice.is_empty() {
            text.push_str(&format!("                what to do: {}\n", check.advice));
        }
    }
    let broken = report.checks.iter().filter(|check| check.verdict == Verdict::Fail).count();
    text.push_str(&match report.ok() {
        true => format!("It can take the place of {node}.\n"),
        false if broken == 0 => {
            format!("Whether it can take the place of {node} is not known: not all points were tried.\n")
        }
        false => {
            format!("It cannot take the place of {node}: {broken} of {} points are broken.\n", report.checks.len())
        }
    });
    text
}

fn to_json(node: &str, report: &Report) -> serde_json::Value {
    let checks = report.checks.iter().map(|check| {
        let verdict = check.verdict.word().to_lowercase().replace("----", "untried");
        json!({
            "name": check.name, "verdict": verdict, "demand": check.requirement, "finding": check.finding, "advice": check.advice,
        })
    });
    json!({"node": node, "ok": report.ok(), "points": checks.collect::<Vec<_>>()})
}
