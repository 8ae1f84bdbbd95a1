//! What observes the steps of a run: the log, its scene, the journal of robots, the past for restarts, the tap, the assertions.

use lockstep::{Network, Period, Store};
use processes::Tap;

use super::control::Start;
use super::monitor::AssertionMonitor;
use super::outcome::Ending;
use super::recording::header;
use super::recovery::Recovery;
use super::robots::Journal;
use super::scene::Scene;
use crate::log::{LogError, Recorder};

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
    /// What has happened to participants, in words; filled by observers, written by [`Recovery`].
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

/// All observers of a run, in the order of their messages within a step of the log.
pub(crate) struct Observers {
    pub(crate) scene: Option<Scene>,
    pub(crate) journal: Option<Journal>,
    pub(crate) recovery: Option<Recovery>,
    pub(crate) tap: Option<Tap>,
    pub(crate) monitor: AssertionMonitor,
}

impl Observers {
    fn each(&mut self) -> impl Iterator<Item = &mut dyn Observer> {
        [
            self.scene.as_mut().map(|scene| scene as &mut dyn Observer),
            self.journal.as_mut().map(|journal| journal as _),
            self.recovery.as_mut().map(|recovery| recovery as _),
            self.tap.as_mut().map(|tap| tap as _),
            Some(&mut self.monitor as _),
        ]
        .into_iter()
        .flatten()
    }

    /// Records the samples of a step and shows it to all observers.
    ///
    /// # Errors
    /// [`LogError`] if the log cannot be written.
    pub(crate) fn step(&mut self, view: &mut StepView, log: &mut Option<Recorder>) -> Result<Flow, LogError> {
        if let Some(log) = log {
            let StepView { network, store, period, step, .. } = *view;
            log.record(step, store, |channel| header(network, period, store, channel, step))?;
        }
        let mut flow = Flow::Continue;
        for observer in self.each() {
            if observer.step(view, log.as_mut())? == Flow::Halt {
                flow = Flow::Halt;
            }
        }
        Ok(flow)
    }

    /// Lets all observers write their last messages.
    ///
    /// # Errors
    /// [`LogError`] if the log cannot be written.
    pub(crate) fn end(&mut self, ending: &Ending, log: &mut Option<Recorder>) -> Result<(), LogError> {
        self.each().try_for_each(|observer| observer.end(ending, log.as_mut()))
    }
}

impl Observer for Tap {
    fn step(&mut self, view: &mut StepView, _: Option<&mut Recorder>) -> Result<Flow, LogError> {
        self.publish(view.store, view.step);
        Ok(Flow::Continue)
    }
}
