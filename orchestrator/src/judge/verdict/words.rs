//! A verdict in words: the table, the sentences below it, the meaning of the metrics.

use formation::scenario::Published;

use super::{Row, Verdict, short};
use crate::terminal::table::{Left, Right, Table};
use crate::terminal::{counted, wrapped};

/// How many values meet what was expected of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) in_range: usize,
    pub(crate) outside: usize,
    pub(crate) met: usize,
    pub(crate) not_met: usize,
    pub(crate) qualitative: usize,
    pub(crate) not_stated: usize,
}

impl Counts {
    pub(crate) fn of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Self {
        let mut counts = Self::default();
        for row in rows {
            match row.in_range() {
                Some(true) => counts.in_range += 1,
                Some(false) => counts.outside += 1,
                None => {}
            }
            match row.against_thesis() {
                Published::Met => counts.met += 1,
                Published::NotMet(_) => counts.not_met += 1,
                Published::Qualitative => counts.qualitative += 1,
                Published::NotStated => counts.not_stated += 1,
            }
        }
        counts
    }

    /// Number of values that have a regression range.
    pub(crate) fn judged(self) -> usize {
        self.in_range + self.outside
    }

    /// Whether the thesis states anything about any of them.
    pub(crate) fn is_published(self) -> bool {
        self.met + self.not_met + self.qualitative > 0
    }

    /// `5 met, 4 not met, 8 qualitative, 13 not stated`.
    pub(crate) fn thesis(self) -> String {
        let Self { met, not_met, qualitative, not_stated, .. } = self;
        format!("{met} met, {not_met} not met, {qualitative} qualitative, {not_stated} not stated")
    }
}

impl Verdict {
    /// How many of its values meet what was expected.
    pub(crate) fn counts(&self) -> Counts {
        Counts::of(&self.rows)
    }

    /// The table `metric | measured | regression range | | thesis | against the thesis` for a terminal of so many columns, or as
    /// wide as it is; without the last two columns if the thesis states nothing.
    pub fn table(&self, columns: Option<usize>) -> String {
        let held = self.not_held.is_none();
        let is_ranged = self.rows.iter().any(|row| row.in_range().is_some());
        let mut head = vec![("metric", Left), ("measured", Right)];
        if is_ranged {
            head.extend([("regression range", Right), ("", Left)]);
        }
        let is_published = self.counts().is_published();
        if is_published {
            head.extend([("thesis", Left), ("against it", Left)]);
        }
        let mut table = Table::new(head).ruled();
        for row in &self.rows {
            let word = if held || row.in_range().is_none() { row.range_word() } else { "not held" };
            let mut cells = vec![row.id.clone(), short(row.value)];
            if is_ranged {
                cells.extend([row.range(), word.into()]);
            }
            if is_published {
                let word = if held { row.thesis_word() } else { String::new() };
                cells.extend([row.expectation.thesis.clone(), word]);
            }
            table.row(cells);
        }
        table.text(columns)
    }

    /// What the table says, in sentences: the regression ranges, the thesis, and why statements of it are not met.
    pub fn summary(&self, columns: Option<usize>) -> String {
        let counts = self.counts();
        if let Some(reason) = &self.not_held {
            let what = match (counts.judged() > 0, counts.is_published()) {
                (false, false) => return format!("{NO_RANGES}\n"),
                (_, false) => "regression ranges",
                (false, true) => "the thesis",
                (true, true) => "the thesis or the regression ranges",
            };
            let text = format!(
                "Not held against {what}: {reason}. They belong to the scenario as it is in its file; `--strict` applies them."
            );
            return wrapped(&text, columns) + "\n";
        }
        let mut text = wrapped(&regression(counts), columns) + "\n";
        if counts.is_published() {
            text += &wrapped(&format!("Against the thesis: {}.", counts.thesis()), columns);
            text.push('\n');
        }
        for row in self.rows.iter().filter(|row| matches!(row.against_thesis(), Published::NotMet(_))) {
            let reason = if row.expectation.reason.is_empty() { "" } else { ": " };
            let line = format!("  {} {}{reason}{}", row.id, row.thesis_word(), row.expectation.reason);
            text += &wrapped(&line, columns);
            text.push('\n');
        }
        text
    }

    /// Symbol, unit and meaning of every metric.
    pub fn explanation(&self, columns: Option<usize>) -> String {
        let mut table = Table::new([("metric", Left), ("symbol", Left), ("unit", Left), ("meaning", Left)]).ruled();
        for row in &self.rows {
            let cells = match &row.definition {
                Some(one) => [one.symbol_of(&row.id).into_owned(), one.unit.to_string(), one.text.to_string()],
                None => [String::new(), String::new(), "not described by its set of metrics".into()],
            };
            let [symbol, unit, meaning] = cells;
            table.row([row.id.clone(), symbol, unit, meaning]);
        }
        table.text(columns)
    }
}

const NO_RANGES: &str = "There are no regression ranges: no [expect] in the scenario.";

fn regression(counts: Counts) -> String {
    let judged = counts.judged();
    match (judged, counts.outside) {
        (0, _) => NO_RANGES.into(),
        (1, 0) => "Regression: the value is in its range, as in the reference implementation.".into(),
        (_, 0) => format!("Regression: all {judged} values are in range, as in the reference implementation."),
        (_, outside) => format!("Regression: {outside} of {} are outside their ranges.", counted(judged, "value")),
    }
}

#[cfg(test)]
mod tests {
    use formation::scenario::Expectation;

    use super::*;
    use crate::judge::metrics::Definition;

    fn row(thesis: &str, reason: &str, value: f64) -> Row {
        let expectation = Expectation { thesis: thesis.into(), reason: reason.into(), low: None, high: Some(2.0) };
        Row { id: "x".into(), value, definition: None, expectation }
    }

    #[test]
    fn a_missing_value_misses_its_range() {
        let verdict = Verdict { rows: vec![row("<= 2", "", 1.0), row("<= 2", "", f64::NAN)], not_held: None };
        assert!(!verdict.ok());
        assert_eq!(verdict.missed(), 1);
        let table = verdict.table(None);
        assert!(table.contains("MISSED") && table.contains("thesis") && table.lines().count() == 4, "{table}");
        assert_eq!(verdict.to_json()["x"]["value"], serde_json::Value::Null);
    }

    #[test]
    fn a_statement_that_is_not_met_is_told_with_its_reason_and_fails_nothing() {
        let verdict = Verdict { rows: vec![row("<= 1", "the step size is not printed", 1.5)], not_held: None };
        assert!(verdict.ok());
        let text = verdict.summary(None);
        assert!(text.contains("the value is in its range"), "{text}");
        assert!(text.contains("0 met, 1 not met, 0 qualitative, 0 not stated"), "{text}");
        assert!(text.contains("x not met x1.50: the step size is not printed"), "{text}");
    }

    #[test]
    fn expectations_of_another_run_are_not_held_against_this_one() {
        let verdict = Verdict { rows: vec![row("", "", 3.0)], not_held: None };
        assert!(!verdict.ok());
        let other =
            verdict.not_held_since(Some("overridden: phase=1".into())).not_held_since(Some("interrupted".into()));
        assert_eq!(other.not_held.as_deref(), Some("overridden: phase=1; interrupted"));
        assert!(other.ok() && other.missed() == 1 && other.table(None).contains("not held"), "{}", other.table(None));
        assert!(!other.table(None).contains("thesis"), "no published value is known: {}", other.table(None));
        assert!(other.summary(None).contains("overridden: phase=1"), "{}", other.summary(None));
        assert!(!other.strict().ok());
    }

    #[test]
    fn an_explanation_has_symbol_unit_and_meaning() {
        static WIDTH: Definition = Definition::new("x", "‖x‖", "m", "How far.");
        let mut known = row("", "", 1.0);
        known.definition = Some(WIDTH.clone());
        let text = Verdict { rows: vec![known], not_held: None }.explanation(None);
        assert!(text.contains("‖x‖") && text.contains("How far."), "{text}");
    }
}
