//! `phalanx plot`.

use std::io::{self, IsTerminal};
use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::judge::metrics::norm;
use crate::show::drawing::{Drawing, Line};
use crate::show::view::signals;
use crate::terminal::{plain, size_of};
use recording::Log;

/// Columns of an output that is not a terminal.
const WIDTH: usize = 100;
/// Lines that one can still tell apart.
const LINES_MAX: usize = 24;

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

pub(crate) fn plot(args: &PlotArgs) -> Result<(), Failure> {
    let log = Log::open(&args.log)?;
    let samples = window(&log, args)?;
    let times: Vec<f64> = samples.clone().map(|sample| log.times()[sample] as f64 / 1e9).collect();
    let mut lines = Vec::new();
    for text in &args.signals {
        for signal in signals(&log, text)? {
            let Some(series) = log.signal(&signal.topic, &signal.field) else { continue };
            let name = plain(&format!("{}/{}", signal.topic.trim_start_matches('/'), signal.field)).into_owned();
            if args.norm && signal.component.is_none() && series.width() > 1 {
                let values = samples.clone().map(|sample| norm(series.row(sample))).collect();
                lines.push(Line { label: format!("|{name}|"), values });
                continue;
            }
            let components = signal.component.map_or(0..series.width(), |component| component..component + 1);
            lines.extend(components.map(|component| Line {
                label: if series.width() == 1 { name.clone() } else { format!("{name}[{component}]") },
                values: samples.clone().map(|sample| series.row(sample)[component]).collect(),
            }));
        }
    }
    if lines.len() > LINES_MAX {
        let hint = "name components, as in position[2], or ask for --norm";
        return Err(Failure::Usage(format!("that makes {} lines; {LINES_MAX} is the most; {hint}", lines.len())));
    }
    let terminal = io::stdout().is_terminal();
    // A pipe has no size, but the terminal that it ends in has.
    let size = size_of(io::stdout()).or_else(|| size_of(io::stderr())).or_else(|| size_of(io::stdin()));
    let columns = args.width.map(usize::from).or(size.map(|(columns, _)| columns)).unwrap_or(WIDTH);
    let coloured = terminal && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let drawing =
        Drawing { columns: columns.max(30), rows: usize::from(args.height), logarithmic: args.log_scale, coloured };
    // Names of topics are escaped where they become labels.
    draw!("{}", drawing.draw(&times, &lines));
    Ok(())
}

/// The samples between `--from` and `--to`.
fn window(log: &Log, args: &PlotArgs) -> Result<std::ops::Range<usize>, Failure> {
    let before = |limit: f64| log.times().iter().take_while(|ns| **ns as f64 <= limit * 1e9 + 0.5).count();
    let end = args.to.map_or(log.times().len(), before);
    let start =
        args.from.map_or(0, |from| log.times().iter().take_while(|ns| (**ns as f64) < from * 1e9 - 0.5).count());
    if end < start + 2 {
        let last = log.times().last().map_or(0.0, |ns| *ns as f64 / 1e9);
        return Err(Failure::Usage(format!(
            "there are {} samples in that span; {} ends at {last} s",
            end.saturating_sub(start),
            log.path().display()
        )));
    }
    Ok(start..end)
}
