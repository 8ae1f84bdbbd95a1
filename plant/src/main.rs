//! The program `phalanx-plant`: serves as the plant of a run, `phalanx run ... --swap plant=phalanx-plant`.

use std::process::ExitCode;

use formation::wiring::{Role, serve_kinds};

fn main() -> ExitCode {
    serve_kinds(Role::Plant, plant::KINDS)
}
