//! `phalanx ctl`.

use serde_json::Value;

use super::select_run::{choose, tell};
use crate::cli::{CtlArgs, CtlCommand};
use crate::failure::Failure;
use crate::run::control::FOLDER_MARK;

pub(crate) fn ctl(args: &CtlArgs) -> Result<(), Failure> {
    let (run, line) = match &args.command {
        CtlCommand::Pause { run } => (run, "pause".to_string()),
        CtlCommand::Resume { run } => (run, "resume".into()),
        CtlCommand::Step { steps, run } => (run, format!("step {steps}")),
        CtlCommand::Stop { run } => (run, "stop".into()),
        CtlCommand::Swap { swap, run } => (run, swap_from_here(swap)?),
        CtlCommand::Estop { run } => (run, "estop".into()),
        CtlCommand::Status { run } => (run, "status".into()),
    };
    let run = choose(run.name.as_deref())?;
    let status = tell(&run, &line)?;
    if args.json {
        println!("{status}");
    } else {
        if let Some(step) = status["swapped_at"].as_u64() {
            println!("the program plays from step {step} on");
        }
        println!("{}", sentence(&status));
    }
    Ok(())
}

/// The request for a swap. The run may have been started in another folder; names of files in the swap are meant from here.
fn swap_from_here(swap: &str) -> Result<String, Failure> {
    let here = std::env::current_dir().map_err(Failure::system("ask for the current folder"))?;
    Ok(format!("swap {swap}{FOLDER_MARK}{}", here.display()))
}

/// How far a run is, in one line.
pub(super) fn sentence(status: &Value) -> String {
    let word = match (status["stopping"].as_bool(), status["paused"].as_bool()) {
        (Some(true), _) => "is stopping",
        (_, Some(true)) => "is paused",
        _ => "runs",
    };
    let text = |name: &str| status[name].as_str().unwrap_or_default().to_string();
    let number = |name: &str| status[name].as_u64().unwrap_or(0);
    format!(
        "{} ({} {}) {word}: {} of {} steps done, t = {:.3} s, {} processes, pid {}",
        text("run"),
        text("scenario"),
        text("variant"),
        number("steps"),
        number("of"),
        status["time"].as_f64().unwrap_or(0.0),
        number("processes"),
        number("pid")
    )
}
