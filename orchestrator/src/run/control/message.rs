//! What is asked of a run through its control socket, and what it answers: a line of text in, a line of JSON out.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::terminal::counted;

/// Between the words of a swap and the folder that its file names are relative to.
const FOLDER_MARK: char = '\t';

/// What may be asked of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Request {
    /// Hold the run before its next step.
    Pause,
    /// Let it continue.
    Resume,
    /// Run so many steps more, and hold it then.
    Step(u64),
    /// Let another program play a participant: `NODE=COMMAND`, and the folder that its file names are relative to.
    Swap(String, Option<PathBuf>),
    /// End the run in order.
    Stop,
    /// Halt all robots at once and end the run.
    Estop,
    /// Change nothing.
    Status,
}

/// A line that is no [`Request`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum RequestError {
    /// It begins with another word.
    #[error("expected pause, resume, step N, swap NODE=COMMAND, stop, estop or status")]
    Unknown,
    /// The number of steps is invalid.
    #[error("expected a number of steps")]
    Steps,
}

impl FromStr for Request {
    type Err = RequestError;

    fn from_str(line: &str) -> Result<Self, RequestError> {
        let line = line.trim();
        if let Some(text) = line.strip_prefix("swap ") {
            return Ok(match text.rsplit_once(FOLDER_MARK) {
                Some((text, folder)) => Self::Swap(text.into(), Some(folder.into())),
                None => Self::Swap(text.into(), None),
            });
        }
        match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["pause"] => Ok(Self::Pause),
            ["resume"] => Ok(Self::Resume),
            ["step", count] => count.parse().map(Self::Step).map_err(|_| RequestError::Steps),
            ["stop"] => Ok(Self::Stop),
            ["estop"] => Ok(Self::Estop),
            ["status"] => Ok(Self::Status),
            _ => Err(RequestError::Unknown),
        }
    }
}

impl Display for Request {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pause => f.write_str("pause"),
            Self::Resume => f.write_str("resume"),
            Self::Step(count) => write!(f, "step {count}"),
            Self::Swap(text, None) => write!(f, "swap {text}"),
            Self::Swap(text, Some(folder)) => write!(f, "swap {text}{FOLDER_MARK}{}", folder.display()),
            Self::Stop => f.write_str("stop"),
            Self::Estop => f.write_str("estop"),
            Self::Status => f.write_str("status"),
        }
    }
}

/// What a run is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum State {
    /// Its processes are not all connected yet.
    #[default]
    Starting,
    /// It runs its steps.
    Running,
    /// It is held.
    Paused,
    /// It waits for a program that takes the place of another one.
    Swapping,
    /// Its end was requested.
    Stopping,
}

/// How a run is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Status {
    /// Its name.
    pub(crate) run: String,
    /// Its scenario ...
    pub(crate) scenario: String,
    /// ... and variant.
    pub(crate) variant: String,
    /// Process id of the orchestrator.
    pub(crate) pid: u32,
    /// Number of processes, the orchestrator included.
    pub(crate) processes: u64,
    /// What it is doing.
    pub(crate) state: State,
    /// Whether it is paused.
    pub(crate) paused: bool,
    /// Whether its end was requested.
    pub(crate) stopping: bool,
    /// Steps that are done ...
    pub(crate) steps: u64,
    /// ... of so many.
    pub(crate) of: u64,
    /// Length of a step, s.
    pub(crate) dt: f64,
    /// Simulated time, s.
    pub(crate) time: f64,
    /// Time since the run was started, s.
    pub(crate) wall_s: f64,
    /// Where its log will be; `None` if it is not recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) log: Option<PathBuf>,
    /// Workers that the others wait for.
    pub(crate) awaited: Vec<String>,
    /// The processes of the participants.
    pub(crate) workers: Vec<WorkerStatus>,
    /// The first step that a program plays which was swapped in by this request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) swapped_at: Option<u64>,
}

/// Where the time of a process of a participant went.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct WorkerStatus {
    /// Its name.
    pub(crate) name: String,
    /// How often it has run.
    pub(crate) runs: u64,
    /// How often it was the last of its phase.
    pub(crate) last: u64,
    /// Time that it computed, s.
    pub(crate) compute_s: f64,
    /// Time from the opening of its gate to its start, s.
    pub(crate) waking_s: f64,
    /// Time that it waited for others, s.
    pub(crate) waiting_s: f64,
}

impl Status {
    /// How far a run is, in one line.
    pub(crate) fn sentence(&self) -> String {
        let word = match self.state {
            State::Starting => "is starting",
            State::Running => "runs",
            State::Paused => "is paused",
            State::Swapping => "waits for a program that takes the place of another one",
            State::Stopping => "is stopping",
        };
        let Self { run, steps, of, time, processes, pid, .. } = self;
        let title = format!("{} {}", self.scenario, self.variant);
        let title = title.trim();
        let processes = counted(*processes as usize, "process");
        format!("{run} ({title}) {word}: {steps} of {of} steps done, t = {time:.3} s, {processes}, pid {pid}")
    }
}

/// What comes back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum Answer {
    /// It was not done.
    Error {
        /// Why.
        error: String,
    },
    /// It is done, or under way.
    Status(Box<Status>),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_survives_its_line() {
        let requests = [
            Request::Pause,
            Request::Resume,
            Request::Step(10),
            Request::Swap("controller.3=./mine --gain 2".into(), Some("/home/me".into())),
            Request::Swap("plant=x".into(), None),
            Request::Stop,
            Request::Estop,
            Request::Status,
        ];
        for request in requests {
            assert_eq!(format!("{request}\n").parse(), Ok(request));
        }
        for line in ["", "  ", "estop now", "Stop", "swap", "step", "\0", "{}"] {
            assert_eq!(line.parse::<Request>(), Err(RequestError::Unknown), "{line:?}");
        }
        for line in ["step x", "step -1", "step 99999999999999999999"] {
            assert_eq!(line.parse::<Request>(), Err(RequestError::Steps), "{line:?}");
        }
    }

    #[test]
    fn an_answer_survives_its_line() {
        let status = Status { run: "uav".into(), state: State::Paused, swapped_at: Some(3), ..Status::default() };
        for answer in [Answer::Status(Box::new(status)), Answer::Error { error: "no".into() }] {
            let line = serde_json::to_string(&answer).unwrap();
            assert_eq!(serde_json::from_str::<Answer>(&line).unwrap(), answer);
        }
    }
}
