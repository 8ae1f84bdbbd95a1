//! `phalanx ctl`.

use clap::{Args, Subcommand};

use super::arguments::RunName;
use super::select_run::choose;
use crate::failure::Failure;
use crate::run::control::{Request, ask};

/// What to tell a run.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum CtlCommand {
    /// Hold the run before its next step
    Pause {
        #[command(flatten)]
        run: RunName,
    },
    /// Let a paused run go on
    Resume {
        #[command(flatten)]
        run: RunName,
    },
    /// Let the run do some steps and hold it then
    Step {
        /// How many steps
        #[arg(default_value_t = 1)]
        steps: u64,
        #[command(flatten)]
        run: RunName,
    },
    /// Let a program of your own play a participant from the next step on: `ctl swap controller.3=./my_controller`
    ///
    /// The program is given all steps so far, and takes over when it has caught up. The log marks the step.
    Swap {
        /// Which participant, and the command that starts the program
        #[arg(value_name = "NODE=COMMAND")]
        swap: String,
        #[command(flatten)]
        run: RunName,
    },
    /// End the run in order; its log stays readable up to there
    Stop {
        #[command(flatten)]
        run: RunName,
    },
    /// Emergency stop: all robots of the run stop, and the run ends as failed
    Estop {
        #[command(flatten)]
        run: RunName,
    },
    /// Show how far the run is
    Status {
        #[command(flatten)]
        run: RunName,
    },
}

#[derive(Debug, Args)]
pub(crate) struct CtlArgs {
    #[command(subcommand)]
    pub(crate) command: CtlCommand,
    /// Print JSON
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

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
