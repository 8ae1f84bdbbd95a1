//! `phalanx verify`.

use std::path::Path;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use formation::wiring::Assembly;
use serde_json::json;

use super::arguments::ScenarioArgs;
use super::select::assemble;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::run::engine::cores;
use crate::run::leftovers::Scratch;
use crate::run::pinning::Pin;
use crate::run::placement::Placement;
use crate::run::players::{Player, difference};
use crate::run::stress::{Busy, Stress};
use crate::run::swap::{RobotSwap, Swap};
use crate::run::{Options, run};
use crate::terminal::plain;
use recording::{Comparison, Log, compare};

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Two logs to compare
    #[arg(num_args = 2, value_name = "LOG", required_unless_present = "scenario", conflicts_with = "scenario")]
    pub(crate) logs: Vec<PathBuf>,
    /// Run this scenario in many ways instead, and compare
    #[arg(long)]
    pub(crate) scenario: Option<String>,
    /// Variant to run
    #[arg(long, requires = "scenario")]
    pub(crate) variant: Option<String>,
    /// Change a field of the scenario: --set NAME=VALUE; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", requires = "scenario")]
    pub(crate) set: Vec<String>,
    /// The same for a field that only some variants have: in the others it does nothing
    #[arg(long, value_name = "NAME=VALUE", requires = "scenario")]
    pub(crate) set_if_present: Vec<String>,
    /// Length of each run in s
    #[arg(long, value_name = "SECONDS", requires = "scenario")]
    pub(crate) duration: Option<String>,
    /// Placements to run, or `all`
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "all", requires = "scenario")]
    pub(crate) placements: Vec<String>,
    /// How often each way is run
    #[arg(long, default_value_t = 1, requires = "scenario")]
    pub(crate) repeat: u64,
    /// Disturb every run: random delays in the participants, other orders and priorities, busy cores
    #[arg(long, requires = "scenario")]
    pub(crate) stress: bool,
    /// Decides on the disturbances
    #[arg(long, default_value_t = 1, requires = "stress")]
    pub(crate) seed: u64,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn verify(catalog: &Catalog, args: &VerifyArgs) -> Result<(), Failure> {
    match (&args.scenario, args.logs.as_slice()) {
        (Some(scenario), _) => verify_scenario(catalog, scenario, args),
        (None, [first, second]) => {
            let comparison = compare_files(first, second)?;
            if args.json {
                println!("{}", to_json(&comparison));
            } else {
                println!("{}", sentence(&comparison));
            }
            conclude(matches!(comparison.samples, Comparison::Equal { .. }))
        }
        (None, _) => Err(Failure::Usage("name two logs, or a scenario with --scenario".into())),
    }
}

fn conclude(equal: bool) -> Result<(), Failure> {
    if equal { Ok(()) } else { Err(Failure::Different) }
}

/// Two logs side by side: their samples, and what played in them if that differs.
struct Compared {
    samples: Comparison,
    cast: Option<String>,
}

fn compare_files(first: &Path, second: &Path) -> Result<Compared, Failure> {
    let (a, b) = (Log::outline(first)?, Log::outline(second)?);
    if let Some(log) = [&a, &b].into_iter().find(|log| log.steps().is_empty()) {
        let path = log.path().display();
        return Err(Failure::Usage(format!("{path} holds no complete step; there is nothing to compare")));
    }
    let [ours, theirs] = [&a, &b].map(|log| log.players().iter().map(Player::read).collect::<Vec<_>>());
    Ok(Compared { samples: compare(&a, &b)?, cast: difference(&ours, &theirs) })
}

fn sentence(compared: &Compared) -> String {
    let samples = match &compared.samples {
        Comparison::Equal { numbers } => format!("equal: all {numbers} numbers, bit by bit"),
        Comparison::Unlike(reason) => format!("different: {}", plain(reason)),
        Comparison::Different(difference) => format!("different: {}", plain(&difference.to_string())),
    };
    match (&compared.cast, &compared.samples) {
        (None, _) => samples,
        (Some(cast), Comparison::Equal { .. }) => format!("{samples}; only the cast differs: {cast}"),
        (Some(cast), _) => format!("{samples}; the cast differs, too: {cast}"),
    }
}

fn to_json(compared: &Compared) -> serde_json::Value {
    let mut summary = match &compared.samples {
        Comparison::Equal { numbers } => json!({"equal": true, "numbers": numbers}),
        Comparison::Unlike(reason) => json!({"equal": false, "reason": reason}),
        Comparison::Different(difference) => json!({
            "equal": false, "step": difference.step, "time": difference.time_ns as f64 / 1e9,
            "topic": difference.topic, "field": difference.field, "values": difference.values,
            "ulps": difference.ulps(), "differing": difference.differing, "numbers": difference.numbers,
        }),
    };
    summary["cast"] = json!(compared.cast);
    summary
}

/// One way to run a scenario.
struct Way {
    name: String,
    options: Options,
}

fn verify_scenario(catalog: &Catalog, scenario: &str, args: &VerifyArgs) -> Result<(), Failure> {
    let args_of_scenario = ScenarioArgs {
        scenario: scenario.into(),
        variant: args.variant.clone(),
        set: args.set.clone(),
        set_if_present: args.set_if_present.clone(),
        duration: args.duration.clone(),
        ..ScenarioArgs::default()
    };
    let assembly = assemble(catalog, &args_of_scenario)?;
    let swaps = Swap::collect(&assembly, &[])?;
    if let Some(robot) = swaps.iter().find(|swap| swap.robot().is_some_and(RobotSwap::is_free)) {
        return Err(Failure::Usage(format!(
            "{scenario}: {} is played by {robot}, for which time passes by itself, so that no two runs are equal; verify it with \
             another player in [swap], or with --set swap={{}}",
            robot.node
        )));
    }
    let folder = Scratch::create()?;
    let reference = folder.path().join("reference.mcap");
    let basis = basis(&swaps);
    let expected = record(&assembly, &options(&swaps, basis, Some(reference.clone())))?;
    let ways = ways(&assembly, args, &folder, &swaps)?;
    let names = ways.iter().map(|way| way.name.as_str()).chain([basis.name()]);
    let width = names.map(|name| name.chars().count()).max().unwrap_or(0);
    if !args.json {
        println!("{:<width$}  sha256 {}  reference", basis.name(), &expected[..16]);
    }
    let busy = if args.stress { Busy::start(cores()?.len()) } else { Busy::start(0) };
    let mut different = Vec::new();
    for way in &ways {
        let digest = record(&assembly, &way.options)?;
        let equal = digest == expected;
        if !args.json {
            println!("{:<width$}  sha256 {}  {}", way.name, &digest[..16], if equal { "equal" } else { "DIFFERENT" });
        }
        if let Some(log) = way.options.log.as_deref().filter(|_| !equal) {
            let finding = sentence(&compare_files(&reference, log)?);
            if !args.json {
                println!("    {finding}");
            }
            different.push(json!({"run": way.name, "sha256": digest, "finding": finding}));
        }
    }
    drop(busy);
    if args.json {
        let equal = different.is_empty();
        println!("{}", json!({"equal": equal, "runs": ways.len() + 1, "sha256": expected, "different": different}));
    } else if different.is_empty() {
        println!("All {} runs are equal, byte for byte.", ways.len() + 1);
    } else {
        println!("{} of {} runs differ from the reference.", different.len(), ways.len() + 1);
    }
    conclude(different.is_empty())
}

/// The placement of the reference: one process, unless a participant is played by something that needs its own.
fn basis(swaps: &[Swap]) -> Placement {
    let needs_process = |swap: &Swap| swap.robot().is_none();
    if swaps.iter().any(needs_process) { Placement::Processes } else { Placement::Single }
}

/// A run with these swaps; in one process, the laboratory does what emulators would do.
fn options(swaps: &[Swap], placement: Placement, log: Option<PathBuf>) -> Options {
    let swaps = if placement == Placement::Single { Vec::new() } else { swaps.to_vec() };
    Options { swaps, ..Options::new(placement, log) }
}

/// Every placement with every pinning, as often as asked for.
fn ways(assembly: &Assembly, args: &VerifyArgs, folder: &Scratch, swaps: &[Swap]) -> Result<Vec<Way>, Failure> {
    let mut ways = Vec::new();
    let possible = |placement: &Placement| *placement != Placement::Single || basis(swaps) == Placement::Single;
    for placement in placements(assembly, &args.placements)?.into_iter().filter(possible) {
        let pins = if placement == Placement::Single { &[Pin::None][..] } else { &[Pin::Auto, Pin::None] };
        for &pin in pins {
            for round in 0..args.repeat {
                let stress = args.stress.then_some(Stress { seed: args.seed + ways.len() as u64 });
                let pinned = if pin == Pin::Auto { "one core" } else { "any core" };
                let stressed = stress.map_or(String::new(), |stress| format!(", stress {}", stress.seed));
                let name = format!("{}, {pinned}{stressed}, round {}", placement.name(), round + 1);
                let log = folder.path().join(format!("{}.mcap", ways.len()));
                ways.push(Way { name, options: Options { pin, stress, ..options(swaps, placement, Some(log)) } });
            }
        }
    }
    Ok(ways)
}

fn placements(assembly: &Assembly, names: &[String]) -> Result<Vec<Placement>, Failure> {
    let mut placements = Vec::new();
    for name in names {
        match Placement::from_str(name, true) {
            Ok(placement) => placements.push(placement),
            Err(_) if name == "all" => placements.extend(Placement::value_variants()),
            Err(_) => {
                return Err(Failure::Usage(format!(
                    "--placements {name}: expected all, processes, agents, groups or single"
                )));
            }
        }
    }
    let has_groups = !assembly.scenario.groups.is_empty();
    placements.retain(|placement| *placement != Placement::Groups || has_groups);
    Ok(placements)
}

/// Runs in a thread of its own, which keeps its pinning to itself, and returns the digest of the log.
fn record(assembly: &Assembly, options: &Options) -> Result<String, Failure> {
    let work = || std::thread::scope(|scope| scope.spawn(|| run(assembly, options, |_| {})).join());
    let outcome = work().map_err(|_| Failure::Internal("a run panicked".into()))??;
    outcome.ending.into_result()?;
    outcome.log.map(|log| log.sha256).ok_or_else(|| Failure::Internal("a run was not recorded".into()))
}
