//! A campaign as text, Markdown and JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::{Campaign, ClaimRow, JobResult, Selected};
use crate::judge::verdict::{Row, Verdict, short};
use crate::terminal::table::{Left, Right, Table};

/// A metric of the thesis beside ours.
struct Line<'a> {
    row: &'a Row,
    ratio: Option<f64>,
}

impl Line<'_> {
    /// Metric, published value, ours, ratio of both, band, verdict; without published values, neither these nor the ratio.
    fn cells(&self, is_published: bool) -> Vec<String> {
        let Row { id, value, expectation, .. } = self.row;
        let ratio = self.ratio.map_or(String::new(), |ratio| format!("{ratio:.2}"));
        let (band, word) = (self.row.band(), self.row.word().to_string());
        match is_published {
            true => vec![id.clone(), expectation.thesis.clone(), short(*value), ratio, band, word],
            false => vec![id.clone(), short(*value), band, word],
        }
    }
}

/// These metrics as a table.
fn table_of(lines: &[Line], is_published: bool) -> Table {
    let head = match is_published {
        true => {
            vec![("metric", Left), ("thesis", Right), ("ours", Right), ("ratio", Right), ("band", Right), ("", Left)]
        }
        false => vec![("metric", Left), ("measured", Right), ("band", Right), ("", Left)],
    };
    let mut table = Table::new(head).indented(4);
    lines.iter().for_each(|line| table.row(line.cells(is_published)));
    table
}

/// Whether published values of any metric are known.
fn is_published(variants: &[(&str, &JobResult)]) -> bool {
    let verdicts = variants.iter().filter_map(|(_, result)| result.verdict.as_ref());
    verdicts.flat_map(|verdict| &verdict.rows).any(|row| !row.expectation.thesis.is_empty())
}

/// The metrics that the thesis or a band says something about.
fn lines(verdict: &Verdict) -> Vec<Line<'_>> {
    let told = |row: &&Row| row.ok.is_some() || !row.expectation.thesis.is_empty();
    let ratio = |row: &Row| first_number(&row.expectation.thesis).map(|printed| row.value / printed);
    verdict.rows.iter().filter(told).map(|row| Line { row, ratio: ratio(row) }).collect()
}

/// The first number in what the thesis prints, `<= 2e-3`; `None` if it prints words.
fn first_number(text: &str) -> Option<f64> {
    let start = text.find(|c: char| c.is_ascii_digit())?;
    let number: String = text[start..].chars().take_while(|c| c.is_ascii_digit() || ".e-".contains(*c)).collect();
    let number = number.trim_end_matches(['.', 'e', '-']);
    number.parse().ok().filter(|value: &f64| *value != 0.0)
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

/// Counts of a campaign in one sentence.
fn summary(campaign: &Campaign) -> String {
    let verdicts = campaign.results.iter().filter(|(job, _)| job.with.is_empty());
    let rows: Vec<&Row> =
        verdicts.filter_map(|(_, result)| result.verdict.as_ref()).flat_map(|verdict| &verdict.rows).collect();
    let judged = rows.iter().filter(|row| row.ok.is_some()).count();
    let missed = rows.iter().filter(|row| row.ok == Some(false)).count();
    let broken = campaign.claims.iter().filter(|claim| !claim.holds).count();
    format!(
        "{} runs: {} of {judged} bands met, {} of {} claims hold.",
        campaign.results.len(),
        judged - missed,
        campaign.claims.len() - broken,
        campaign.claims.len()
    )
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
            let lines = lines(verdict);
            if lines.is_empty() {
                continue;
            }
            text.push_str(&table_of(&lines, is_published).text(None));
        }
        for claim in campaign.claims.iter().filter(|claim| claim.scenario == scenario.name) {
            let verdict = if claim.holds { "holds " } else { "BROKEN" };
            let _ =
                writeln!(text, "\n  {verdict} {}\n         {}\n         {}", claim.text, claim.condition, sides(claim));
        }
        text.push('\n');
    }
    text.push_str(&summary(campaign));
    text.push('\n');
    text
}

/// A page for the documentation.
pub fn as_markdown(campaign: &Campaign, command: &str) -> String {
    let beside = campaign.selected.iter().any(|selected| !selected.scenario.thesis.is_empty());
    let title = if beside { "Results beside the thesis" } else { "Results" };
    let mut text = format!("# {title}\n\nMade by `{command}`. {}\n", summary(campaign));
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
            let lines = lines(verdict);
            if lines.is_empty() {
                text.push_str("No bands; the variant serves the claims below.\n");
                continue;
            }
            text.push_str(&table_of(&lines, is_published).markdown());
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
    use crate::judge::assertions::Findings;

    #[test]
    fn columns_of_published_values_are_there_where_there_are_any() {
        let line = |thesis: &str| {
            let expectation = Expectation { thesis: thesis.into(), low: None, high: Some(4.0) };
            let row = Row { id: "x".into(), value: 3.0, ok: Some(true), expectation };
            let verdict = Verdict { rows: vec![row], not_held: None };
            let findings = Findings::default();
            let result = JobResult { verdict: Some(verdict), stopped: None, findings, steps: 1, wall: 0.0 };
            let is_published = is_published(&[("", &result)]);
            let cells = lines(result.verdict.as_ref().unwrap())[0].cells(is_published);
            cells.join(" ")
        };
        assert_eq!(line("<= 2"), "x <= 2 3 1.50 <= 4 ok");
        assert_eq!(line(""), "x 3 <= 4 ok");
    }

    #[test]
    fn printed_values_are_found_in_their_text() {
        assert_eq!(first_number("<= 2e-3"), Some(2e-3));
        assert_eq!(first_number("4.2 s (at 0.053)"), Some(4.2));
        assert_eq!(first_number("9e-2"), Some(9e-2));
        assert_eq!(first_number("bounded"), None);
        assert_eq!(first_number("0 in theory"), None);
        assert_eq!(first_number("> 300"), Some(300.0));
    }
}
