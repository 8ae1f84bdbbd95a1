//! Arguments of the live view.

use clap::Args;

use super::engine::RunName;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  phalanx run uav --realtime &   then   phalanx watch
  phalanx watch --web            waits for a run if none is going on
  phalanx watch uav-2 --web --port 9000

The run does not notice: nothing waits for whoever looks on. What is between two looks is only in the log.")]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    pub(crate) run: RunName,
    /// Show it in a browser on this machine: the formation in motion and all plots, as in a report
    #[arg(long)]
    pub(crate) web: bool,
    /// Port of the page [default: 8467 if it is free, else any]
    #[arg(long, requires = "web", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) port: Option<u16>,
    /// Only print where the page is, open no browser
    #[arg(long, requires = "web")]
    pub(crate) no_open: bool,
}
