//! The program `phalanx-controller`: serves as the controller of a run, `phalanx run ... --swap controller.1=phalanx-controller`.

use std::process::ExitCode;

use formation::wiring::{Role, serve_kinds};

fn main() -> ExitCode {
    serve_kinds(Role::Controller, low_level_ctrl::KINDS)
}
