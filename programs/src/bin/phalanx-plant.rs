//! The program `phalanx-plant`: serves as the plant of a run, `phalanx run ... --swap plant=phalanx-plant`.

use std::process::ExitCode;

use formation::wiring::{Role, kinds};
use processes::serve;

fn main() -> ExitCode {
    serve(kinds(Role::Plant, plant::KINDS))
}
