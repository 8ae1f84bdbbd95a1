//! The program `phalanx`.

use std::process::ExitCode;

fn main() -> ExitCode {
    phalanx::main(&phalanx::thesis::catalog())
}
