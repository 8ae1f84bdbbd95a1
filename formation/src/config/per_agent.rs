//! Numbers that differ between agents.

use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::brief;
use crate::formula::{Expression, Formula, Operand};

/// A number for every agent: one for all, a list, or a formula of the agent's number `i` and the number of agents `N`,
/// such as `"2*pi*i/N"`.
///
/// ```
/// use formation::config::PerAgent;
/// let one_for_all = PerAgent::from(0.5);
/// assert_eq!(one_for_all.resolve(3, &[1, 2, 3]), Ok(vec![0.5, 0.5, 0.5]));
/// ```
#[derive(Clone, Debug)]
pub struct PerAgent(Rule);

#[derive(Clone, Debug)]
enum Rule {
    Same(f64),
    Each(Vec<f64>),
    Formula { text: String, formula: Formula },
}

impl PerAgent {
    /// The values of the agents `ids`, which are all `agents`; a list has them in the order of `ids`.
    ///
    /// # Errors
    /// A list of another length than `agents`, or a formula without a finite value for some agent.
    pub fn resolve(&self, agents: usize, ids: &[u32]) -> Result<Vec<f64>, String> {
        ids.iter().enumerate().map(|(place, &id)| self.value(agents, place, id)).collect()
    }

    /// The value of the agent at `place` (from 0) out of `agents`, whose number is `id`.
    ///
    /// # Errors
    /// A list of another length than `agents`, or a formula without a finite value for this agent.
    pub fn value(&self, agents: usize, place: usize, id: u32) -> Result<f64, String> {
        match &self.0 {
            Rule::Same(value) => Ok(*value),
            Rule::Each(values) if values.len() == agents => Ok(values[place]),
            Rule::Each(values) => Err(format!("expected {agents} values, one for each agent, found {}", values.len())),
            Rule::Formula { text, formula } => {
                let value = formula.evaluate(&[f64::from(id), agents as f64]);
                let finite = value.is_finite().then_some(value);
                finite.ok_or_else(|| format!("the value of {:?} for agent {id} of {agents} is {value}", brief(text)))
            }
        }
    }
}

impl From<f64> for PerAgent {
    fn from(value: f64) -> Self {
        Self(Rule::Same(value))
    }
}

impl<'de> Deserialize<'de> for PerAgent {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RuleVisitor).map(PerAgent)
    }
}

struct RuleVisitor;

impl<'de> Visitor<'de> for RuleVisitor {
    type Value = Rule;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, a list of numbers, or a formula of i and N")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Rule, E> {
        Ok(Rule::Same(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Rule, E> {
        Ok(Rule::Same(value as f64))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Rule, E> {
        Ok(Rule::Same(value))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Rule, E> {
        let slot = |name: &str| match name {
            "i" => Some(Operand::Slot(0)),
            "N" => Some(Operand::Slot(1)),
            _ => None,
        };
        match Expression::parse(text).and_then(|expression| expression.compile(slot)) {
            Ok(formula) => Ok(Rule::Formula { text: text.into(), formula }),
            Err(error) => Err(E::custom(format!("not a formula of i and N: {}", error.within(text)))),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Rule, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = elements.next_element()? {
            values.push(value);
        }
        Ok(Rule::Each(values))
    }
}
