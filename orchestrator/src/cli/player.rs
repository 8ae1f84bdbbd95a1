//! Arguments of the commands that exchange participants.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::trial::scaffold::Language;

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// The participant that is run again; all others are played from the log: controller.3, plant
    #[arg(long, value_name = "NODE")]
    pub(crate) only: String,
    /// What is run in its place [default: our own component of the scenario in the log]: a program of yours,
    /// --swap controller.3=./my_controller, what another log holds of it, --swap controller.3=replay:LOG.mcap, or a robot, --swap
    /// plant.2=hardware:robot2.toml
    #[arg(long, value_name = "NODE=COMMAND|replay:LOG")]
    pub(crate) swap: Option<String>,
    /// Take numbers for equal that are no further apart than this; if the recorded number is larger than 1, than this times
    /// the number
    #[arg(long, value_name = "NUMBER", default_value = "0", value_parser = not_negative)]
    pub(crate) tolerance: f64,
    /// Record the new run
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ParticipantArgs {
    /// Play the participants from this log
    #[arg(long, value_name = "LOG")]
    pub(crate) replay: Option<PathBuf>,
    /// Multiply what is played
    #[arg(long, default_value_t = 1.0, requires = "replay")]
    pub(crate) factor: f64,
}

#[derive(Debug, Args)]
pub(crate) struct ConformArgs {
    /// The participant whose place the program is to take: controller.3, observer_2, plant
    pub(crate) node: String,
    /// Scenario to take the inputs from: a shipped one (see `phalanx list`) or a file
    #[arg(long, default_value = "triangle", conflicts_with = "log")]
    pub(crate) scenario: String,
    /// Variant of the scenario
    #[arg(long, conflicts_with = "log")]
    pub(crate) variant: Option<String>,
    /// Change a field of the scenario: --set NAME=VALUE; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", conflicts_with = "log")]
    pub(crate) set: Vec<String>,
    /// The same for a field that only some variants have: in the others it does nothing
    #[arg(long, value_name = "NAME=VALUE", conflicts_with = "log")]
    pub(crate) set_if_present: Vec<String>,
    /// Take the inputs from this log instead
    #[arg(long, value_name = "LOG.mcap")]
    pub(crate) log: Option<PathBuf>,
    /// Steps of each trial, at most; fewer if the scenario has fewer
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(10..=100_000))]
    pub(crate) steps: u64,
    /// How long the program may take to start, for a step, and to end, in s
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = super::engine::wait_time)]
    pub(crate) patience: f64,
    /// An interval for all numbers of an output: --range input=-20..20; may be repeated
    #[arg(long, value_name = "FIELD=LOW..HIGH", allow_hyphen_values = true)]
    pub(crate) range: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// The program with its arguments, behind --
    #[arg(last = true, required = true, value_name = "COMMAND")]
    pub(crate) command: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct SuperviseArgs {
    /// Where to write how the program ended
    pub(crate) status: PathBuf,
    /// The program with its arguments
    #[arg(last = true, required = true)]
    pub(crate) command: Vec<std::ffi::OsString>,
}

/// What a new project is to serve as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum NewRole {
    /// Computes the input of one agent
    Controller,
    /// Estimates what the sensors of one agent do not tell
    Observer,
    /// Says what every agent has to track
    Planner,
    /// Moves the vehicles
    Plant,
}

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// What the program is to serve as
    #[arg(value_enum)]
    pub(crate) role: NewRole,
    /// Name of the project, and of the folder that is made for it
    pub(crate) name: String,
    /// What it is written in
    #[arg(long, value_enum)]
    pub(crate) lang: Language,
    /// Scenario whose signals it has: a shipped one (see `phalanx list`) or a file
    /// [default: triangle; for an observer, which triangle does not have, cida]
    #[arg(long)]
    pub(crate) scenario: Option<String>,
    /// Variant of the scenario
    #[arg(long)]
    pub(crate) variant: Option<String>,
    /// Checkout of the source of Phalanx [default: the one that this program was built from]
    #[arg(long, value_name = "FOLDER")]
    pub(crate) phalanx: Option<PathBuf>,
}

/// A number >= 0.
fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        _ => Err("expected a number >= 0".into()),
    }
}
