//! `phalanx profile`.

use std::path::PathBuf;

use clap::Args;
use formation::wiring::Assembly;

use super::arguments::ScenarioArgs;
use super::run::{conclude, end_on_signals, inputs, parse_swaps, show_profile};
use super::select::{assemble, from_log};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::files;
use crate::run::pinning::Pin;
use crate::run::placement::Placement;
use crate::run::{Options, run};
use crate::terminal::counted;
use recording::Log;

#[derive(Debug, Args)]
#[command(
    after_help = "SCENARIO may be a log, too: its scenario is run again, since a log holds no times, which differ from run to run."
)]
pub(crate) struct ProfileArgs {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArgs,
    /// Record the run, as `phalanx run` does; else nothing is recorded
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) out: Option<PathBuf>,
    /// Where the trace of the last steps goes, for ui.perfetto.dev [default: <scenario>.trace.json]
    #[arg(long, value_name = "TRACE.json")]
    pub(crate) trace: Option<PathBuf>,
    /// How the participants are spread over processes; `single` has no trace [default: as for `phalanx run`]
    #[arg(long, value_enum)]
    pub(crate) placement: Option<Placement>,
    /// Cores of the processes: `auto`, `none` or the number of a core, as for `phalanx run`
    #[arg(long, default_value = "auto")]
    pub(crate) pin: String,
    /// Show no progress
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

pub(crate) fn profile(catalog: &Catalog, args: &ProfileArgs) -> Result<(), Failure> {
    let assembly = assembly_of(catalog, &args.scenario)?;
    let placement = args.placement.unwrap_or_else(|| Placement::default_of(&assembly));
    let trace = match placement {
        Placement::Single if args.trace.is_some() => {
            return Err(Failure::Usage("--trace needs processes; leave out --placement single".into()));
        }
        Placement::Single => None,
        _ => Some(args.trace.clone().unwrap_or_else(|| format!("{}.trace.json", assembly.scenario.name).into())),
    };
    // The run that is profiled is the one that `phalanx run` carries out.
    let swaps = parse_swaps(&[], &assembly, placement)?;
    let mut inputs = inputs(&args.scenario, &swaps);
    if let Some(out) = &args.out {
        files::spare(out, &inputs)?;
        inputs.push(out.clone());
    }
    if let Some(trace) = &trace {
        files::prepare(trace, &inputs)?;
    }
    let options = Options {
        pin: Pin::parse(&args.pin)?,
        progress: !args.quiet,
        trace,
        swaps,
        on_failure: assembly.scenario.on_failure.clone(),
        ..Options::new(placement, args.out.clone())
    };
    let outcome = run(&assembly, &options, end_on_signals)?;
    println!(
        "{}: {}, {:.0} steps/s, {}",
        assembly.scenario.label(),
        counted(outcome.steps as usize, "step"),
        outcome.steps_per_second(),
        counted(outcome.processes, "process")
    );
    show_profile(&outcome, options.trace.as_deref());
    conclude(outcome, None)
}

/// A scenario as for every other command, or that of a log.
fn assembly_of(catalog: &Catalog, args: &ScenarioArgs) -> Result<Assembly, Failure> {
    let path = PathBuf::from(&args.scenario);
    if path.extension().is_none_or(|extension| extension != "mcap") {
        return assemble(catalog, args);
    }
    let changes = [&args.variant, &args.dt, &args.duration, &args.seed];
    if !args.set.is_empty() || !args.set_if_present.is_empty() || changes.iter().any(|change| change.is_some()) {
        return Err(Failure::Usage(format!(
            "{} is a log, which says everything about its run; profile its scenario instead to change something",
            path.display()
        )));
    }
    from_log(catalog, &Log::open(&path)?)
}
