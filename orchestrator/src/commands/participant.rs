//! `phalanx participant`: a process of a run.

use std::process::ExitCode;

use formation::scenario::Selection;
use formation::wiring::{Assembly, SCENARIO_FILE, scenario_text};

use crate::catalog::ROLES;

/// Builds the participants that the plan assigns to this process, and serves.
pub(crate) fn participant() -> ExitCode {
    crate::logging::start_participant();
    let end = lockstep::serve(|plan, nodes| {
        let names: Vec<&str> = nodes.iter().map(|&node| plan.network.nodes[node].name.as_str()).collect();
        tracing::info!(pid = std::process::id(), hosts = names.join(", "), "building");
        let text = scenario_text()?;
        let first = |problems: Vec<formation::config::Problem>| problems[0].to_string();
        Assembly::load(SCENARIO_FILE, &text, &Selection::default(), &ROLES)
            .and_then(|assembly| assembly.participants(nodes))
            .map_err(first)
    });
    tracing::debug!("done");
    end
}
