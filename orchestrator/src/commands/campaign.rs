//! `phalanx campaign`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;

use crate::campaign::{as_json, as_markdown, as_text, run_all};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::files;
use crate::run::leftovers::Scratch;
use crate::terminal;

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    /// For a terminal
    Text,
    /// For a document
    Markdown,
    /// For programs
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct CampaignArgs {
    /// Names of scenarios (see `phalanx list`) [default: all that have regression ranges or claims]
    pub(crate) scenarios: Vec<String>,
    /// How the tables are written
    #[arg(long, value_enum, default_value_t = TableFormat::Text)]
    pub(crate) format: TableFormat,
    /// Same as --format json
    #[arg(long)]
    pub(crate) json: bool,
    /// Where the tables go [default: stdout]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

pub(crate) fn campaign(catalog: &Catalog, args: &CampaignArgs) -> Result<(), Failure> {
    if let Some(out) = &args.out {
        files::prepare(out, &args.scenarios)?;
    }
    let folder = Scratch::create()?;
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{bar:32.cyan/dim} {pos} of {len} runs, {msg}") {
        bar.set_style(style);
    }
    let campaign = run_all(catalog, &args.scenarios, folder.path(), |done, all, name| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
        bar.set_message(name.to_string());
        if bar.is_hidden() {
            eprintln!("{done} of {all} runs: {name}");
        }
    })?;
    bar.finish_and_clear();
    let format = if args.json { TableFormat::Json } else { args.format };
    let text = match format {
        TableFormat::Text => as_text(&campaign),
        TableFormat::Markdown => as_markdown(&campaign, &command(args)),
        TableFormat::Json => format!("{}\n", Value::to_string(&as_json(&campaign))),
    };
    match &args.out {
        Some(path) => {
            files::write(path, text).map_err(Failure::system(format!("write {}", path.display())))?;
            println!("{}", path.display());
        }
        None => print!("{text}"),
    }
    if campaign.ok() { Ok(()) } else { Err(Failure::Missed) }
}

fn command(args: &CampaignArgs) -> String {
    let names: String = args.scenarios.iter().map(|name| format!(" {name}")).collect();
    format!("{} campaign{names} --format markdown", terminal::program())
}
