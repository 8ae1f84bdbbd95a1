//! `phalanx participant`: a process of a run.

use std::process::ExitCode;

use formation::scenario::Selection;
use formation::wiring::{Assembly, SCENARIO_FILE, scenario_text};

use crate::catalog::ROLES;
use crate::urgency::lock_memory_if_wanted;

/// Builds the participants that the plan assigns to this process, and serves.
pub(crate) fn participant() -> ExitCode {
    lock_memory_if_wanted();
    lockstep::serve(|_, nodes| {
        let text = scenario_text()?;
        let first = |problems: Vec<formation::config::Problem>| problems[0].to_string();
        Assembly::load(SCENARIO_FILE, &text, &Selection::default(), &ROLES)
            .and_then(|assembly| assembly.participants(nodes))
            .map_err(first)
    })
}
