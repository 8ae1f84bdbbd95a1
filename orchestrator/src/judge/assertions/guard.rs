//! The assertions of a run that is going on: evaluated, told, and written into its log.

use std::collections::BTreeMap;

use lockstep::Store;

use super::{Findings, SCHEMA_NAME, SCHEMA_TEXT, TOPIC, Watch, encode};
use crate::log::{ExtraChannel, LogError, Recorder};

/// Violations of one assertion that are written one by one; all are counted. A signal that trembles around its bound would fill
/// the log otherwise.
const MOST_MESSAGES: u32 = 100;
/// Name of the metadata record with the summary.
const METADATA: &str = "phalanx-assertions";

/// What watches over a run.
pub(crate) struct Guard {
    watch: Watch,
    period_ns: u64,
    /// Where violations are written.
    channel: Option<ExtraChannel>,
    /// Messages written, by assertion.
    messages: Vec<u32>,
}

impl Guard {
    /// Watches over a run with steps of `period_ns` nanoseconds, recorded by `recorder`.
    ///
    /// # Errors
    /// [`LogError`] if the log does not take the messages.
    pub(crate) fn new(watch: Watch, period_ns: u64, recorder: Option<&mut Recorder>) -> Result<Self, LogError> {
        let add = |recorder: &mut Recorder| recorder.add_channel(TOPIC, SCHEMA_NAME, SCHEMA_TEXT);
        let channel = recorder.filter(|_| !watch.is_empty()).map(add).transpose()?;
        let messages = vec![0; watch.len()];
        Ok(Self { watch, period_ns, channel, messages })
    }

    /// Whether there is anything to watch.
    pub(crate) fn is_idle(&self) -> bool {
        self.watch.is_empty()
    }

    /// Evaluates the samples of `step`; `say` hears of the first violation of every assertion. Whether the run may go on.
    ///
    /// # Errors
    /// [`LogError`] if the log does not take the message.
    pub(crate) fn check(
        &mut self,
        step: u64,
        store: &Store,
        mut recorder: Option<&mut Recorder>,
        mut say: impl FnMut(&str),
    ) -> Result<bool, LogError> {
        let Self { watch, period_ns, channel, messages } = self;
        let mut result = Ok(());
        watch.step(step, &|channel| store.read(channel, step), |index, finding, violation| {
            if finding.first == Some(*violation) {
                say(&format!("{}: {}: {}", finding.kind(), finding.name, violation.text(&finding.signal)));
            }
            if let (Some(recorder), Some(channel)) = (recorder.as_deref_mut(), *channel)
                && messages[index] < MOST_MESSAGES
                && result.is_ok()
            {
                messages[index] += 1;
                result = recorder.write(channel, step, &encode(finding, violation, step.saturating_mul(*period_ns)));
            }
        });
        result.map(|()| !self.watch.stops())
    }

    /// Writes the summary into the log, at the end of the run, and returns what was found.
    ///
    /// # Errors
    /// [`LogError`] if the log does not take it.
    pub(crate) fn conclude(self, recorder: Option<&mut Recorder>) -> Result<Findings, LogError> {
        let findings = self.watch.findings();
        if let (Some(recorder), false) = (recorder, findings.0.is_empty()) {
            let summary: BTreeMap<String, String> =
                findings.0.iter().map(|finding| (finding.name.clone(), finding.summary())).collect();
            recorder.note(METADATA, &summary)?;
        }
        Ok(findings)
    }
}
