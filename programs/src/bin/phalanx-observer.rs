//! The program `phalanx-observer`: serves as the observer of a run, `phalanx run ... --swap observer.1=phalanx-observer`.

use std::process::ExitCode;

use formation::wiring::{Role, kinds};
use processes::serve;

fn main() -> ExitCode {
    serve(kinds(Role::Observer, observer::KINDS))
}
