//! `phalanx export`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::failure::Failure;
use crate::files;
use crate::show::export::ExportFormat;
use crate::show::export::{Table, write_csv, write_mat, write_npz, write_parquet};
use crate::show::view::topics;
use recording::{Log, LogChannel};

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

pub(crate) fn export(args: &ExportArgs) -> Result<(), Failure> {
    let log = Log::open(&args.log)?;
    let tables = wanted(&log, &args.topics)?;
    let every = usize::try_from(args.every).unwrap_or(usize::MAX);
    let out = args.out.clone().unwrap_or_else(|| default_out(&args.log, args.format));
    files::spare(&out, [&args.log])?;
    let failed = |path: &Path| Failure::system(format!("write {}", path.display()));
    match args.format {
        ExportFormat::Csv => each(&tables, &out, "csv", |path, table| write_csv(path, &log, table, every))?,
        ExportFormat::Parquet => {
            each(&tables, &out, "parquet", |path, table| write_parquet(path, &log, table, every))?;
        }
        ExportFormat::Npz => write_npz(&out, &log, &tables, every).map_err(failed(&out))?,
        ExportFormat::Mat => write_mat(&out, &log, &tables, every).map_err(failed(&out))?,
    }
    let rows = log.times().len().div_ceil(every);
    println!("{}: {} topics, {rows} samples each.", out.display(), tables.len());
    Ok(())
}

/// A file for each table, in the folder `out`.
fn each(
    tables: &[Table],
    out: &Path,
    ending: &str,
    write: impl Fn(&Path, &Table) -> std::io::Result<()>,
) -> Result<(), Failure> {
    std::fs::create_dir_all(out).map_err(Failure::system(format!("create the folder {}", out.display())))?;
    tables.iter().try_for_each(|table| {
        let path = out.join(format!("{}.{ending}", table.name));
        write(&path, table).map_err(Failure::system(format!("write {}", path.display())))
    })
}

/// The topics that any of the patterns means, all if there is no pattern; in the order of the log.
fn wanted<'a>(log: &'a Log, patterns: &[String]) -> Result<Vec<Table<'a>>, Failure> {
    let mut chosen: Vec<&LogChannel> = Vec::new();
    for pattern in patterns {
        chosen.extend(topics(log, pattern)?);
    }
    let is_chosen = |channel: &&LogChannel| patterns.is_empty() || chosen.iter().any(|c| c.topic == channel.topic);
    let channels = log.channels().iter().filter(|channel| channel.layout.is_some()).filter(is_chosen);
    Ok(channels.map(|channel| Table::of(log, channel)).collect())
}

fn default_out(log: &Path, format: ExportFormat) -> PathBuf {
    let folder = |format: &str| {
        log.with_file_name(format!("{}-{format}", log.file_stem().unwrap_or_default().to_string_lossy()))
    };
    match format {
        ExportFormat::Csv => folder("csv"),
        ExportFormat::Parquet => folder("parquet"),
        ExportFormat::Npz => log.with_extension("npz"),
        ExportFormat::Mat => log.with_extension("mat"),
    }
}
