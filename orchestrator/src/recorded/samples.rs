//! A log that has been found to fit a run, at the step that is being played.

use std::path::Path;

use formation::data::DataSource;
use formation::scenario::{Scenario, Selection};
use lockstep::{ChannelId, Layout, Network, Period, Shape};

use super::ReplayError;
use recording::{Head, Stream};

/// The recorded samples of some channels, step by step.
pub struct RecordedSamples {
    stream: Stream,
    /// The topic of the stream that a channel of the network is.
    topics: Vec<Option<usize>>,
    period: Period,
}

impl RecordedSamples {
    /// Opens the log `path` to play what these `nodes` of `network` publish, in a run of `scenario`.
    ///
    /// # Errors
    /// [`ReplayError`] if the log is of another scenario, of steps of another length, of a shorter run, or lacks a signal.
    pub fn open(path: &Path, scenario: &Scenario, network: &Network, nodes: &[usize]) -> Result<Self, ReplayError> {
        let head = Head::read(path)?;
        check_scenario(path, &head, scenario)?;
        let mut topics = vec![None; network.channels.len()];
        let mut wanted = Vec::new();
        for &node in nodes {
            for &ChannelId(channel) in &network.nodes[node].outputs {
                let (topic, expected) = (&network.channels[channel].topic, &network.channels[channel].layout);
                let Some((_, found)) = head.topics.iter().find(|(name, _)| name == topic) else {
                    return Err(ReplayError::Topic {
                        path: path.into(),
                        topic: topic.clone(),
                        node: network.nodes[node].name.clone(),
                        found: head.topics.into_iter().map(|(name, _)| name).collect(),
                    });
                };
                if found != expected {
                    let (found, expected) = (fields(found), fields(expected));
                    return Err(ReplayError::Layout { path: path.into(), topic: topic.clone(), found, expected });
                }
                topics[channel] = Some(wanted.len());
                wanted.push((topic.clone(), expected.clone()));
            }
        }
        let stream = Stream::open(path, &wanted)?;
        Ok(Self { stream, topics, period: scenario.context.timing.period() })
    }

    /// Advances to `step`; never back. `false` if the recording ends before.
    ///
    /// # Errors
    /// [`ReplayError::Log`] if the log is damaged, [`ReplayError::Step`] if its steps are not those of the run.
    pub fn advance_to(&mut self, step: u64) -> Result<bool, ReplayError> {
        while self.stream.step().is_none_or(|current| current < step) {
            if !self.stream.advance()? {
                return Ok(false);
            }
        }
        let found = self.stream.step().unwrap_or(0);
        let wrong = |what| Err(ReplayError::Step { path: self.stream.path().into(), what });
        if found != step {
            return wrong(format!("starts at step {found}; it can be played from step 0 only"));
        }
        if self.stream.time_ns() != self.period.time_ns(step) {
            let time = self.stream.time_ns() as f64 / 1e9;
            let expected = self.period.time_ns(step) as f64 / 1e9;
            return wrong(format!("has step {step} at {time} s, where this run has it at {expected} s"));
        }
        Ok(true)
    }

    /// The error if the recording ends before `step`.
    pub fn over(&self, step: u64) -> ReplayError {
        let last = match self.stream.step() {
            Some(last) => format!("ends with step {last} ({} s)", self.stream.time_ns() as f64 / 1e9),
            None => "holds no step".to_string(),
        };
        let what = format!(
            "{last}, so that there is nothing to play at step {step}; the recorded run was stopped there, or its file was cut"
        );
        ReplayError::Step { path: self.stream.path().into(), what }
    }

    /// The recorded numbers of a channel at the current step.
    ///
    /// # Panics
    /// If the channel was not asked for when it was opened, or no step was read yet.
    pub fn words(&self, channel: ChannelId) -> &[f64] {
        let topic = self.topics[channel.0].expect("a channel that is recorded");
        self.stream.words(topic)
    }
}

/// Whether the recorded run is one that can be played in a run of `scenario`.
fn check_scenario(path: &Path, head: &Head, scenario: &Scenario) -> Result<(), ReplayError> {
    let missing = |reason| ReplayError::NoScenario { path: path.into(), reason };
    let text = head.scenario.as_ref().ok_or_else(|| missing(String::new()))?;
    let selection = Selection { data: DataSource::Bytes(head.data.clone()), ..Selection::default() };
    let recorded = Scenario::load(&format!("{} (scenario.toml)", path.display()), text, &selection);
    let recorded = recorded.map_err(|problems| missing(format!(": {}", problems[0])))?;
    let path = path.to_path_buf();
    if recorded.name != scenario.name {
        let (found, expected) = (recorded.name, scenario.name.clone());
        return Err(ReplayError::Scenario { path, found, expected });
    }
    let (theirs, ours) = (recorded.context.timing, scenario.context.timing);
    if theirs.period() != ours.period() {
        return Err(ReplayError::Period { path, found: theirs.period(), expected: ours.period() });
    }
    if theirs.periods() < ours.periods() {
        return Err(ReplayError::Short { path, found: theirs.duration, expected: ours.duration });
    }
    Ok(())
}

/// The fields of a layout in words: `position[3], yaw`.
fn fields(layout: &Layout) -> String {
    let name = |field: &lockstep::Field| match field.shape {
        Shape::Scalar => field.name.clone(),
        Shape::Vector(length) => format!("{}[{length}]", field.name),
    };
    layout.fields().iter().map(name).collect::<Vec<_>>().join(", ")
}
