//! What a scenario file says should come out.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::formula::Relation;

/// How far a value may be from a printed one that is no bound, relative to it.
const TOLERANCE: f64 = 0.1;

/// The regression range of a metric, and what the thesis states about it. These are two questions: whether a value is the one of the
/// reference implementation, and whether it meets what was published.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// What the thesis states: a bound (`<= 2e-3`, `> 0`), a value (`= 0.2`, met within 10 %) or words. A unit and remarks may follow
    /// the number.
    #[serde(default)]
    pub thesis: String,
    /// Why the statement is not met, or how the value may be compared with it.
    #[serde(default)]
    pub reason: String,
    /// Lower end of the regression range; open if missing.
    pub low: Option<f64>,
    /// Upper end of the regression range; open if missing.
    pub high: Option<f64>,
}

/// A value against the statement of the thesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Published {
    /// The thesis states nothing about it.
    NotStated,
    /// The statement is in words; the claims of a scenario turn such statements into inequalities.
    Qualitative,
    /// The bound or the value is met.
    Met,
    /// It is not met; the measured value relative to the printed one, if that is not zero.
    NotMet(Option<f64>),
}

impl Published {
    /// `met`, `not met`, `qualitative` or `not stated`.
    pub fn word(self) -> &'static str {
        match self {
            Self::NotStated => "not stated",
            Self::Qualitative => "qualitative",
            Self::Met => "met",
            Self::NotMet(_) => "not met",
        }
    }
}

/// A statement that is a number: a bound, or a value if it has no relation.
struct Statement {
    bound: Option<Relation>,
    number: f64,
}

impl Statement {
    /// `None` if the text is words.
    fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let (bound, rest) = match Relation::strip(text) {
            Some((relation, rest)) => (Some(relation), rest),
            None => (None, text.strip_prefix('=').unwrap_or(text)),
        };
        let number = rest.split_whitespace().next()?.trim_end_matches([',', ';']).parse().ok()?;
        Some(Self { bound, number })
    }

    fn holds(&self, value: f64) -> bool {
        match self.bound {
            Some(relation) => relation.holds(value, self.number),
            None => (value - self.number).abs() <= TOLERANCE * self.number.abs(),
        }
    }
}

impl Expectation {
    /// What is wrong with it, if anything.
    pub(super) fn wrong(&self) -> Option<String> {
        let (low, high) = (self.low.unwrap_or(f64::NEG_INFINITY), self.high.unwrap_or(f64::INFINITY));
        let is_relation = self.thesis.trim_start().starts_with(['<', '>', '=']);
        if is_relation && Statement::parse(&self.thesis).is_none() {
            return Some(format!("expected a number after the relation, such as \"<= 2e-3\", found {:?}", self.thesis));
        }
        if !self.reason.is_empty() && self.thesis.is_empty() {
            return Some("a reason needs the statement that it is about, `thesis`".into());
        }
        match low <= high {
            true => None,
            false => Some(format!("expected a range with low <= high, found low = {low}, high = {high}")),
        }
    }

    /// Whether `value` lies in the regression range; `None` without a range.
    pub fn in_range(&self, value: f64) -> Option<bool> {
        if self.low.is_none() && self.high.is_none() {
            return None;
        }
        Some(value >= self.low.unwrap_or(f64::NEG_INFINITY) && value <= self.high.unwrap_or(f64::INFINITY))
    }

    /// `value` against the statement of the thesis.
    pub fn against_thesis(&self, value: f64) -> Published {
        match Statement::parse(&self.thesis) {
            None if self.thesis.is_empty() => Published::NotStated,
            None => Published::Qualitative,
            Some(statement) if statement.holds(value) => Published::Met,
            Some(_) => Published::NotMet(self.ratio(value)),
        }
    }

    /// `value` relative to the number that the thesis prints, if it prints one that is not zero.
    pub fn ratio(&self, value: f64) -> Option<f64> {
        let ratio = value / Statement::parse(&self.thesis)?.number;
        ratio.is_finite().then_some(ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stated(thesis: &str) -> Expectation {
        Expectation { thesis: thesis.into(), ..Default::default() }
    }

    #[test]
    fn ranges_are_closed_and_not_a_number_is_outside() {
        let range = Expectation { low: Some(1.0), high: Some(2.0), ..Default::default() };
        assert_eq!(range.in_range(1.0), Some(true));
        assert_eq!(range.in_range(2.1), Some(false));
        assert_eq!(range.in_range(f64::NAN), Some(false));
        assert_eq!(Expectation::default().in_range(1.0), None);
    }

    #[test]
    fn a_bound_is_met_or_not_whatever_the_range() {
        assert_eq!(stated("<= 7e-4").against_thesis(7e-4), Published::Met);
        assert_eq!(stated("<= 8").against_thesis(10.0), Published::NotMet(Some(1.25)));
        assert_eq!(stated("< 0").against_thesis(0.0), Published::NotMet(None));
        assert_eq!(stated(">= 0.1 m").against_thesis(0.134), Published::Met);
        assert_eq!(stated("> 300").against_thesis(f64::NAN), Published::NotMet(None));
    }

    #[test]
    fn a_value_is_met_within_ten_per_cent() {
        assert_eq!(stated("= 0.2").against_thesis(0.219), Published::Met);
        assert_eq!(stated("= 8.5, largest from 20 s on").against_thesis(17.0), Published::NotMet(Some(2.0)));
        assert_eq!(stated("4.2 s").against_thesis(4.2), Published::Met);
        assert_eq!(stated("= 0").against_thesis(0.0), Published::Met);
        assert_eq!(stated("= 0").against_thesis(1e-9), Published::NotMet(None));
    }

    #[test]
    fn words_are_qualitative_and_silence_is_not_stated() {
        for words in ["bounded", "-> 0", "at 0.053: 4.2 s", "zero in theory"] {
            assert_eq!(stated(words).against_thesis(1.0), Published::Qualitative, "{words}");
        }
        assert_eq!(stated("").against_thesis(1.0), Published::NotStated);
        assert_eq!(stated("<= 2 s").ratio(3.0), Some(1.5));
    }

    #[test]
    fn a_relation_needs_a_number_and_a_reason_a_statement() {
        assert!(stated("<= small").wrong().is_some_and(|text| text.contains("after the relation")));
        let lonely = Expectation { reason: "sampling".into(), ..Default::default() };
        assert!(lonely.wrong().is_some_and(|text| text.contains("thesis")));
        assert_eq!(stated("bounded").wrong(), None);
    }
}
