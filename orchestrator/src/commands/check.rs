//! `phalanx check`.

use serde_json::{Value, json};

use super::select::from_head;
use crate::catalog::Catalog;
use crate::cli::CheckArgs;
use crate::failure::Failure;
use crate::judge::assertions::{Findings, Watch};
use crate::judge::verdict::Verdict;
use crate::run::players::Player;
use crate::terminal::{columns, wrapped};

pub(crate) fn check(catalog: &Catalog, args: &CheckArgs) -> Result<(), Failure> {
    let assembly = from_head(catalog, &args.log, Vec::new())?;
    let scenario = &assembly.scenario;
    let (verdict, log) = Verdict::read(catalog, scenario, &args.log)?;
    let Some(verdict) = verdict else {
        return Err(Failure::Usage(format!(
            "{} holds no complete step; there is nothing to check",
            args.log.display()
        )));
    };
    let recorded = log.steps().end - log.steps().start;
    let complete = recorded == scenario.context.timing.periods() + 1;
    let findings = Watch::stream(&assembly, &args.log)?;
    let players: Vec<Player> = log.players().iter().map(Player::read).collect();
    if args.json {
        let summary = json!({
            "scenario": scenario.name, "variant": scenario.variant, "complete": complete,
            "metrics": verdict.to_json(), "assertions": findings.to_json(), "players": players_json(&players),
            "ok": complete && verdict.ok() && findings.ok(),
        });
        println!("{summary}");
    } else {
        print!("{}", verdict.table());
        println!("\n{}", summary_line(&verdict, &scenario.overrides));
        show_findings(&findings);
        show_players(&players);
        if !complete {
            println!("The log ends before the run: {recorded} of {} samples.", scenario.context.timing.periods() + 1);
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
    let failed = findings.0.iter().filter(|finding| finding.fails()).count();
    let warned = findings.0.iter().filter(|finding| !finding.ok()).count() - failed;
    let text = match (findings.0.len(), failed, warned) {
        (1, 0, 0) => "The assertion holds.".to_string(),
        (count, 0, 0) => format!("All {count} assertions hold."),
        (count, 0, _) => format!("{} of {count} assertions hold, the rest only warn.", count - warned),
        (count, ..) => format!("{failed} of {count} assertions are violated."),
    };
    println!("{text}\n");
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

/// One sentence about the bands.
pub(super) fn summary_line(verdict: &Verdict, overrides: &[String]) -> String {
    let judged = verdict.rows.iter().filter(|row| row.ok.is_some()).count();
    let missed = verdict.missed();
    let note = match overrides {
        [] => String::new(),
        several => format!(" (the bands are those without the overrides {})", several.join(", ")),
    };
    match (judged, missed) {
        (0, _) => "There are no bands for this variant.".into(),
        (_, 0) => format!("All {judged} bands are met{note}."),
        _ => format!("{missed} of {judged} bands are missed{note}."),
    }
}
