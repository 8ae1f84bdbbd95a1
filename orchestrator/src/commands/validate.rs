//! `phalanx validate`.

use clap::Args;
use formation::wiring::{Assembly, Role};
use lockstep::{Local, LoopError};
use serde_json::json;

use super::arguments::ScenarioArgs;
use super::select::assemble;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::terminal::counted;

#[derive(Debug, Args)]
pub(crate) struct ValidateArgs {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the effective scenario, with variant and overrides applied, as TOML
    #[arg(long, conflicts_with = "json")]
    pub(crate) print: bool,
}

/// Up to so many agents, the first step is computed; beyond, that would take longer than all the rest.
const MOST_STARTED: usize = 2000;

/// Whether the first step can be computed, in this process: what is not a finite number at t = 0 is found here. Participants that only
/// programs play are not there to be asked.
fn check_start(assembly: &Assembly) -> Result<(), Failure> {
    let is_large = assembly.scenario.context.agents.len() > MOST_STARTED;
    if is_large || Role::ALL.into_iter().any(|role| assembly.is_external(role)) {
        return Ok(());
    }
    let nodes: Vec<usize> = (0..assembly.network.nodes.len()).collect();
    let participants = assembly.participants(&nodes)?;
    let loops = |error: LoopError| Failure::Invalid(vec![assembly.scenario.problem("", error.to_string())]);
    let mut run =
        Local::new(assembly.network.clone(), participants, assembly.scenario.context.timing.dt).map_err(loops)?;
    run.step().map(|_| ()).map_err(|error| {
        let (node, fault) = (&error.node, &error.fault.0);
        // A fault that begins with a field of the scenario is shown there.
        let path = fault.split(" is ").next().filter(|path| assembly.scenario.section(path).is_some());
        let path = path.or_else(|| node.split('_').next()).unwrap_or_default();
        Failure::Invalid(vec![
            assembly.scenario.problem(path, format!("{node} cannot compute the first step: {fault}")),
        ])
    })
}

pub(crate) fn validate(catalog: &Catalog, args: &ValidateArgs) -> Result<(), Failure> {
    let assembly = assemble(catalog, &args.scenario)?;
    check_start(&assembly)?;
    let scenario = &assembly.scenario;
    if args.print {
        print!("{}", scenario.to_toml());
        return Ok(());
    }
    let timing = scenario.context.timing;
    let (agents, processes) = (scenario.context.agents.len(), assembly.network.nodes.len() + 1);
    if args.json {
        let summary = json!({
            "scenario": scenario.name, "variant": scenario.variant, "agents": agents, "steps": timing.periods(),
            "dt": timing.dt, "duration": timing.duration, "processes": processes, "ok": true,
        });
        println!("{summary}");
        return Ok(());
    }
    let variant = if scenario.variant.is_empty() { String::new() } else { format!(", variant {}", scenario.variant) };
    println!(
        "{}{variant}: valid. {}, {}, {} of {} s",
        scenario.name,
        counted(agents, "agent"),
        counted(processes, "process"),
        counted(timing.periods() as usize, "step"),
        timing.dt
    );
    Ok(())
}
