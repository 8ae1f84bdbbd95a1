//! The program `phalanx`: the framework with the schemes of this repository.

use std::process::ExitCode;

fn main() -> ExitCode {
    orchestrator::main(&thesis::catalog(schemes::ROLES, schemes::SCENARIOS))
}
