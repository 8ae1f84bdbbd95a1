//! `phalanx ctl`.

use super::select_run::choose;
use crate::cli::{CtlArgs, CtlCommand};
use crate::failure::Failure;
use crate::run::control::{Request, ask};

pub(crate) fn ctl(args: &CtlArgs) -> Result<(), Failure> {
    let (run, request) = match &args.command {
        CtlCommand::Pause { run } => (run, Request::Pause),
        CtlCommand::Resume { run } => (run, Request::Resume),
        CtlCommand::Step { steps, run } => (run, Request::Step(*steps)),
        CtlCommand::Stop { run } => (run, Request::Stop),
        CtlCommand::Swap { swap, run } => (run, swap_from_here(swap)?),
        CtlCommand::Estop { run } => (run, Request::Estop),
        CtlCommand::Status { run } => (run, Request::Status),
    };
    let status = ask(&choose(run.name.as_deref())?, &request)?;
    if args.json {
        println!("{}", serde_json::json!(status));
        return Ok(());
    }
    if let Some(step) = status.swapped_at {
        println!("the program plays from step {step} on");
    }
    println!("{}", status.sentence());
    Ok(())
}

/// The request for a swap. The run may have been started in another folder; file names in the swap are relative to this one.
fn swap_from_here(swap: &str) -> Result<Request, Failure> {
    let here = std::env::current_dir().map_err(Failure::system("ask for the current folder"))?;
    Ok(Request::Swap(swap.into(), Some(here)))
}
