//! The program `phalanx-planner`: serves as the planner of a run, `phalanx run ... --swap planner=phalanx-planner`.

use std::process::ExitCode;

use formation::wiring::{Role, serve_kinds};

fn main() -> ExitCode {
    serve_kinds(Role::Planner, high_level_planner::KINDS)
}
