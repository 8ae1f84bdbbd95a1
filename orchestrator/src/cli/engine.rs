//! Arguments of the commands that watch, steer and prove runs.

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Two logs to compare
    #[arg(num_args = 2, value_name = "LOG", required_unless_present = "scenario", conflicts_with = "scenario")]
    pub(crate) logs: Vec<PathBuf>,
    /// Run this scenario in many ways instead, and compare
    #[arg(long)]
    pub(crate) scenario: Option<String>,
    /// Variant to run
    #[arg(long, requires = "scenario")]
    pub(crate) variant: Option<String>,
    /// Change a field of the scenario: --set NAME=VALUE; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", requires = "scenario")]
    pub(crate) set: Vec<String>,
    /// The same for a field that only some variants have: in the others it does nothing
    #[arg(long, value_name = "NAME=VALUE", requires = "scenario")]
    pub(crate) set_if_present: Vec<String>,
    /// Length of each run in s
    #[arg(long, value_name = "SECONDS", requires = "scenario")]
    pub(crate) duration: Option<String>,
    /// Placements to run, or `all`
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "all", requires = "scenario")]
    pub(crate) placements: Vec<String>,
    /// How often each way is run
    #[arg(long, default_value_t = 1, requires = "scenario")]
    pub(crate) repeat: u64,
    /// Disturb every run: random delays in the participants, other orders and priorities, busy cores
    #[arg(long, requires = "scenario")]
    pub(crate) stress: bool,
    /// Decides on the disturbances
    #[arg(long, default_value_t = 1, requires = "stress")]
    pub(crate) seed: u64,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

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

/// Which run is meant.
#[derive(Clone, Debug, Args)]
pub(crate) struct RunName {
    /// Name of the run, if there are several: `uav`, `uav-2`
    #[arg(value_name = "RUN")]
    pub(crate) name: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct CtlArgs {
    #[command(subcommand)]
    pub(crate) command: CtlCommand,
    /// Print JSON
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct TopArgs {
    #[command(flatten)]
    pub(crate) run: RunName,
    /// Seconds between two looks
    #[arg(long, default_value = "1", value_parser = wait_time)]
    pub(crate) interval: f64,
    /// Print one look and end
    #[arg(long)]
    pub(crate) once: bool,
}

/// A time in seconds that can be waited for.
pub(super) fn wait_time(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().map_err(|_| "expected a number of seconds".to_string())?;
    lockstep::wait_time(seconds).map(|_| seconds)
}

/// How many simulated seconds pass in a second of the clock.
pub(super) fn factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(factor) if (1e-3..=1e6).contains(&factor) => Ok(factor),
        _ => Err("expected a factor from 0.001 to 1000000".into()),
    }
}
