//! What became of assertions, for people and for programs.

use serde_json::{Value, json};

use super::{Assertion, Severity, Signal};
use crate::judge::verdict::short;
use crate::terminal::table::{Left, Right, Table};

/// A value at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moment {
    pub(super) step: u64,
    pub(super) time: f64,
    pub(super) agent: u32,
    pub(super) value: f64,
}

/// A value beyond its bound, or a condition that does not hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The step.
    pub step: u64,
    /// Its time, s.
    pub time: f64,
    /// Number of the agent; 0 for all of them together.
    pub agent: u32,
    /// The value; the margin of a condition.
    pub value: f64,
    /// What it violates.
    pub limit: Limit,
}

/// What a value may violate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Its lower bound.
    Min(f64),
    /// Its upper bound.
    Max(f64),
    /// A condition.
    Condition,
}

/// What became of one assertion.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Its name.
    pub name: String,
    /// Its signal.
    pub signal: String,
    /// What a violation means.
    pub severity: Severity,
    /// The bounds; the strictest if they differ between agents.
    bounds: (f64, f64),
    /// Whether the signal is a condition, whose margin is compared.
    is_condition: bool,
    /// How many values were compared.
    pub checked: u64,
    /// How many of them were beyond a bound.
    pub violations: u64,
    /// The first of these.
    pub first: Option<Violation>,
    /// How far the worst value was within its bounds, and where; below 0 it was beyond.
    worst: Option<(f64, Moment)>,
}

impl Violation {
    /// In words, behind the name of the assertion.
    pub fn text(&self, signal: &str) -> String {
        let Self { time, value, .. } = self;
        let place = format!("{} at t = {} s: {signal}", who(self.agent), tidy(*time));
        match self.limit {
            _ if value.is_nan() => format!("{place} is NaN"),
            Limit::Min(bound) => format!("{place} = {} < {}", short(*value), short(bound)),
            Limit::Max(bound) => format!("{place} = {} > {}", short(*value), short(bound)),
            Limit::Condition => format!("{place} does not hold, margin {}", short(*value)),
        }
    }
}

impl Finding {
    pub(super) fn new(assertion: &Assertion) -> Self {
        let least = |bounds: &mut dyn Iterator<Item = f64>| bounds.fold(f64::INFINITY, f64::min);
        let most = |bounds: &mut dyn Iterator<Item = f64>| bounds.fold(f64::NEG_INFINITY, f64::max);
        let subjects = &assertion.subjects;
        Self {
            name: assertion.name.clone(),
            signal: assertion.signal.clone(),
            severity: assertion.severity,
            bounds: (most(&mut subjects.iter().map(|s| s.min)), least(&mut subjects.iter().map(|s| s.max))),
            is_condition: subjects.iter().any(|subject| matches!(subject.signal, Signal::Condition(_))),
            checked: 0,
            violations: 0,
            first: None,
            worst: None,
        }
    }

    /// Takes a value with its bounds and the limit that it violates.
    pub(super) fn take(&mut self, moment: Moment, (min, max): (f64, f64), limit: Option<Limit>) -> Option<Violation> {
        self.checked += 1;
        let (above_min, below_max) = (moment.value - min, max - moment.value);
        let margin = if moment.value.is_nan() { f64::NEG_INFINITY } else { above_min.min(below_max) };
        if self.worst.is_none_or(|(worst, _)| margin < worst) {
            self.worst = Some((margin, moment));
        }
        let limit = limit?;
        self.violations += 1;
        let Moment { step, time, agent, value } = moment;
        let violation = Violation { step, time, agent, value, limit };
        self.first.get_or_insert(violation);
        Some(violation)
    }

    /// Whether no value was beyond a bound.
    pub fn ok(&self) -> bool {
        self.violations == 0
    }

    /// Whether it fails the run.
    pub fn fails(&self) -> bool {
        !self.ok() && self.severity == Severity::Fail
    }

    /// What a violation is: `violated` or `warning`.
    pub(crate) fn kind(&self) -> &'static str {
        match self.severity {
            Severity::Fail => "violated",
            Severity::Warn => "warning",
        }
    }

    /// The bounds in words; the strictest if they differ between agents.
    pub fn bound(&self) -> String {
        match self.bounds {
            _ if self.is_condition => "margin >= 0".into(),
            (min, f64::INFINITY) => format!(">= {}", short(min)),
            (f64::NEG_INFINITY, max) => format!("<= {}", short(max)),
            (min, max) => format!("{} ... {}", short(min), short(max)),
        }
    }

    /// The value that came closest to a bound or was farthest beyond, in words; empty if none was compared.
    pub fn worst(&self) -> String {
        let Some((_, Moment { value, agent, time, .. })) = &self.worst else { return String::new() };
        format!("{} ({} at {} s)", short(*value), who(*agent), tidy(*time))
    }

    /// The time of that value, s; `None` if none was compared.
    pub fn worst_time(&self) -> Option<f64> {
        self.worst.map(|(_, moment)| tidy(moment.time))
    }

    /// The verdict in a word or two.
    pub fn word(&self) -> &'static str {
        match (self.ok(), self.checked, self.severity) {
            (true, 0, _) => "not reached",
            (true, ..) => "holds",
            (false, _, Severity::Fail) => "VIOLATED",
            (false, _, Severity::Warn) => "violated (warning)",
        }
    }

    /// What went wrong, first and worst, in a sentence; empty if nothing did.
    pub fn attention(&self) -> String {
        let Some(first) = &self.first else { return String::new() };
        format!("{}: {}: {}; worst {}", self.kind(), self.name, first.text(&self.signal), self.worst())
    }

    /// In one line, without its name: for the summary in the log.
    pub fn summary(&self) -> String {
        let Self { checked, violations, signal, .. } = self;
        let worst = self.worst.map_or_else(String::new, |(_, moment)| {
            format!("; worst {} ({} at {} s)", moment.value, who(moment.agent), tidy(moment.time))
        });
        let relation = if self.is_condition { ":" } else { "" };
        format!("{}: {signal}{relation} {}{worst}; {violations} of {checked} values beyond", self.word(), self.bound())
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        let number = |value: f64| value.is_finite().then_some(value);
        let moment =
            |agent: u32, time: f64, value: f64| json!({ "agent": agent, "time": time, "value": number(value) });
        json!({
            "name": self.name,
            "signal": self.signal,
            "severity": match self.severity { Severity::Fail => "fail", Severity::Warn => "warn" },
            "min": number(self.bounds.0),
            "max": number(self.bounds.1),
            "ok": self.ok(),
            "reached": self.checked > 0,
            "checked": self.checked,
            "violations": self.violations,
            "worst": self.worst.map(|(_, worst)| moment(worst.agent, worst.time, worst.value)),
            "first": self.first.map(|first| moment(first.agent, first.time, first.value)),
        })
    }
}

/// What became of all assertions of a run, in the order of the scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings(pub Vec<Finding>);

impl Findings {
    /// Whether nothing fails the run. Warnings do not.
    pub fn ok(&self) -> bool {
        !self.0.iter().any(Finding::fails)
    }

    /// What fails the run, in words; `None` if nothing does.
    pub fn failure(&self) -> Option<String> {
        let failed: Vec<String> = self
            .0
            .iter()
            .filter(|finding| finding.fails())
            .filter_map(|finding| Some(format!("{}: {}", finding.name, finding.first?.text(&finding.signal))))
            .collect();
        let count =
            if failed.len() == 1 { "an assertion is".into() } else { format!("{} assertions are", failed.len()) };
        (!failed.is_empty()).then(|| format!("{count} violated\n    {}", failed.join("\n    ")))
    }

    /// How many hold, in a sentence: one that was not evaluated does not hold.
    pub fn sentence(&self) -> String {
        let count = |word: &str| self.0.iter().filter(|finding| finding.word() == word).count();
        let all = [
            ("holds", "hold", "holds"),
            ("not reached", "were not reached", "was not reached"),
            ("violated (warning)", "are violated (warnings)", "is violated (a warning)"),
            ("VIOLATED", "are violated", "is violated"),
        ];
        let counts: Vec<(usize, &str, &str)> = all.map(|(word, many, one)| (count(word), many, one)).into();
        match counts.as_slice() {
            [(1, ..), rest @ ..] if rest.iter().all(|(count, ..)| *count == 0) => "The assertion holds.".into(),
            [(held, ..), rest @ ..] if rest.iter().all(|(count, ..)| *count == 0) => {
                format!("All {held} assertions hold.")
            }
            counts => {
                let shown = counts.iter().filter(|(count, ..)| *count > 0);
                if let [one] = self.0.as_slice() {
                    let word = all.iter().find(|(word, ..)| *word == one.word()).map_or(one.word(), |(.., said)| said);
                    return format!("The assertion {word}.");
                }
                let parts: Vec<String> = shown
                    .map(|(count, many, one)| format!("{count} {}", if *count == 1 { one } else { many }))
                    .collect();
                format!("Of {} assertions, {}.", self.0.len(), parts.join(", "))
            }
        }
    }

    /// A table for a terminal of so many columns, or for as many as it takes; empty if there are no assertions.
    pub fn table(&self, columns: Option<usize>) -> String {
        let wide = self.wide_table();
        let width = wide.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        if columns.is_none_or(|columns| width <= columns) {
            return wide;
        }
        // What does not fit into a line takes two.
        let lines = |f: &Finding| {
            let worst = f.worst();
            let worst = if worst.is_empty() { worst } else { format!(", worst {worst}") };
            format!("{}\n    {}: {}{worst}\n", f.name, f.word(), f.bound())
        };
        format!("assertions\n{}\n{}", "-".repeat(10), self.0.iter().map(lines).collect::<String>())
    }

    fn wide_table(&self) -> String {
        if self.0.is_empty() {
            return String::new();
        }
        let mut table = Table::new([("assertion", Left), ("bound", Right), ("worst", Left), ("", Left)]).ruled();
        for finding in &self.0 {
            table.row([finding.name.clone(), finding.bound(), finding.worst(), finding.word().to_string()]);
        }
        table.text(None)
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        self.0.iter().map(Finding::to_json).collect()
    }
}

fn who(agent: u32) -> String {
    if agent == 0 { "all agents".into() } else { format!("agent {agent}") }
}

/// A time without the dust that a product of step and number leaves in the last digits, s.
fn tidy(time: f64) -> f64 {
    (time * 1e9).round() / 1e9
}
