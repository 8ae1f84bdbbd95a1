//! Why a command did not succeed, and the exit code that tells.

use formation::config::Problem;
use processes::{Death, DirectoryError, RunError};
use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};

use crate::judge::JudgeError;
use crate::judge::metrics::MetricError;
use crate::unanswered::Unanswered;
use recording::LogError;

/// What to do about a limit of open files that is too low.
const FEW_FILES: &str =
    "a run needs about 20 open files per process: `ulimit -n` shows the limit, `ulimit -n 4096` allows more";
/// A limit of open files that is enough for any run of some participants.
const MANY_FILES: u64 = 1024;

/// Number of the signal.
const SIGBUS: i32 = rustix::process::Signal::BUS.as_raw();

/// Why a command ended without success.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A metric lies outside its regression range. Everything has been printed already.
    #[error("a metric is outside its regression range")]
    Missed,
    /// An assertion of the scenario was violated.
    #[error("{0}")]
    Violated(String),
    /// Two logs differ. Everything has been printed already.
    #[error("the logs differ")]
    Different,
    /// A program breaks the contract of a participant. Everything has been printed already.
    #[error("the program does not conform")]
    Nonconforming,
    /// The scenario or the command line is not valid; nothing was started.
    #[error("{}", list(.0))]
    Invalid(Vec<Problem>),
    /// The command line asks for something that is not there.
    #[error("{0}")]
    Usage(String),
    /// The run did not come to its end.
    #[error("the run stopped: {0}")]
    Run(RunError),
    /// The run was stopped by an emergency stop.
    #[error("emergency stop at step {step}: every robot of the run was told to stop")]
    Emergency {
        /// Where.
        step: u64,
    },
    /// A step could not start within its period, and the scenario says that this ends the run.
    #[error(
        "the run stopped: step {step} was due {late:.3} s ago when the step before was done, a period takes {period} s, and the \
         scenario says overrun = \"abort\""
    )]
    TooLate {
        /// Which.
        step: u64,
        /// How late, s.
        late: f64,
        /// What a period takes, s.
        period: f64,
    },
    /// The run was interrupted by Ctrl-C or a signal.
    #[error("interrupted")]
    Interrupted,
    /// A log cannot be written or read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A log does not hold what its metrics need.
    #[error(transparent)]
    Metric(#[from] MetricError),
    /// The program itself is at fault.
    #[error("internal error: {0}")]
    Internal(String),
    /// What was to be printed cannot be written.
    #[error("cannot write the results to stdout: {0}")]
    Unwritten(String),
    /// A run has not answered what was asked of it.
    #[error(transparent)]
    Unanswered(#[from] Unanswered),
    /// The operating system refuses something else.
    #[error("{action}: {source}")]
    System {
        /// What was tried.
        action: String,
        /// What the operating system says.
        source: std::io::Error,
    },
}

impl Failure {
    /// The exit code of the program. `phalanx --help` lists them.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Missed | Failure::Different | Failure::Nonconforming => 1,
            Failure::Invalid(_) | Failure::Usage(_) => 2,
            Failure::Unanswered(Unanswered::Over(_) | Unanswered::Refused { .. }) => 2,
            Failure::Run(_) | Failure::Emergency { .. } | Failure::TooLate { .. } => 3,
            Failure::Log(LogError::Busy { .. } | LogError::NoPlace { .. } | LogError::SameFile { .. }) => 2,
            Failure::Log(_) | Failure::Metric(_) => 4,
            Failure::System { .. } | Failure::Unwritten(_) | Failure::Unanswered(_) => 5,
            Failure::Violated(_) => 6,
            Failure::Internal(_) => 70,
            Failure::Interrupted => 130,
        }
    }

    /// What to do about it, if there is more to say than the error does.
    pub fn advice(&self) -> Option<&'static str> {
        match self {
            Failure::Run(error) => of_run(error),
            Failure::Log(LogError::Write { source, .. }) => of_system(source),
            Failure::System { source, .. } => of_system(source),
            Failure::Internal(_) => Some("this is a mistake in Phalanx; please report it with the command line"),
            Failure::TooLate { .. } => Some(
                "--profile shows what takes the time; a larger dt, --realtime 0.5 or [realtime] overrun = \"skip\" make room",
            ),
            _ => None,
        }
    }

    /// For `map_err`: an error of the operating system with what was tried.
    pub fn system(action: impl Into<String>) -> impl FnOnce(std::io::Error) -> Self {
        let action = action.into();
        move |source| Self::System { action, source }
    }
}

/// What the exit codes mean, for `--help` and the documentation.
pub const EXIT_CODES: &str = "\
Exit codes:
  0    done, every metric in its regression range
  1    done, but a metric is outside its regression range, two logs differ, or a program does not conform
  2    the command line or the scenario is not valid; nothing was started
  3    the run stopped early: a participant failed, hung, died or was too late, or an emergency stop; the log is kept up to there
  4    a log cannot be written or read, or lacks what was asked for
  5    the operating system refused something, or the results cannot be written
  6    an assertion of the scenario was violated; the log is complete, or ends there if the assertion stops the run
  70   internal error: a mistake in Phalanx itself
  130  interrupted (Ctrl-C, SIGTERM, SIGHUP); the log is closed and readable up to there
  141  the reader of what was printed has gone";

impl From<Vec<Problem>> for Failure {
    fn from(problems: Vec<Problem>) -> Self {
        Self::Invalid(problems)
    }
}

impl From<JudgeError> for Failure {
    fn from(error: JudgeError) -> Self {
        match error {
            JudgeError::Log(error) => Self::Log(error),
            JudgeError::Metric(error) => Self::Metric(error),
            JudgeError::Scenario(problems) => Self::Invalid(problems),
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Interrupted { .. } => Self::Interrupted,
            other => Self::Run(other),
        }
    }
}

impl From<DirectoryError> for Failure {
    fn from(error: DirectoryError) -> Self {
        Self::Run(error.into())
    }
}

fn of_run(error: &RunError) -> Option<&'static str> {
    Some(match error {
        RunError::Died { death: Death::Signal(SIGBUS), .. } => {
            "a SIGBUS mostly means that /dev/shm is full: `df -h /dev/shm` tells, `phalanx doctor` removes what dead runs have left"
        }
        RunError::Overwritten { .. } | RunError::Altered { .. } | RunError::Cut { .. } => {
            "try the run without your own programs, one at a time; a memory checker such as valgrind or -fsanitize=address finds \
             the place in a C or C++ program"
        }
        RunError::Died { step: None, .. } | RunError::NotReady { .. } => {
            "`phalanx conform` tries a program point by point; `-v` shows what every process does while it starts"
        }
        RunError::Died { .. } => {
            "`--on-failure restart` starts a participant that dies again and continues; `--log-dir DIR` keeps all that every process prints"
        }
        RunError::Deadline { .. } => {
            "`--deadline SECONDS` gives a step more time; `--on-failure restart` starts a participant that hangs again and continues"
        }
        RunError::Fault { step: 1.., .. } => {
            "the log holds every step before: `phalanx report LOG` shows how it came to this"
        }
        RunError::System { source, .. } => return of_system(source),
        RunError::Directory(error) => return of_system(&error.source),
        RunError::Service(_) => return of_limits(),
        _ => return None,
    })
}

fn of_system(error: &std::io::Error) -> Option<&'static str> {
    Some(match Errno::from_io_error(error)? {
        Errno::NOSPC | Errno::DQUOT => {
            "make room, or write elsewhere with `--out FILE`; `phalanx info LOG` tells how many steps a log holds, `phalanx recover` \
             closes it if need be"
        }
        Errno::ROFS | Errno::ACCESS | Errno::PERM => "`--out FILE` writes the log elsewhere",
        Errno::FBIG => "`ulimit -f` tells how large a file may be; `ulimit -f unlimited` allows any size",
        Errno::MFILE | Errno::NFILE => FEW_FILES,
        _ => return None,
    })
}

/// What to do when iceoryx2 cannot create its files; it does not say what the operating system said.
fn of_limits() -> Option<&'static str> {
    let of = |resource| getrlimit(resource).current;
    if of(Resource::Nofile).is_some_and(|limit| limit < MANY_FILES) {
        return Some(FEW_FILES);
    }
    of(Resource::Fsize).map(
        |_| "`ulimit -f` limits the size of files, of which shared memory is made; `ulimit -f unlimited` allows any",
    )
}

fn list(problems: &[Problem]) -> String {
    let texts: Vec<String> = problems.iter().map(Problem::to_string).collect();
    let count = match problems.len() {
        1 => "1 problem".to_string(),
        several => format!("{several} problems"),
    };
    format!("{count}; nothing was started\n\n{}", texts.join("\n\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistake_of_the_program_is_not_blamed_on_the_command_line() {
        let failure = Failure::Internal("a run panicked".into());
        assert_eq!((failure.exit_code(), failure.to_string().as_str()), (70, "internal error: a run panicked"));
        assert!(failure.advice().is_some_and(|advice| advice.contains("report it")));
        assert!(EXIT_CODES.contains("\n  70   internal error"));
    }
}
