//! `phalanx echo`.

use std::io::{ErrorKind, IsTerminal, stdout};
use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::show::export::{Table, write_aligned, write_rows};
use crate::show::view::{signals, topics};
use crate::terminal::columns;
use recording::Log;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  phalanx echo run.mcap agent_1/state
  phalanx echo run.mcap agent_1/state position --at 12.5
  phalanx echo run.mcap agent_2/command input --every 100
  phalanx echo run.mcap agent_2/command input > input.tsv

In a terminal, columns are aligned and numbers have six digits, or four where six do not fit.
In a pipe or a file, columns are separated by tabs and numbers are exact.")]
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
    /// Print numbers exactly and columns separated by tabs in a terminal, too
    #[arg(long)]
    pub(crate) exact: bool,
}

pub(crate) fn echo(args: &EchoArgs) -> Result<(), Failure> {
    let outline = Log::outline(&args.log)?;
    let channels = topics(&outline, &args.topic)?;
    let [channel] = channels.as_slice() else {
        let names: Vec<&str> = channels.iter().map(|channel| channel.topic.as_str()).collect();
        return Err(Failure::Usage(format!("echo prints one topic; {} means {}", args.topic, names.join(", "))));
    };
    let log = Log::open_for(&args.log, &|topic, _| topic == channel.topic)?;
    let mut table = Table::of(&log, channel);
    if let Some(field) = &args.field {
        let wanted = signals(&log, &format!("{}/{field}", channel.topic))?;
        table.keep(&wanted);
    }
    let count = log.times().len();
    let rows: Vec<usize> = match args.at {
        Some(time) => vec![sample_at(&log, time)?],
        None => (0..count).step_by(args.every as usize).collect(),
    };
    let out = stdout().lock();
    let written = match args.exact || !out.is_terminal() {
        true => write_rows(out, b'\t', &log, &table, rows).map(drop),
        false => write_aligned(out, columns(), &log, &table, rows),
    };
    match written {
        // The reader has closed the pipe, as `head` does.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Failure::system("write to the terminal")(error)),
        Ok(()) => Ok(()),
    }
}

/// The last sample at or before `time`, s.
fn sample_at(log: &Log, time: f64) -> Result<usize, Failure> {
    // Times are kept in whole nanoseconds: half of one forgives the rounding of a decimal number.
    let before = log.times().iter().take_while(|ns| **ns as f64 <= time * 1e9 + 0.5).count();
    before.checked_sub(1).ok_or_else(|| {
        let first = log.times().first().map_or(0.0, |ns| *ns as f64 / 1e9);
        Failure::Usage(format!("--at {time}: the first sample of {} is that of {first} s", log.path().display()))
    })
}
