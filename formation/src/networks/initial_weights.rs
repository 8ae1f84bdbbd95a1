//! The weights that a network starts with, as scenario files give them.

use nalgebra::SMatrix;
use schemars::JsonSchema;
use serde::Deserialize;

/// Ŵ(0): one number for all entries, a number for each agent, one matrix for all agents, or a matrix for each agent.
///
/// ```
/// use formation::networks::InitialWeights;
/// let weights = InitialWeights::from(0.5).resolve::<2, 1>(3, 0).unwrap();
/// assert_eq!(weights.as_slice(), [0.5, 0.5]);
/// ```
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct InitialWeights(Rule);

#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number, a matrix (a list of rows), or a list with one of either per agent")]
enum Rule {
    Same(f64),
    EachSame(Vec<f64>),
    Matrix(Vec<Vec<f64>>),
    Each(Vec<Vec<Vec<f64>>>),
}

impl InitialWeights {
    /// The weights from `P` regressors to `D` outputs of agent number `agent` (from 0) out of `agents`.
    ///
    /// # Errors
    /// Says what was expected if the number of matrices, rows or columns does not fit, or a weight is not finite.
    pub fn resolve<const P: usize, const D: usize>(
        &self,
        agents: usize,
        agent: usize,
    ) -> Result<SMatrix<f64, P, D>, String> {
        let finite = |weight: f64| {
            weight.is_finite().then_some(weight).ok_or_else(|| format!("expected finite weights, found {weight}"))
        };
        let given = match &self.0 {
            Rule::EachSame(values) => values.len(),
            Rule::Each(matrices) => matrices.len(),
            Rule::Same(_) | Rule::Matrix(_) => agents,
        };
        if given != agents {
            return Err(format!("expected {agents} entries, one per agent, found {given}"));
        }
        let rows = match &self.0 {
            Rule::Same(value) => return finite(*value).map(SMatrix::repeat),
            Rule::EachSame(values) => return finite(values[agent]).map(SMatrix::repeat),
            Rule::Matrix(rows) => rows,
            Rule::Each(matrices) => &matrices[agent],
        };
        if rows.len() != P {
            return Err(format!("expected {P} rows of weights, one per regressor, found {}", rows.len()));
        }
        if let Some(row) = rows.iter().find(|row| row.len() != D) {
            return Err(format!("expected rows of {D} weights, found one of {}", row.len()));
        }
        rows.iter().flatten().try_for_each(|weight| finite(*weight).map(drop))?;
        Ok(SMatrix::from_fn(|row, column| rows[row][column]))
    }
}

impl From<f64> for InitialWeights {
    fn from(value: f64) -> Self {
        Self(Rule::Same(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights(rule: Rule) -> Result<SMatrix<f64, 2, 1>, String> {
        InitialWeights(rule).resolve(2, 1)
    }

    #[test]
    fn every_form_and_what_does_not_fit() {
        let matrix = |a, b| vec![vec![a], vec![b]];
        assert_eq!(weights(Rule::Same(2.0)).unwrap().as_slice(), [2.0, 2.0]);
        assert_eq!(weights(Rule::Matrix(matrix(1.0, 2.0))).unwrap().as_slice(), [1.0, 2.0]);
        assert_eq!(weights(Rule::Each(vec![matrix(1.0, 2.0), matrix(3.0, 4.0)])).unwrap().as_slice(), [3.0, 4.0]);
        assert_eq!(weights(Rule::EachSame(vec![1.0, 5.0])).unwrap().as_slice(), [5.0, 5.0]);
        assert!(weights(Rule::Each(vec![matrix(1.0, 2.0)])).unwrap_err().contains("2 entries"));
        assert!(weights(Rule::EachSame(vec![1.0; 3])).unwrap_err().contains("found 3"));
        assert!(weights(Rule::Matrix(vec![vec![1.0]])).unwrap_err().contains("2 rows"));
        assert!(weights(Rule::Matrix(vec![vec![1.0, 2.0]; 2])).unwrap_err().contains("rows of 1"));
        assert!(weights(Rule::Same(f64::NAN)).unwrap_err().contains("finite"));
    }
}
