//! `phalanx participant`: a process of a run.

use std::process::ExitCode;

use formation::config::Problem;
use formation::scenario::{Scenario, Selection};
use formation::wiring::{Assembly, SCENARIO_FILE, scenario_text};

use crate::catalog::ROLES;
use crate::cli::ParticipantArgs;
use crate::replay::played;

/// Builds the participants that the plan assigns to this process, or plays them from a log, and serves.
pub(crate) fn participant(args: &ParticipantArgs) -> ExitCode {
    lockstep::serve(|plan, nodes| {
        let text = scenario_text()?;
        let first = |problems: Vec<Problem>| problems[0].to_string();
        let selection = Selection::default();
        if let Some(log) = &args.replay {
            let scenario = Scenario::load(SCENARIO_FILE, &text, &selection).map_err(first)?;
            return played(log, &scenario, &plan.network, nodes, args.factor).map_err(|error| error.to_string());
        }
        let assembly = Assembly::load(SCENARIO_FILE, &text, &selection, &ROLES).map_err(first)?;
        if assembly.network != plan.network {
            return Err("the plan of the run is not that of its scenario".into());
        }
        assembly.participants(nodes).map_err(first)
    })
}
