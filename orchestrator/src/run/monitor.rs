//! The assertions of a run in progress: evaluated at every step, shown when violated, and written into its log.

use std::collections::BTreeMap;

use super::observer::{Flow, Observer, StepView};
use super::outcome::Ending;
use crate::judge::assertions::{DEFINITION, Findings, TOPIC, Watch, encode};
use recording::{Durability, ExtraChannel, LogError, Recorder, definitions};

/// Violations of one assertion that are written one by one; all are counted. A signal that trembles around its bound would fill
/// the log otherwise.
const MOST_MESSAGES: u32 = 100;
/// Name of the metadata record with the summary.
const METADATA: &str = "phalanx-assertions";

/// Evaluates the assertions of a run.
pub(crate) struct AssertionMonitor {
    watch: Watch,
    /// Where violations are written.
    channel: Option<ExtraChannel>,
    /// Messages written, by assertion.
    messages: Vec<u32>,
}

impl AssertionMonitor {
    /// For a run that `recorder` records, if it is recorded.
    ///
    /// # Errors
    /// [`LogError`] if the log does not take the messages.
    pub(crate) fn new(watch: Watch, recorder: Option<&mut Recorder>) -> Result<Self, LogError> {
        let text = definitions::text(DEFINITION);
        let add =
            |recorder: &mut Recorder| recorder.add_channel(TOPIC, DEFINITION[0].0, &text, Durability::TransientLocal);
        let channel = recorder.filter(|_| !watch.is_empty()).map(add).transpose()?;
        let messages = vec![0; watch.len()];
        Ok(Self { watch, channel, messages })
    }

    /// Whether there is anything to watch.
    pub(crate) fn is_idle(&self) -> bool {
        self.watch.is_empty()
    }

    /// What was found so far.
    pub(crate) fn findings(&self) -> Findings {
        self.watch.findings()
    }
}

impl Observer for AssertionMonitor {
    /// The first violation of every assertion is shown to the user.
    fn step(&mut self, view: &mut StepView, mut log: Option<&mut Recorder>) -> Result<Flow, LogError> {
        let Self { watch, channel, messages, .. } = self;
        let (step, store, time_ns) = (view.step, view.store, view.time_ns());
        let mut result = Ok(());
        watch.step(step, &|channel| store.read(channel, step), |index, finding, violation| {
            if finding.first == Some(*violation) {
                (view.say)(&format!("{}: {}: {}", finding.kind(), finding.name, violation.text(&finding.signal)));
            }
            if let (Some(log), Some(channel)) = (log.as_deref_mut(), *channel)
                && messages[index] < MOST_MESSAGES
                && result.is_ok()
            {
                messages[index] += 1;
                result = log.write(channel, step, encode(finding, violation, time_ns).bytes());
            }
        });
        result.map(|()| if watch.stops() { Flow::Halt } else { Flow::Continue })
    }

    /// Writes the summary of all assertions.
    fn end(&mut self, _: &Ending, log: Option<&mut Recorder>) -> Result<(), LogError> {
        let findings = self.findings();
        if let (Some(log), false) = (log, findings.0.is_empty()) {
            let summary: BTreeMap<String, String> =
                findings.0.iter().map(|finding| (finding.name.clone(), finding.summary())).collect();
            log.note(METADATA, &summary)?;
        }
        Ok(())
    }
}
