//! `phalanx validate`.

use clap::Args;
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

pub(crate) fn validate(catalog: &Catalog, args: &ValidateArgs) -> Result<(), Failure> {
    let assembly = assemble(catalog, &args.scenario)?;
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
