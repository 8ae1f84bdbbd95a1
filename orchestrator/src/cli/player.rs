//! Arguments of the commands that exchange participants.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// The participant that is run again; all others are played from the log: controller.3, plant
    #[arg(long, value_name = "NODE")]
    pub(crate) only: String,
    /// What is run in its place [default: our own component of the scenario in the log]: a program of yours,
    /// --swap controller.3=./my_controller, or what another log holds of it, --swap controller.3=replay:LOG.mcap
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

/// A number >= 0.
fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        _ => Err("expected a number >= 0".into()),
    }
}
