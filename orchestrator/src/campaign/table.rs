//! A campaign as text, Markdown and JSON.

use std::fmt::Write;

use formation::scenario::Published;
use serde_json::{Value, json};

use super::{Campaign, ClaimRow, JobResult, Selected};
use crate::judge::verdict::{Counts, Row, Verdict, factor, short};
use crate::terminal::counted;
use crate::terminal::table::{Left, Right, Table};

/// These metrics as a table; with published values, also what the thesis states and the verdict on it.
fn table_of(rows: &[&Row], is_published: bool) -> Table {
    let mut head =
        vec![("metric", Left), ("measured", Right), ("unit", Left), ("regression range", Right), ("in range", Left)];
    if is_published {
        head.extend([("thesis", Left), ("against the thesis", Left)]);
    }
    let mut table = Table::new(head).indented(4);
    for row in rows {
        let unit = row.definition.as_ref().map_or("", |definition| &*definition.unit);
        let mut cells = vec![row.id.clone(), short(row.value), unit.into(), row.range(), row.range_word().to_string()];
        if is_published {
            cells.extend([row.expectation.thesis.clone(), row.thesis_word()]);
        }
        table.row(cells);
    }
    table
}

/// Whether the thesis states anything about any metric.
fn is_published(variants: &[(&str, &JobResult)]) -> bool {
    let verdicts = variants.iter().filter_map(|(_, result)| result.verdict.as_ref());
    Counts::of(verdicts.flat_map(|verdict| &verdict.rows)).is_published()
}

/// The metrics that the thesis or a regression range says something about.
fn expected(verdict: &Verdict) -> Vec<&Row> {
    let is_expected = |row: &&Row| row.in_range().is_some() || row.against_thesis() != Published::NotStated;
    verdict.rows.iter().filter(is_expected).collect()
}

/// Every statement of the thesis that is not met, with its reason; `None` if all are met.
fn shortfalls(campaign: &Campaign) -> Option<Table> {
    let head = [
        ("scenario", Left),
        ("variant", Left),
        ("metric", Left),
        ("thesis", Left),
        ("measured", Right),
        ("ratio", Right),
        ("reason", Left),
    ];
    let mut table = Table::new(head);
    let mut is_empty = true;
    for (job, result) in campaign.own_runs() {
        for row in result.verdict.iter().flat_map(|verdict| &verdict.rows) {
            let Published::NotMet(ratio) = row.against_thesis() else { continue };
            is_empty = false;
            table.row([
                job.shipped.name.to_string(),
                job.variant.clone(),
                row.id.clone(),
                row.expectation.thesis.clone(),
                short(row.value),
                ratio.map_or(String::new(), factor),
                row.expectation.reason.clone(),
            ]);
        }
    }
    (!is_empty).then_some(table)
}

fn sides(claim: &ClaimRow) -> String {
    let one = |(left, relation, right): &(f64, &str, Option<f64>)| match right {
        Some(right) => format!("{} {relation} {}", short(*left), short(*right)),
        None => format!("{} {relation}", short(*left)),
    };
    let list: Vec<String> = claim.sides.iter().map(one).collect();
    match &claim.problem {
        Some(problem) => problem.lines().next().unwrap_or_default().to_string(),
        None => list.join("; "),
    }
}

/// Counts of a campaign: runs, regression ranges, the thesis, claims.
fn summary(campaign: &Campaign) -> Vec<String> {
    let verdicts = campaign.own_runs().filter_map(|(_, result)| result.verdict.as_ref());
    let counts = Counts::of(verdicts.flat_map(expected));
    let claims = campaign.claims.len();
    let broken = campaign.claims.iter().filter(|claim| !claim.holds).count();
    let mut sentences = vec![
        format!("{}.", counted(campaign.results.len(), "run")),
        format!("Regression: {} of {} values in range.", counts.in_range, counts.judged()),
    ];
    if counts.is_published() {
        sentences.push(format!("Against the thesis: {}.", counts.thesis()));
    }
    sentences.push(format!("Claims: {} of {claims} hold.", claims - broken));
    sentences
}

fn variants<'a>(campaign: &'a Campaign, selected: &'a Selected) -> Vec<(&'a str, &'a JobResult)> {
    let scenario = &selected.scenario;
    // A variant without a name is shown under that of its scenario.
    let title = |variant: &'a str| if variant.is_empty() { scenario.name.as_str() } else { variant };
    selected.variants().filter_map(|variant| Some((title(variant), campaign.of(&scenario.name, variant)?))).collect()
}

/// For a terminal: one line a metric.
pub fn as_text(campaign: &Campaign) -> String {
    let mut text = String::new();
    for selected in &campaign.selected {
        let scenario = &selected.scenario;
        let place = if scenario.thesis.is_empty() { String::new() } else { format!(" (thesis {})", scenario.thesis) };
        let _ = writeln!(text, "{}: {}{place}", scenario.name, scenario.title);
        let variants = variants(campaign, selected);
        let is_published = is_published(&variants);
        for (variant, result) in variants {
            let _ = writeln!(text, "\n  {variant}{}", ending(result));
            let Some(verdict) = &result.verdict else { continue };
            let rows = expected(verdict);
            if !rows.is_empty() {
                text.push_str(&table_of(&rows, is_published).text(None));
            }
        }
        for claim in campaign.claims.iter().filter(|claim| claim.scenario == scenario.name) {
            let verdict = if claim.holds { "holds " } else { "BROKEN" };
            let _ =
                writeln!(text, "\n  {verdict} {}\n         {}\n         {}", claim.text, claim.condition, sides(claim));
        }
        text.push('\n');
    }
    if let Some(table) = shortfalls(campaign) {
        text.push_str(&format!("Not met against the thesis:\n\n{}\n", table.text(None)));
    }
    text.push_str(&summary(campaign).join("\n"));
    text.push('\n');
    text
}

/// What the two verdicts mean.
const MEANING: &str = "
**Regression range**: is the value the one of the reference implementation? The ranges are around our own results; they tell whether a change
of the program changed a result. **Against the thesis**: is the printed statement met? A bound (`<= 2e-3`) is met or it is not; a printed
value (`= 0.2`) is met within 10 %; a statement in words is qualitative, and the claims below turn it into inequalities. `not met x1.25` is
the measured value relative to the printed one.
";

/// A page for the documentation.
pub fn as_markdown(campaign: &Campaign, command: &str) -> String {
    let beside = campaign.selected.iter().any(|selected| !selected.scenario.thesis.is_empty());
    let title = if beside { "Results beside the thesis" } else { "Results" };
    let mut text = format!("# {title}\n\nMade by `{command}`.\n\n");
    summary(campaign).iter().for_each(|sentence| text.push_str(&format!("- {sentence}\n")));
    if beside {
        text.push_str(MEANING);
    }
    if let Some(table) = shortfalls(campaign) {
        text.push_str(&format!("\n## Not met against the thesis\n\n{}", table.markdown()));
    }
    for selected in &campaign.selected {
        let scenario = &selected.scenario;
        let _ = writeln!(text, "\n## {} ({})", scenario.name, scenario.title);
        if !scenario.thesis.is_empty() {
            let _ = writeln!(text, "\nThesis {}.", scenario.thesis);
        }
        let variants = variants(campaign, selected);
        let is_published = is_published(&variants);
        for (variant, result) in variants {
            let _ = writeln!(text, "\n### {variant}{}\n", ending(result));
            let Some(verdict) = &result.verdict else { continue };
            let rows = expected(verdict);
            if rows.is_empty() {
                text.push_str("No expectations; the variant serves the claims below.\n");
                continue;
            }
            text.push_str(&table_of(&rows, is_published).markdown());
        }
        let claims: Vec<&ClaimRow> = campaign.claims.iter().filter(|claim| claim.scenario == scenario.name).collect();
        if claims.is_empty() {
            continue;
        }
        let mut table = Table::new([("claim", Left), ("check", Left), ("values", Left), ("", Left)]);
        for claim in claims {
            let with = if claim.with.is_empty() { String::new() } else { format!(" with `{}`", claim.with.join(", ")) };
            let check = format!("`{}`{with}", claim.condition.replace('`', ""));
            let verdict = if claim.holds { "holds" } else { "BROKEN" };
            table.row([claim.text.clone(), check, sides(claim), verdict.into()]);
        }
        text.push_str(&format!("\n### Claims\n\n{}", table.markdown()));
    }
    text
}

/// For programs.
pub fn as_json(campaign: &Campaign) -> Value {
    let runs: Vec<Value> = campaign
        .results
        .iter()
        .map(|(job, result)| {
            json!({
                "scenario": job.shipped.name, "variant": job.variant, "with": job.with, "steps": result.steps,
                "wall_s": result.wall, "stopped": result.stopped,
                "metrics": result.verdict.as_ref().map(Verdict::to_json),
                "assertions": result.findings.to_json(),
                "ok": result.verdict.as_ref().map(|verdict| verdict.ok() && result.findings.ok()),
            })
        })
        .collect();
    let claims: Vec<Value> = campaign
        .claims
        .iter()
        .map(|claim| {
            json!({
                "scenario": claim.scenario, "claim": claim.text, "check": claim.condition, "with": claim.with,
                "values": sides(claim), "holds": claim.holds,
            })
        })
        .collect();
    json!({"runs": runs, "claims": claims, "ok": campaign.ok()})
}

fn ending(result: &JobResult) -> String {
    let violated = result.findings.failure().map(|violated| format!(" ({})", violated.replace("\n   ", "")));
    match &result.stopped {
        Some(reason) => format!(" (stopped early: {reason}){}", violated.unwrap_or_default()),
        None => violated.unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use formation::scenario::Expectation;

    use super::*;

    #[test]
    fn columns_of_published_values_are_there_where_there_are_any() {
        let line = |thesis: &str| {
            let expectation = Expectation { thesis: thesis.into(), high: Some(4.0), ..Default::default() };
            let row = Row { id: "x".into(), value: 3.0, definition: None, expectation };
            let is_published = Counts::of([&row]).is_published();
            table_of(&[&row], is_published).markdown().lines().last().unwrap_or_default().to_string()
        };
        assert_eq!(line("<= 2"), "| x | 3 |  | <= 4 | ok | <= 2 | not met x1.50 |");
        assert_eq!(line(""), "| x | 3 |  | <= 4 | ok |");
    }
}
