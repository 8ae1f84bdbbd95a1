//! Why a log cannot be judged.

use formation::config::Problem;

use super::metrics::MetricError;
use recording::LogError;

/// Why a log cannot be judged.
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// It cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// It does not hold what its metrics need.
    #[error(transparent)]
    Metric(#[from] MetricError),
    /// Its scenario cannot be evaluated on it.
    #[error("{} problems in the scenario of the log", .0.len())]
    Scenario(Vec<Problem>),
}

impl From<Vec<Problem>> for JudgeError {
    fn from(problems: Vec<Problem>) -> Self {
        Self::Scenario(problems)
    }
}
