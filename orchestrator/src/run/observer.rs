//! What observes the steps of a run: the log, its scene, the journal of robots, the past for restarts, the tap, the assertions.

use lockstep::{Network, Period, Store};

use super::control::Start;
use super::outcome::Ending;
use recording::{LogError, Recorder};

/// A step that is done.
pub(crate) struct StepView<'a> {
    /// Its number.
    pub(crate) step: u64,
    /// Length of a step.
    pub(crate) period: Period,
    /// The channels of the scenario, and behind them those of bridges to robots.
    pub(crate) network: &'a Network,
    /// The samples.
    pub(crate) store: &'a Store,
    /// How it was started, if it was paced.
    pub(crate) start: Start,
    /// Shows a line to the user.
    pub(crate) say: &'a dyn Fn(&str),
    /// What has happened to participants, in words; filled by observers, written by [`super::recovery::Recovery`].
    pub(crate) remarks: Vec<(String, String)>,
}

impl StepView<'_> {
    /// Simulated time of the step, ns.
    pub(crate) fn time_ns(&self) -> u64 {
        self.period.time_ns(self.step)
    }
}

/// Whether a run may continue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flow {
    /// It may.
    Continue,
    /// It ends after this step.
    Halt,
}

/// Something that looks at every step of a run after it is done, in the process of the orchestrator.
///
/// `log` is missing in a run that is not recorded.
pub(crate) trait Observer {
    /// A step is done.
    ///
    /// # Errors
    /// [`LogError`] if the log cannot be written; the run ends then.
    fn step(&mut self, view: &mut StepView, log: Option<&mut Recorder>) -> Result<Flow, LogError>;

    /// The run is over; the log is closed after this.
    ///
    /// # Errors
    /// [`LogError`] if the log cannot be written.
    fn end(&mut self, _ending: &Ending, _log: Option<&mut Recorder>) -> Result<(), LogError> {
        Ok(())
    }
}
