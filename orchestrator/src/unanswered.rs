//! Why a run that was asked something has not answered.

use std::io;
use std::time::Duration;

/// How long a run may take for its answer.
pub(crate) const PATIENCE: Duration = Duration::from_secs(5);

/// Why a run has not answered.
#[derive(Debug, thiserror::Error)]
pub enum Unanswered {
    /// There is no such run any more.
    #[error("the run {0} is over")]
    Over(String),
    /// Its control socket is not there yet, or not any more.
    #[error("the run {0} is starting or ending and cannot be asked at this moment; try again")]
    Closed(String),
    /// Its orchestrator does not run.
    #[error(
        "the run {run} does not answer: its orchestrator, process {pid}, is stopped (Ctrl-Z or SIGSTOP); `fg` in its shell or \
         `kill -CONT {pid}` continues it"
    )]
    Stopped {
        /// Which one.
        run: String,
        /// Process id of its orchestrator.
        pid: i32,
    },
    /// Its orchestrator runs, but has no processor time.
    #[error("the run {run} has not answered within {} s{}; is the machine overloaded?", PATIENCE.as_secs(), process(.pid))]
    Silent {
        /// Which one.
        run: String,
        /// Process id of its orchestrator, if it is known.
        pid: Option<i32>,
    },
    /// It has been understood, and not done.
    #[error("the run {run} answers: {reason}")]
    Refused {
        /// Which one.
        run: String,
        /// Why.
        reason: String,
    },
    /// The operating system refuses something.
    #[error("ask the run {run}: {source}")]
    System {
        /// Which one.
        run: String,
        /// What it says.
        source: io::Error,
    },
}

fn process(pid: &Option<i32>) -> String {
    pid.map(|pid| format!(" (process {pid})")).unwrap_or_default()
}
