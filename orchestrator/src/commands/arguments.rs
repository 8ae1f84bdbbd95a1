//! Arguments that several commands have.

use clap::Args;

/// A scenario and what is changed about it.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct ScenarioArgs {
    /// Name of a shipped scenario (see `phalanx list`) or path of a scenario file
    pub(crate) scenario: String,
    /// Variant to run, as listed by `phalanx list`
    #[arg(long)]
    pub(crate) variant: Option<String>,
    /// Change a field: `--set controller.c_p=3`, `--set agents.2.position=[1,2,0]`, `--set phase=0.5`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
    /// The same for a field that only some variants have: in the others it does nothing. A field that no variant has is an
    /// error
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set_if_present: Vec<String>,
    /// Length of a step in s; short for --set timing.dt=...
    #[arg(long, value_name = "SECONDS")]
    pub(crate) dt: Option<String>,
    /// Length of the run in s; short for --set timing.duration=...
    #[arg(long, value_name = "SECONDS")]
    pub(crate) duration: Option<String>,
    /// Seed of all random numbers; short for --set seed=...
    #[arg(long)]
    pub(crate) seed: Option<String>,
}

/// Which run is meant.
#[derive(Clone, Debug, Args)]
pub(crate) struct RunName {
    /// Name of the run, if there are several: `uav`, `uav-2`
    #[arg(value_name = "RUN")]
    pub(crate) name: Option<String>,
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

/// A number >= 0.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        _ => Err("expected a number >= 0".into()),
    }
}
