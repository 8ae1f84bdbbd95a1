//! Arguments of the commands that show and hand on what a log holds.

use std::path::PathBuf;

use clap::Args;

use crate::show::export::ExportFormat;
use crate::show::figures::FigureFormat;
use crate::show::layouts::Viewer;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  phalanx report runs/uav-TSC.mcap
  phalanx report runs/uav-TSC.mcap runs/uav-TOC.mcap --out both.html
  phalanx report runs/uav-*.mcap --figures figures --format pdf")]
pub(crate) struct ReportArgs {
    /// Logs that `phalanx run` recorded; several are compared
    #[arg(required = true)]
    pub(crate) logs: Vec<PathBuf>,
    /// Where the report goes [default: <LOG>.html beside the log, or comparison.html]
    #[arg(long, value_name = "FILE.html", conflicts_with = "figures")]
    pub(crate) out: Option<PathBuf>,
    /// Write figures for a paper into this folder instead of a report: those of the thesis by their numbers, and all plots of each
    /// run
    #[arg(long, value_name = "FOLDER")]
    pub(crate) figures: Option<PathBuf>,
    /// How the figures are stored
    #[arg(long, value_enum, default_value_t = FigureFormat::Svg, requires = "figures")]
    pub(crate) format: FigureFormat,
}

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// How the signals are stored
    #[arg(long, value_enum, default_value_t = ExportFormat::Csv)]
    pub(crate) format: ExportFormat,
    /// Only these topics, separated by commas; `*` stands for anything: --topics 'agent_1/*,*/command'
    #[arg(long, value_name = "TOPICS", value_delimiter = ',')]
    pub(crate) topics: Vec<String>,
    /// Only every K-th step
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) every: u64,
    /// Where they go [default: beside the log: the folder <LOG>-csv or <LOG>-parquet, or <LOG>.npz, <LOG>.mat]
    #[arg(long, value_name = "FOLDER|FILE")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  phalanx layout runs/uav-TSC.mcap --for foxglove
  phalanx layout uav --for plotjuggler --out uav.xml")]
pub(crate) struct LayoutArgs {
    /// A log that `phalanx run` recorded, or a scenario that is yet to run
    #[arg(value_name = "LOG.mcap|SCENARIO")]
    pub(crate) run: String,
    /// For which viewer
    #[arg(long = "for", value_enum, value_name = "VIEWER")]
    pub(crate) viewer: Viewer,
    /// Variant of the scenario
    #[arg(long)]
    pub(crate) variant: Option<String>,
    /// Where the layout goes [default: beside the log, or here: <LOG>-<VIEWER>.json, .xml, .py]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  phalanx echo run.mcap agent_1/state
  phalanx echo run.mcap agent_1/state position --at 12.5
  phalanx echo run.mcap agent_2/command input --every 100 | column -t")]
pub(crate) struct EchoArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// A topic, as `phalanx info` lists them: agent_1/state
    pub(crate) topic: String,
    /// A field of the topic; all of them if it is left out
    pub(crate) field: Option<String>,
    /// Only the step at or before this time, s
    #[arg(long, value_name = "SECONDS", conflicts_with = "every", allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,
    /// Only every K-th step
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) every: u64,
}

#[derive(Debug, Args)]
#[command(after_help = "\
A signal is TOPIC/FIELD, with [K] for its component K, from 0; `*` stands for anything.

Examples:
  phalanx plot run.mcap agent_1/state/position[2]
  phalanx plot run.mcap 'agent_*/command/input[0]' --from 0 --to 5
  phalanx plot run.mcap 'agent_*/estimate/disturbance' --norm --log-scale")]
pub(crate) struct PlotArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// What is drawn: agent_1/state/position[2]
    #[arg(required = true)]
    pub(crate) signals: Vec<String>,
    /// Draw the norm of a vector instead of its components
    #[arg(long)]
    pub(crate) norm: bool,
    /// Logarithmic values
    #[arg(long)]
    pub(crate) log_scale: bool,
    /// First instant, s
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) from: Option<f64>,
    /// Last instant, s
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) to: Option<f64>,
    /// Columns [default: those of the terminal, or 100]
    #[arg(long, value_parser = clap::value_parser!(u16).range(30..=1000))]
    pub(crate) width: Option<u16>,
    /// Lines of the drawing
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(3..=200))]
    pub(crate) height: u16,
}
