//! `phalanx participant`: a process of a run.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use formation::config::Problem;
use formation::scenario::Scenario;
use formation::wiring::{Assembly, SCENARIO_FILE, run_selection, scenario_text};

use crate::catalog::Catalog;
use crate::recorded::played;
use crate::run::priority::lock_memory_if_wanted;

#[derive(Debug, Args)]
pub(crate) struct ParticipantArgs {
    /// Play the participants from this log
    #[arg(long, value_name = "LOG")]
    pub(crate) replay: Option<PathBuf>,
    /// Multiply what is played
    #[arg(long, default_value_t = 1.0, requires = "replay")]
    pub(crate) factor: f64,
}

/// Builds the participants that the plan assigns to this process, or plays them from a log, and serves.
pub(crate) fn participant(catalog: &Catalog, args: &ParticipantArgs) -> ExitCode {
    crate::logging::start_participant();
    lock_memory_if_wanted();
    let end = processes::serve(|plan, nodes| {
        let names: Vec<&str> = nodes.iter().map(|&node| plan.network.nodes[node].name.as_str()).collect();
        tracing::info!(pid = std::process::id(), hosts = names.join(", "), "building");
        let text = scenario_text()?;
        let first = |problems: Vec<Problem>| problems[0].to_string();
        let selection = run_selection();
        if let Some(log) = &args.replay {
            let scenario = Scenario::load(SCENARIO_FILE, &text, &selection).map_err(first)?;
            return played(log, &scenario, &plan.network, nodes, args.factor).map_err(|error| error.to_string());
        }
        let assembly = Assembly::load(SCENARIO_FILE, &text, &selection, &catalog.roles).map_err(first)?;
        // Bridges to robots have nodes and channels of their own behind those of the scenario.
        let (ours, planned) = (&assembly.network, &plan.network);
        if !planned.channels.starts_with(&ours.channels) || !planned.nodes.starts_with(&ours.nodes) {
            return Err("the plan of the run is not that of its scenario".into());
        }
        assembly.participants(nodes).map_err(first)
    });
    tracing::debug!("done");
    end
}
