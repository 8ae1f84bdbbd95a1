//! `phalanx participant`: a process of a run.

use std::process::ExitCode;

use formation::scenario::Selection;
use formation::wiring::Assembly;

use crate::catalog::ROLES;
use crate::engine::SCENARIO_FILE;

/// Builds the participants that the plan assigns to this process, and serves.
pub(crate) fn participant() -> ExitCode {
    lockstep::serve(|_, nodes| {
        let directory = std::env::var_os("PHALANX_RUN_DIR").ok_or("PHALANX_RUN_DIR is not set")?;
        let path = std::path::Path::new(&directory).join(SCENARIO_FILE);
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let first = |problems: Vec<formation::config::Problem>| problems[0].to_string();
        Assembly::load(SCENARIO_FILE, &text, &Selection::default(), &ROLES)
            .and_then(|assembly| assembly.participants(nodes))
            .map_err(first)
    })
}
