//! What a scenario file says should come out.

use schemars::JsonSchema;
use serde::Deserialize;

/// The acceptance band of a metric, and what the thesis prints for it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// The value or statement of the thesis, as printed.
    #[serde(default)]
    pub thesis: String,
    /// Lower end of the band; none if open.
    pub low: Option<f64>,
    /// Upper end of the band; none if open.
    pub high: Option<f64>,
}

impl Expectation {
    /// What is wrong with the band, if anything.
    pub(super) fn wrong(&self) -> Option<String> {
        let (low, high) = (self.low.unwrap_or(f64::NEG_INFINITY), self.high.unwrap_or(f64::INFINITY));
        match low <= high {
            true => None,
            false => Some(format!("expected a band with low <= high, found low = {low}, high = {high}")),
        }
    }

    /// Whether `value` lies in the band; `None` if there is no band.
    pub fn holds(&self, value: f64) -> Option<bool> {
        if self.low.is_none() && self.high.is_none() {
            return None;
        }
        Some(value >= self.low.unwrap_or(f64::NEG_INFINITY) && value <= self.high.unwrap_or(f64::INFINITY))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_closed_and_not_a_number_is_outside() {
        let band = Expectation { low: Some(1.0), high: Some(2.0), ..Default::default() };
        assert_eq!(band.holds(1.0), Some(true));
        assert_eq!(band.holds(2.1), Some(false));
        assert_eq!(band.holds(f64::NAN), Some(false));
        assert_eq!(Expectation::default().holds(1.0), None);
    }
}
