//! The program `phalanx-planner`: serves as the planner of a run, `phalanx run ... --swap planner=phalanx-planner`.

use std::process::ExitCode;

use formation::wiring::{Role, kinds};
use processes::serve;

fn main() -> ExitCode {
    serve(kinds(Role::Planner, high_level_planner::KINDS))
}
