//! `cargo bench`: how fast steps are, beside the yardstick of the same run.

use std::process::ExitCode;

fn main() -> ExitCode {
    benches::main()
}
