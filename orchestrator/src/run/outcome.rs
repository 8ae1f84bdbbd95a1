//! What came of a run.

use processes::{RunError, Snapshot};

use super::control::Pacing;
use crate::failure::Failure;
use crate::judge::assertions::Findings;
use recording::{LogError, Summary};

/// Why a run ended. The log reaches up to there.
#[derive(Debug)]
pub enum Ending {
    /// All steps are done.
    Complete,
    /// An assertion that stops the run was violated.
    Halted,
    /// The end was requested by Ctrl-C, a signal or `phalanx ctl stop`.
    Interrupted {
        /// The step that did not run any more.
        step: u64,
    },
    /// `phalanx ctl estop` ended the run.
    Emergency {
        /// The step that did not run any more.
        step: u64,
    },
    /// A step was late by a period or more, which is to end the run.
    TooLate {
        /// The step, which did not run any more.
        step: u64,
        /// How late it was, s.
        late: f64,
        /// What a period takes, s.
        period: f64,
    },
    /// A participant failed, and its policy did not replace it.
    Failed(RunError),
    /// The log could not be written.
    LogFailed(LogError),
}

impl Ending {
    /// Why the run did not come to its end, in words; `None` if all steps are done.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Complete => None,
            Self::Halted => Some("an assertion ended the run".into()),
            Self::Interrupted { step } | Self::Emergency { step } => {
                Some(RunError::Interrupted { step: *step }.to_string())
            }
            &Self::TooLate { step, late, period } => Some(Failure::TooLate { step, late, period }.to_string()),
            Self::Failed(error) => Some(error.to_string()),
            Self::LogFailed(error) => Some(error.to_string()),
        }
    }

    /// The ending in a word, for programs.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Halted => "halted",
            Self::Interrupted { .. } => "interrupted",
            Self::Emergency { .. } => "emergency",
            Self::TooLate { .. } => "too_late",
            Self::Failed(_) => "failed",
            Self::LogFailed(_) => "log_failed",
        }
    }

    /// Whether the run came to its end, or was ended by an assertion.
    pub fn is_whole(&self) -> bool {
        matches!(self, Self::Complete | Self::Halted)
    }

    /// An error unless the run came to its end, or was ended by an assertion.
    ///
    /// # Errors
    /// [`Failure`] with the exit code of this ending.
    pub fn into_result(self) -> Result<(), Failure> {
        match self {
            Self::Complete | Self::Halted => Ok(()),
            Self::Interrupted { .. } => Err(Failure::Interrupted),
            Self::Emergency { step } => Err(Failure::Emergency { step }),
            Self::TooLate { step, late, period } => Err(Failure::TooLate { step, late, period }),
            Self::Failed(error) => Err(Failure::Run(error)),
            Self::LogFailed(error) => Err(error.into()),
        }
    }
}

impl From<RunError> for Ending {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Interrupted { step } => Self::Interrupted { step },
            error => Self::Failed(error),
        }
    }
}

impl From<LogError> for Ending {
    fn from(error: LogError) -> Self {
        Self::LogFailed(error)
    }
}

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Number of periods that were simulated.
    pub steps: u64,
    /// Simulated time, s.
    pub simulated: f64,
    /// Time that it took, start and end of the processes not counted, s.
    pub wall: f64,
    /// Number of processes, the orchestrator included.
    pub processes: usize,
    /// The log, if there is one.
    pub log: Option<Summary>,
    /// Why the run ended.
    pub ending: Ending,
    /// What became of the assertions of the scenario.
    pub findings: Findings,
    /// Where its time went.
    pub usage: Snapshot,
    /// How well it kept the times that it was to keep.
    pub pacing: Option<Pacing>,
    /// How the cores were chosen, if they were.
    pub cores: Option<String>,
    /// Participants that another program took the place of, in words.
    pub replaced: Vec<String>,
    /// What failed after the log was closed: a trace that cannot be written, a directory that cannot be removed.
    pub leftover: Vec<Failure>,
}

impl Outcome {
    /// Steps per second of wall-clock time.
    pub fn steps_per_second(&self) -> f64 {
        self.steps as f64 / self.wall.max(1e-9)
    }

    /// An error unless the run came to its end, kept its assertions, and left nothing undone.
    ///
    /// # Errors
    /// [`Failure`] with the exit code of the first of these.
    pub fn into_result(self) -> Result<(), Failure> {
        self.ending.into_result()?;
        self.findings.failure().map_or(Ok(()), |violated| Err(Failure::Violated(violated)))?;
        self.leftover.into_iter().next().map_or(Ok(()), Err)
    }
}
