//! Links that come and go with the distance between agents.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::{Deserializer, Error};

use crate::config::FormulaText;
use crate::formula::{Expression, Formula, Operand};
use crate::math::TopologySchedule;

/// A link between agents that are close to each other: `f(z) = f_max / (1 + exp(f_slope (z - f_mid)))` up to the range (4.5), or
/// `weight`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Proximity {
    /// Whether there are such links; without them the graph is the static one.
    #[serde(default = "on")]
    pub enabled: bool,
    /// Range of communication, m.
    #[serde(rename = "Rc")]
    pub range: f64,
    /// Weight of two agents in one place, nearly.
    #[serde(default = "missing")]
    #[schemars(with = "Option<f64>")]
    pub f_max: f64,
    /// Steepness, 1/m.
    #[serde(default = "missing")]
    #[schemars(with = "Option<f64>")]
    pub f_slope: f64,
    /// Distance of half that weight, m.
    #[serde(default = "missing")]
    #[schemars(with = "Option<f64>")]
    pub f_mid: f64,
    /// Instead of these three, the weight as a formula of `distance`, m: `"exp(-distance^2)"`. Below 0 it counts as 0.
    #[schemars(with = "Option<FormulaText>")]
    pub weight: Option<WeightFormula>,
}

/// A formula of the distance.
#[derive(Clone, Debug)]
pub struct WeightFormula {
    text: String,
    formula: Formula,
}

impl PartialEq for WeightFormula {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl<'de> Deserialize<'de> for WeightFormula {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let FormulaText(text) = FormulaText::deserialize(deserializer)?;
        let distance = |name: &str| (name == "distance").then_some(Operand::Slot(0));
        let compiled = Expression::parse(&text).and_then(|expression| expression.compile(distance));
        let wrong = |error: crate::formula::FormulaError| error.with_hint(&text, ["distance", "pi"]).within(&text);
        let formula = compiled.map_err(|error| D::Error::custom(wrong(error)))?;
        Ok(Self { text, formula })
    }
}

/// What is said of a field that is not there.
pub(super) const MISSING: &str = "missing";

fn missing() -> f64 {
    f64::NAN
}

fn on() -> bool {
    true
}

impl Proximity {
    /// Weight of the link between agents at distance `z`, in m.
    pub fn weight(&self, z: f64) -> f64 {
        if let Some(weight) = &self.weight {
            return if z <= self.range { weight.formula.evaluate(&[z]).max(0.0) } else { 0.0 };
        }
        if z <= self.range { self.f_max / (1.0 + libm::exp(self.f_slope * (z - self.f_mid))) } else { 0.0 }
    }

    /// What is wrong with these numbers: field and message.
    pub(super) fn findings(&self) -> Vec<(&'static str, String)> {
        let fields = [("f_max", self.f_max), ("f_slope", self.f_slope), ("f_mid", self.f_mid)];
        if let Some(weight) = &self.weight {
            let range = (!(self.range.is_finite() && self.range > 0.0))
                .then(|| ("Rc", format!("expected a range > 0 m, found {}", self.range)));
            let both = fields.iter().find(|(_, value)| !value.is_nan());
            let both =
                both.map(|(field, _)| (*field, "expected either f_max, f_slope and f_mid or weight".to_string()));
            let value = weight.formula.evaluate(&[0.5 * self.range]);
            let value = (!value.is_finite()).then(|| ("weight", format!("its value at half the range is {value}")));
            return [range, both, value].into_iter().flatten().collect();
        }
        let demands = [
            ("Rc", self.range, self.range > 0.0, "a range > 0 m"),
            ("f_max", self.f_max, self.f_max >= 0.0, "a weight >= 0"),
            ("f_slope", self.f_slope, true, "a finite number"),
            ("f_mid", self.f_mid, true, "a finite number"),
        ];
        let wrong = demands.into_iter().filter(|(_, value, admissible, _)| !(value.is_finite() && *admissible));
        let message = |field: &str, value: f64, expected: &str| match value.is_nan() && field != "Rc" {
            true => MISSING.to_string(),
            false => format!("expected {expected}, found {value}"),
        };
        wrong.map(|(field, value, _, expected)| (field, message(field, value, expected))).collect()
    }
}

/// The row of one agent in the adjacency matrix of this instant: static weights, and links to the agents that are near.
#[derive(Clone, Debug, PartialEq)]
pub struct AdjacencyRow {
    /// The static weights from each of these steps on, and that of the link to the reference.
    rows: Vec<(u64, Vec<f64>, f64)>,
    /// The one of this instant.
    current: usize,
    heard: Vec<usize>,
    proximity: Option<Proximity>,
    /// a_ij, one value per agent; 0 for the agent itself.
    pub weights: Vec<f64>,
}

impl AdjacencyRow {
    /// The row of `agent` (from 0) of a graph with these static links, and links by distance if there are any.
    pub fn new(topology: &TopologySchedule, proximity: Option<Proximity>, agent: usize) -> Self {
        let rows = topology
            .intervals()
            .iter()
            .map(|(start, graph)| (*start, graph.dense_row(agent), graph.b(agent)))
            .collect();
        let heard = match proximity {
            Some(_) => (0..topology.size()).filter(|&other| other != agent).collect(),
            None => topology.neighbourhood(agent).heard().to_vec(),
        };
        Self { weights: topology.first().dense_row(agent), rows, current: 0, heard, proximity }
    }

    /// Takes the static links of this step, before [`AdjacencyRow::update`].
    pub fn follow(&mut self, step: u64) {
        while self.rows.get(self.current + 1).is_some_and(|(start, ..)| *start <= step) {
            self.current += 1;
        }
    }

    /// b_i, the weight of the link to the reference at the step that was followed last.
    pub fn reference(&self) -> f64 {
        self.rows[self.current].2
    }

    /// The agents whose signals may matter, ascending: all others if links depend on the distance, else the in-neighbours.
    pub fn heard(&self) -> &[usize] {
        &self.heard
    }

    /// Sets a_ij for an agent `other` that is heard, at `distance` (m), and returns it. A static link stays as it is. (4.5)
    pub fn update(&mut self, other: usize, distance: f64) -> f64 {
        let fixed = self.rows[self.current].1[other];
        self.weights[other] = match &self.proximity {
            Some(proximity) if fixed == 0.0 => proximity.weight(distance),
            _ => fixed,
        };
        self.weights[other]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PROXIMITY: Proximity =
        Proximity { enabled: true, range: 1.5, f_max: 0.2, f_slope: 14.0, f_mid: 1.1, weight: None };

    fn row(proximity: Option<Proximity>) -> AdjacencyRow {
        let heard = if proximity.is_some() { vec![1, 2] } else { vec![2] };
        AdjacencyRow {
            rows: vec![(0, vec![0.0, 0.0, 1.0], 1.0)],
            current: 0,
            weights: vec![0.0, 0.0, 1.0],
            heard,
            proximity,
        }
    }

    proptest! {
        #[test]
        fn weights_fall_with_the_distance_and_end_at_the_range(z in 0.0..3.0f64, step in 0.0..0.5f64) {
            prop_assert!(PROXIMITY.weight(z + step) <= PROXIMITY.weight(z));
            prop_assert!((0.0..=0.2).contains(&PROXIMITY.weight(z)));
            prop_assert_eq!(PROXIMITY.weight(z) > 0.0, z <= 1.5);
        }

        #[test]
        fn a_static_link_does_not_feel_the_distance(z in 0.0..3.0f64) {
            prop_assert_eq!(row(Some(PROXIMITY)).update(2, z), 1.0);
            prop_assert_eq!(row(None).update(2, z), 1.0);
        }
    }

    #[test]
    fn half_at_the_middle_and_a_small_jump_at_the_range() {
        assert_eq!(PROXIMITY.weight(1.1), 0.1);
        assert!((PROXIMITY.weight(1.5) - 7.3685e-4).abs() < 1e-8);
        let mut row = row(Some(PROXIMITY));
        assert_eq!([row.update(1, 1.1), row.weights[1], row.update(1, 1.6), row.weights[1]], [0.1, 0.1, 0.0, 0.0]);
    }

    #[test]
    fn inadmissible_numbers_are_named() {
        assert!(PROXIMITY.findings().is_empty());
        let wrong = Proximity { range: -1.0, f_mid: f64::NAN, ..PROXIMITY };
        let fields: Vec<&str> = wrong.findings().into_iter().map(|(field, _)| field).collect();
        assert_eq!(fields, ["Rc", "f_mid"]);
    }
}
