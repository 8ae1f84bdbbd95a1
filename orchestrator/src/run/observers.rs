//! All observers of a run.

use processes::Tap;

use super::monitor::AssertionMonitor;
use super::observer::{Flow, Observer, StepView};
use super::outcome::Ending;
use super::recording::header;
use super::recovery::Recovery;
use super::robots::RobotLog;
use super::scene::Scene;
use recording::{LogError, Recorder};

/// All observers of a run, in the order of their messages within a step of the log.
pub(crate) struct Observers {
    pub(crate) scene: Option<Scene>,
    pub(crate) journal: Option<RobotLog>,
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
