//! How a run is carried out.

use std::path::PathBuf;

use formation::scenario::{FailurePolicy, Overrun};
use lockstep::Wake;

use super::pinning::Pin;
use super::placement::Placement;
use super::priority::Priority;
use super::profile::TRACED_RUNS;
use super::stress::Stress;
use super::swap::{RobotSwap, Swap};
use recording::LogPlace;

/// How a run is carried out. None of it changes a bit of the samples.
#[derive(Clone, Debug)]
pub struct Options {
    /// How the participants are spread over processes.
    pub placement: Placement,
    /// Where the log goes; `None`: nothing is recorded.
    pub log: Option<PathBuf>,
    /// The place of the log, if the caller has claimed it already.
    pub place: Option<LogPlace>,
    /// Whether the log shows the scene to viewers, besides the signals.
    pub scene: bool,
    /// Which cores the processes use.
    pub pin: Pin,
    /// Participants that are programs of the user.
    pub swaps: Vec<Swap>,
    /// Whether progress is shown, and keys of the terminal are read.
    pub progress: bool,
    /// Simulated seconds per second; `None`: as fast as possible.
    pub pace: Option<f64>,
    /// What is done about steps that are late, if the scenario says so.
    pub overrun: Option<Overrun>,
    /// Where a trace of the last steps goes; `None`: nothing is traced.
    pub trace: Option<PathBuf>,
    /// What is done when a participant fails.
    pub on_failure: FailurePolicy,
    /// Disturbances of the processes, for tests of determinism.
    pub stress: Option<Stress>,
    /// What the processes wake each other with.
    pub wake: Wake,
    /// Whether every sample is also published for monitors outside the run.
    pub tap: bool,
    /// Scheduling priority of the processes.
    pub priority: Priority,
    /// Folder that gets one file per process with what it printed.
    pub log_dir: Option<PathBuf>,
    /// Whether stand-ins play participants of the kind `external`, which is of use to try a program only.
    pub stand_ins: bool,
}

impl Options {
    /// As fast as possible, silent, without programs of the user, recorded into `log` with its scene if there is one. What the
    /// scenario itself says about programs and failures is not in it: see [`super::swap::Swap::collect`] and
    /// [`formation::scenario::Scenario::on_failure`].
    pub fn new(placement: Placement, log: Option<PathBuf>) -> Self {
        Self {
            placement,
            log,
            place: None,
            scene: true,
            pin: Pin::Auto,
            swaps: Vec::new(),
            progress: false,
            pace: None,
            overrun: None,
            trace: None,
            on_failure: FailurePolicy::default(),
            stress: None,
            wake: Wake::default(),
            tap: false,
            priority: Priority::default(),
            log_dir: None,
            stand_ins: false,
        }
    }

    /// Whether all participants run in this process. Those that are swapped never do.
    pub(crate) fn in_one_process(&self) -> bool {
        self.placement == Placement::Single && self.swaps.is_empty()
    }

    /// Whether a robot with a clock of its own takes part.
    pub(crate) fn has_robots(&self) -> bool {
        self.swaps.iter().any(|swap| swap.robot().is_some_and(RobotSwap::is_free))
    }

    /// What is done about steps that are late: with robots periods are skipped, since a robot must not get the commands of several
    /// periods at once; without, steps catch up.
    pub(crate) fn overrun(&self) -> Overrun {
        self.overrun.unwrap_or(if self.has_robots() { Overrun::Skip } else { Overrun::CatchUp })
    }

    /// How many of its last runs every process keeps for the trace.
    pub(crate) fn traced_runs(&self) -> u32 {
        if self.trace.is_some() { TRACED_RUNS } else { 0 }
    }
}
