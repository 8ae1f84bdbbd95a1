//! `phalanx check`.

use std::path::PathBuf;

use clap::Args;
use formation::scenario::Selection;
use serde_json::{Value, json};

use super::select::from_head;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::judge::assertions::{Findings, Watch};
use crate::judge::own;
use crate::judge::verdict::Verdict;
use crate::run::players::Player;
use crate::terminal::{columns, wrapped};

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// Hold the run against the regression ranges and the thesis even if it was overridden, swapped or cut short
    #[arg(long)]
    pub(crate) strict: bool,
    /// Print symbol, unit and meaning of every metric instead
    #[arg(long, conflicts_with = "json")]
    pub(crate) explain: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn check(catalog: &Catalog, args: &CheckArgs) -> Result<(), Failure> {
    let assembly = from_head(catalog, &args.log, &Selection::default())?;
    let scenario = &assembly.scenario;
    let (verdict, log) = Verdict::read(&catalog.metrics, scenario, &args.log, own::stream(&assembly, &args.log)?)?;
    let Some(verdict) = verdict else {
        return Err(Failure::Usage(format!(
            "{} holds no complete step; there is nothing to check",
            args.log.display()
        )));
    };
    if args.explain {
        print!("{}", verdict.explanation(columns()));
        return Ok(());
    }
    let recorded = log.steps().end - log.steps().start;
    let planned = scenario.context.timing.periods() + 1;
    let complete = recorded == planned;
    let findings = Watch::stream(&assembly, &args.log)?;
    let players: Vec<Player> = log.players().iter().map(Player::read).collect();
    let cut = (!complete).then(|| format!("the log ends after {recorded} of {planned} samples"));
    let verdict = held(verdict, &players, cut, args.strict);
    if args.json {
        let summary = json!({
            "scenario": scenario.name, "variant": scenario.variant, "complete": complete,
            "metrics": verdict.to_json(), "not_held": verdict.not_held, "assertions": findings.to_json(), "players": players_json(&players),
            "ok": complete && verdict.ok() && findings.ok(),
        });
        println!("{summary}");
    } else {
        print!("{}", verdict.table(columns()));
        print!("\n{}", verdict.summary(columns()));
        show_findings(&findings);
        show_players(&players);
        if !complete {
            println!("The log ends before the run: {recorded} of {planned} samples.");
        }
    }
    if let Some(violated) = findings.failure() {
        return Err(Failure::Violated(violated));
    }
    if complete && verdict.ok() { Ok(()) } else { Err(Failure::Missed) }
}

/// The table of assertions, and a sentence about it; nothing if there are none.
pub(super) fn show_findings(findings: &Findings) {
    if findings.0.is_empty() {
        return;
    }
    println!("\n{}", findings.table(columns()));
    println!("{}\n", findings.sentence());
}

/// What was played by others than Phalanx.
pub(super) fn show_players(players: &[Player]) {
    for player in players {
        println!("{}", wrapped(&format!("{}.", player.sentence()), columns()));
    }
}

pub(super) fn players_json(players: &[Player]) -> Vec<Value> {
    players.iter().map(Player::to_json).collect()
}

/// The verdict on a run with these players that ended early for the reason `cut`, if it did. Nothing is held against a run
/// that was swapped or cut short, unless it is `strict`.
pub(super) fn held(verdict: Verdict, players: &[Player], cut: Option<String>, strict: bool) -> Verdict {
    if strict {
        return verdict.strict();
    }
    let sentences: Vec<String> = players.iter().map(Player::sentence).collect();
    let swapped = (!sentences.is_empty()).then(|| sentences.join("; "));
    verdict.not_held_since(swapped).not_held_since(cut)
}
