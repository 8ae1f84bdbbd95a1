//! Why a log cannot be played.

use lockstep::Period;
use std::path::PathBuf;

use crate::failure::Failure;
use recording::LogError;

/// Why a log cannot stand in for participants of a run.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file cannot be read, or is damaged.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log says nothing of its scenario.
    #[error("{} cannot be played: it holds no valid scenario{reason}; give a log that `phalanx run` recorded", .path.display())]
    NoScenario {
        /// The log.
        path: PathBuf,
        /// What is wrong with it, after a colon; empty if there is none.
        reason: String,
    },
    /// The log is that of another scenario.
    #[error("{} is a log of the scenario `{found}`, this run is one of `{expected}`", .path.display())]
    Scenario {
        /// The log.
        path: PathBuf,
        /// The scenario in the log.
        found: String,
        /// The scenario of the run.
        expected: String,
    },
    /// Steps of another length.
    #[error(
        "{} was recorded in steps of {found} s, this run has steps of {expected} s; run it with --dt {found}",
        .path.display()
    )]
    Period {
        /// The log.
        path: PathBuf,
        /// Step of the log.
        found: Period,
        /// Step of the run.
        expected: Period,
    },
    /// A run that takes longer than the recorded one was to take.
    #[error("{} is of a run of {found} s, this one takes {expected} s; run it with --duration {found}", .path.display())]
    Short {
        /// The log.
        path: PathBuf,
        /// Length of the recorded run, s.
        found: f64,
        /// Length of this run, s.
        expected: f64,
    },
    /// What a participant publishes is not in the log.
    #[error("{} has no topic {topic}, which {node} publishes; it holds {}", .path.display(), list(found))]
    Topic {
        /// The log.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The participant.
        node: String,
        /// The topics that are there.
        found: Vec<String>,
    },
    /// Samples of other fields.
    #[error(
        "{}: samples of {topic} hold {found}, those of this run {expected}; was it recorded with another component?",
        .path.display()
    )]
    Layout {
        /// The log.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The fields in the log.
        found: String,
        /// The fields in the run.
        expected: String,
    },
    /// The recording is over, or its steps are not those of the run.
    #[error("{} {what}", .path.display())]
    Step {
        /// The log.
        path: PathBuf,
        /// What is wrong, with the step.
        what: String,
    },
}

fn list(topics: &[String]) -> String {
    if topics.is_empty() {
        "none: its run was stopped before the first sample was written".into()
    } else {
        topics.join(", ")
    }
}

impl From<ReplayError> for Failure {
    fn from(error: ReplayError) -> Self {
        match error {
            ReplayError::Log(error) => Self::Log(error),
            other => Self::Usage(other.to_string()),
        }
    }
}
