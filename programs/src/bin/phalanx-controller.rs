//! The program `phalanx-controller`: serves as the controller of a run, `phalanx run ... --swap controller.1=phalanx-controller`.

use std::process::ExitCode;

use formation::wiring::{Role, kinds};
use processes::serve;

fn main() -> ExitCode {
    serve(kinds(Role::Controller, low_level_ctrl::KINDS))
}
