//! Arguments of `phalanx profile`.

use std::path::PathBuf;

use clap::Args;

use super::ScenarioArgs;
use crate::run::placement::Placement;

#[derive(Debug, Args)]
#[command(
    after_help = "SCENARIO may be a log, too: its scenario is run again, since a log holds no times, which differ from run to run."
)]
pub(crate) struct ProfileArgs {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArgs,
    /// Record the run, as `phalanx run` does; else nothing is recorded
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) out: Option<PathBuf>,
    /// Where the trace of the last steps goes, for ui.perfetto.dev [default: <scenario>.trace.json]
    #[arg(long, value_name = "TRACE.json")]
    pub(crate) trace: Option<PathBuf>,
    /// How the participants are spread over processes; `single` has no trace [default: as for `phalanx run`]
    #[arg(long, value_enum)]
    pub(crate) placement: Option<Placement>,
    /// Cores of the processes: `auto`, `none` or the number of a core, as for `phalanx run`
    #[arg(long, default_value = "auto")]
    pub(crate) pin: String,
    /// Show no progress
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
