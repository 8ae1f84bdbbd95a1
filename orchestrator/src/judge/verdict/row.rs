//! One metric, against its regression range and against the thesis.

use std::fmt::Write;

use formation::scenario::{Expectation, Published};
use serde_json::{Value, json};

use crate::judge::metrics::Definition;

/// A metric with what was expected of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the metric.
    pub id: String,
    /// Its value; NaN if it has none.
    pub value: f64,
    /// What it means, if its set says so.
    pub definition: Option<Definition>,
    /// The regression range and the statement of the thesis.
    pub expectation: Expectation,
}

impl Row {
    /// Whether the value lies in the regression range; `None` without a range.
    pub fn in_range(&self) -> Option<bool> {
        self.expectation.in_range(self.value)
    }

    /// The value against the statement of the thesis.
    pub fn against_thesis(&self) -> Published {
        self.expectation.against_thesis(self.value)
    }

    /// The regression range, `1 ... 2` or `<= 2`; empty without a range.
    pub fn range(&self) -> String {
        match (self.expectation.low, self.expectation.high) {
            (Some(low), Some(high)) => format!("{} ... {}", short(low), short(high)),
            (Some(low), None) => format!(">= {}", short(low)),
            (None, Some(high)) => format!("<= {}", short(high)),
            (None, None) => String::new(),
        }
    }

    /// `ok` or `MISSED`; empty if there is no regression range.
    pub fn range_word(&self) -> &'static str {
        match self.in_range() {
            Some(true) => "ok",
            Some(false) => "MISSED",
            None => "",
        }
    }

    /// `met`, `not met x1.25`, `qualitative`; empty if the thesis states nothing.
    pub fn thesis_word(&self) -> String {
        match self.against_thesis() {
            Published::NotStated => String::new(),
            Published::NotMet(Some(ratio)) => format!("not met x{}", factor(ratio)),
            verdict => verdict.word().into(),
        }
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        let text = |text: &str| Some(text.to_string()).filter(|text| !text.is_empty());
        let definition =
            |of: fn(&Definition) -> &str| self.definition.as_ref().and_then(|definition| text(of(definition)));
        json!({
            "value": number(self.value),
            "symbol": self.definition.as_ref().and_then(|definition| text(&definition.symbol_of(&self.id))),
            "unit": definition(|definition| &definition.unit),
            "description": definition(|definition| &definition.text),
            "lo": self.expectation.low.map(number),
            "hi": self.expectation.high.map(number),
            "in_range": self.in_range(),
            "thesis": text(&self.expectation.thesis),
            "against_thesis": self.against_thesis().word(),
            "ratio": self.expectation.ratio(self.value).map(number),
            "reason": text(&self.expectation.reason),
        })
    }
}

/// JSON has no NaN and no infinity.
fn number(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// A factor with three digits, `1.25` or `482`.
pub(crate) fn factor(ratio: f64) -> String {
    match ratio.abs() {
        size if size < 0.01 => short(ratio),
        size if size < 10.0 => format!("{ratio:.2}"),
        size if size < 100.0 => format!("{ratio:.1}"),
        _ => short(ratio),
    }
}

/// Four significant digits, in the notation that is shorter to read.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        let sign = if value < 0.0 { "-inf" } else { "inf" };
        return if value.is_nan() { "-" } else { sign }.into();
    }
    let size = value.abs();
    if !(1e-3..1e5).contains(&size) {
        let text = format!("{value:.3e}");
        return match text.split_once('e') {
            Some((digits, exponent)) => format!("{}e{exponent}", without_zeros(digits)),
            None => text,
        };
    }
    let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
    let mut text = String::new();
    let result = write!(text, "{value:.decimals$}");
    debug_assert!(result.is_ok());
    without_zeros(&text).into()
}

/// A decimal fraction without zeros at its end.
fn without_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 2.345678e-4, 6e-4, 0.00187654, 56.26, 1229.4, 123456.0, f64::NAN, -0.422, 8.0].map(short);
        assert_eq!(shown, ["0", "2.346e-4", "6e-4", "0.001877", "56.26", "1229", "1.235e5", "-", "-0.422", "8"]);
        assert_eq!([1.249, 19.76, 482.0, 0.876, 0.0012].map(factor), ["1.25", "19.8", "482", "0.88", "0.0012"]);
    }

    #[test]
    fn the_range_and_the_thesis_are_two_questions() {
        let expectation =
            Expectation { thesis: "<= 7e-4".into(), reason: "step".into(), low: Some(8e-4), high: Some(9e-4) };
        let row = Row { id: "dx_p".into(), value: 8.75e-4, definition: None, expectation };
        assert_eq!((row.range_word(), row.thesis_word().as_str()), ("ok", "not met x1.25"));
        let json = row.to_json();
        assert_eq!((&json["in_range"], &json["against_thesis"]), (&Value::Bool(true), &json!("not met")));
        assert_eq!(json["reason"], "step");
        assert!((json["ratio"].as_f64().unwrap() - 1.25).abs() < 1e-12);
    }
}
