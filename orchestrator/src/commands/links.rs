//! `phalanx links`.

use std::path::PathBuf;

use clap::Args;
use formation::scenario::Selection;
use recording::Log;

use super::select::from_head;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::judge::verdict::short;
use crate::show::traffic::{Traffic, traffic};
use crate::terminal::columns;
use crate::terminal::table::{Left, Right, Table};

#[derive(Debug, Args)]
pub(crate) struct LinksArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn links(catalog: &Catalog, args: &LinksArgs) -> Result<(), Failure> {
    let assembly = from_head(catalog, &args.log, &Selection::default())?;
    let all = traffic(&Log::open(&args.log)?, &assembly.links());
    if args.json {
        println!("{}", serde_json::Value::Array(all.iter().map(Traffic::to_json).collect()));
        return Ok(());
    }
    if all.is_empty() {
        println!("{}: no links; a section [links] in the scenario makes them", args.log.display());
        return Ok(());
    }
    print!("{}", table(&all).text(columns()));
    let bytes: f64 = all.iter().map(Traffic::bytes).sum();
    let sent: u64 = all.iter().map(|link| link.sent).sum();
    let rate = bytes / all.first().map_or(1.0, |link| link.duration);
    println!(
        "\n{sent} messages, {} kB, {} kB/s; loss, delay and rate: measured (asked)",
        short(bytes / 1e3),
        short(rate / 1e3)
    );
    Ok(())
}

fn table(all: &[Traffic]) -> Table {
    let head = [
        ("link", Left),
        ("signal", Left),
        ("sent", Right),
        ("loss", Right),
        ("delay, s", Right),
        ("rate, Hz", Right),
        ("age, s: mean", Right),
        ("largest", Right),
        ("least interval, s", Right),
    ];
    let mut table = Table::new(head).ruled();
    for link in all {
        let [from, to] = link.asked.agents;
        let signal = link.asked.topic.rsplit('/').next().unwrap_or_default();
        let both = |measured: f64, asked: Option<f64>| {
            let asked = asked.map_or("-".into(), short);
            format!("{} ({asked})", short(measured))
        };
        table.row([
            format!("{from} -> {to}"),
            signal.into(),
            link.sent.to_string(),
            both(link.loss(), link.asked.loss),
            both(link.delay, link.asked.delay),
            both(link.rate(), link.asked.rate),
            short(link.mean_age),
            short(link.largest_age),
            short(link.least_interval),
        ]);
    }
    table
}
