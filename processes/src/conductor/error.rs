//! What can go wrong in a run, with all that its user wants to know.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::path::PathBuf;
use std::time::Duration;

use crate::directory::DirectoryError;
use crate::service::ServiceError;
use lockstep::PlanError;

/// How a process ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Death {
    /// It returned this exit code.
    Exit(i32),
    /// This signal killed it.
    Signal(i32),
}

/// What a worker does that keeps the others waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Its process has not joined the run: it is still starting, or is no participant.
    Starting,
    /// It has joined, and builds its participants, opens its channels or catches up.
    Connecting,
    /// It has passed its gate so long ago: it reads, computes or writes.
    Computing(Duration),
    /// Its gate was opened so long ago, and it has not passed it.
    Waking(Duration),
    /// What the page says about it cannot be.
    Unknown,
}

/// A worker that keeps the others waiting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Late {
    /// Its name.
    pub worker: String,
    /// Its process, if it was spawned at all.
    pub pid: Option<u32>,
    /// The state of the process as the kernel tells it: `R` running, `S` sleeping, `D` waiting for a device, `T` stopped,
    /// `Z` dead; `?` if unknown.
    pub state: char,
    /// The function of the kernel that it waits in, if that is known.
    pub waits_in: Option<String>,
    /// What it does.
    pub activity: Activity,
    /// The last lines that it printed.
    pub last_lines: Vec<String>,
}

/// Why a run cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A process ended before its time.
    #[error("{worker} (pid {pid}) {death} {}{}", moment(*step, *phase), quote(last_lines))]
    Died {
        /// Name of the worker.
        worker: String,
        /// Its process.
        pid: u32,
        /// How it ended.
        death: Death,
        /// The step in progress, or the next one; `None` before the first.
        step: Option<u64>,
        /// The phase in progress; `None` between two steps.
        phase: Option<usize>,
        /// The last lines that it printed.
        last_lines: Vec<String>,
    },
    /// A worker could not start: its participants cannot be built, or a service cannot be opened.
    #[error("{worker} cannot start: {message}")]
    Refused {
        /// Name of the worker.
        worker: String,
        /// What it says.
        message: String,
    },
    /// Workers that were not connected in time.
    #[error("not connected after {:.1} s: {}", waited.as_secs_f64(), list(missing))]
    NotReady {
        /// Who.
        missing: Vec<Late>,
        /// How long they were given.
        waited: Duration,
    },
    /// A participant could not compute its step, panicked, had an output that is not finite, or a wrong input.
    #[error("{node} at step {step}: {message}")]
    Fault {
        /// Name of the node.
        node: String,
        /// Number of the step.
        step: u64,
        /// What it says.
        message: String,
    },
    /// Workers that did not finish a phase in time.
    #[error("phase {phase} of step {step} is not done after {:.1} s; waiting for {}", waited.as_secs_f64(), list(late))]
    Deadline {
        /// The workers that have not arrived.
        late: Vec<Late>,
        /// Number of the step.
        step: u64,
        /// Number of the phase.
        phase: usize,
        /// For how long.
        waited: Duration,
    },
    /// [`Interrupt::raise`](crate::Interrupt::raise) was called.
    #[error("interrupted at step {step}")]
    Interrupted {
        /// The step in progress, which is not complete.
        step: u64,
    },
    /// A sample that was to be recorded is not that of the step.
    #[error("at step {step}, {message}")]
    Recording {
        /// Number of the step.
        step: u64,
        /// Which sample.
        message: String,
    },
    /// Something stands in the place of samples that was not published. No worker is at fault that finds it.
    #[error("{noticed}; {}", reach(suspects))]
    Altered {
        /// How it was noticed.
        noticed: Box<RunError>,
        /// The workers, with their processes, that have all of the altered memory open.
        suspects: Vec<String>,
    },
    /// Something stands on the page that all processes share which none can have written in order.
    #[error(
        "at step {step}, the memory that all processes of the run share was overwritten ({what}): a process has written where it \
         must not, as a stray pointer does{}",
        blame(suspects)
    )]
    Overwritten {
        /// The step in progress.
        step: u64,
        /// What is damaged.
        what: &'static str,
        /// The workers, with their processes, that computed when it happened, as far as they found it.
        suspects: Vec<String>,
    },
    /// Shared memory of the run is shorter than it was.
    #[error(
        "at step {step}, the shared memory {} has {now} bytes instead of {before}: a process has cut it short; first noticed as: \
         {noticed}", path.display()
    )]
    Cut {
        /// The step in progress.
        step: u64,
        /// Its file.
        path: PathBuf,
        /// Its size at first.
        before: u64,
        /// Its size now; 0 if it was removed.
        now: u64,
        /// What came of it first.
        noticed: Box<RunError>,
    },
    /// No process can take the place of a worker.
    #[error("{worker} cannot be replaced at step {step}: {reason}")]
    NotReplaced {
        /// Its name.
        worker: String,
        /// The step in progress.
        step: u64,
        /// Why.
        reason: String,
    },
    /// All steps of the plan are done, or an earlier step has failed.
    #[error("the run is over after {steps} steps")]
    Over {
        /// How many steps were completed.
        steps: u64,
    },
    /// The plan cannot be carried out.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The run directory cannot be used.
    #[error(transparent)]
    Directory(#[from] DirectoryError),
    /// iceoryx2 refuses.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// The operating system refuses.
    #[error("{action}: {source}")]
    System {
        /// What was tried.
        action: String,
        /// Why it failed.
        source: io::Error,
    },
}

/// For `map_err`: an error of the operating system with what was tried.
pub(super) fn system<E: Into<io::Error>>(action: impl Into<String>) -> impl FnOnce(E) -> RunError {
    let action = action.into();
    move |source| RunError::System { action, source: source.into() }
}

impl Display for Death {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match *self {
            Death::Exit(code) => write!(f, "ended with exit code {code}"),
            Death::Signal(signal) => match signal_name(signal) {
                Some(name) => write!(f, "was killed by signal {signal} ({name})"),
                None => write!(f, "was killed by signal {signal}"),
            },
        }
    }
}

impl Display for Late {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let state = match self.state {
            'R' => "running",
            'S' => "sleeping",
            'D' => "waiting for a device",
            'T' | 't' => "stopped",
            'Z' | 'X' => "dead",
            _ => "in an unknown state",
        };
        let waits_in = self.waits_in.as_ref().map(|place| format!(" in {place}")).unwrap_or_default();
        match self.pid {
            Some(pid) => {
                let Self { worker, activity, last_lines, .. } = self;
                write!(f, "{worker} (pid {pid}, {state}{waits_in}), {activity}{}", quote(last_lines))
            }
            None => write!(f, "{} (never spawned)", self.worker),
        }
    }
}

impl Display for Activity {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Activity::Starting => write!(f, "which has not joined the run: is it a participant?"),
            Activity::Connecting => write!(f, "which has joined the run and is still preparing itself"),
            Activity::Computing(time) => write!(f, "computing for {:.2} s", time.as_secs_f64()),
            Activity::Unknown => write!(f, "which does what the damaged memory of the run does not say"),
            Activity::Waking(time) => {
                write!(f, "whose turn came {:.2} s ago and which has not begun", time.as_secs_f64())
            }
        }
    }
}

fn list(late: &[Late]) -> String {
    late.iter().map(Late::to_string).collect::<Vec<_>>().join(", ")
}

fn blame(suspects: &[String]) -> String {
    match suspects {
        [] => String::new(),
        [one] => format!("; {one} computed when it happened"),
        several => format!("; it was one of those that computed when it happened: {}", several.join(", ")),
    }
}

fn reach(suspects: &[String]) -> String {
    /// More names than that do not help.
    const MOST: usize = 4;
    match suspects {
        [only] => format!("of all participants, only {only} has all of the altered memory open"),
        few if few.len() <= MOST => format!("the altered memory is open in {}", few.join(", ")),
        many => format!("the altered memory is open in {} participants", many.len()),
    }
}

fn moment(step: Option<u64>, phase: Option<usize>) -> String {
    match (step, phase) {
        (Some(step), Some(phase)) => format!("in phase {phase} of step {step}"),
        (Some(step), None) => format!("before step {step}"),
        (None, _) => "before it was connected".into(),
    }
}

fn quote(lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    format!("; its last lines:\n    {}\n", lines.join("\n    "))
}

fn signal_name(signal: i32) -> Option<&'static str> {
    Some(match signal {
        libc::SIGABRT => "SIGABRT",
        libc::SIGALRM => "SIGALRM",
        libc::SIGBUS => "SIGBUS",
        libc::SIGFPE => "SIGFPE",
        libc::SIGHUP => "SIGHUP",
        libc::SIGILL => "SIGILL",
        libc::SIGINT => "SIGINT",
        libc::SIGKILL => "SIGKILL",
        libc::SIGPIPE => "SIGPIPE",
        libc::SIGQUIT => "SIGQUIT",
        libc::SIGSEGV => "SIGSEGV",
        libc::SIGSYS => "SIGSYS",
        libc::SIGTERM => "SIGTERM",
        libc::SIGTRAP => "SIGTRAP",
        libc::SIGXCPU => "SIGXCPU",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_death_is_told_with_all_that_is_known() {
        let error = RunError::Died {
            worker: "controller_3".into(),
            pid: 4711,
            death: Death::Signal(9),
            step: Some(17),
            phase: Some(2),
            last_lines: vec!["one".into(), "two".into()],
        };
        assert_eq!(
            error.to_string(),
            "controller_3 (pid 4711) was killed by signal 9 (SIGKILL) in phase 2 of step 17; its last lines:\n    \
             one\n    two\n"
        );
    }
}
