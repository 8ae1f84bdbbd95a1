//! A recorded run with its scenario: where metrics get their signals from.

use std::cell::RefCell;
use std::collections::BTreeSet;

use formation::math::Topology;
use formation::scenario::Scenario;
use formation::wiring::Role;

use recording::{Log, Series};

/// A metric that cannot be computed from this log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MetricError {
    /// The log lacks a signal.
    #[error("the log has no signal `{field}` in {topic}, which the metrics `{set}` need")]
    MissingSignal {
        /// The topic.
        topic: String,
        /// The field.
        field: String,
        /// Name of the set.
        set: String,
    },
    /// The scenario is not one that these metrics are made for.
    #[error("the metrics `{set}` do not apply: {reason}")]
    NotApplicable {
        /// Name of the set.
        set: String,
        /// Why.
        reason: String,
    },
}

/// A recorded run.
pub struct Run<'a> {
    /// The scenario that ran.
    pub scenario: &'a Scenario,
    log: &'a Log,
    /// The signals that were asked for: topic and field.
    asked: RefCell<BTreeSet<(String, String)>>,
}

impl<'a> Run<'a> {
    /// The run of `scenario` that `log` recorded.
    pub fn new(scenario: &'a Scenario, log: &'a Log) -> Self {
        Self { scenario, log, asked: RefCell::default() }
    }

    /// The signals that were asked for so far, whether there are such or not: topic and field.
    pub fn asked(&self) -> BTreeSet<(String, String)> {
        self.asked.borrow().clone()
    }

    /// Number of agents.
    pub fn agents(&self) -> usize {
        self.scenario.context.agents.len()
    }

    /// Number of samples: one more than there are periods of `dt`, if the run is complete.
    pub fn samples(&self) -> usize {
        let steps = self.log.steps();
        (steps.end - steps.start) as usize
    }

    /// Length of a step, s.
    pub fn dt(&self) -> f64 {
        self.scenario.context.timing.dt
    }

    /// Time of sample `k`, s.
    pub fn time(&self, k: usize) -> f64 {
        k as f64 * self.dt()
    }

    /// The graph at sample `k`.
    pub fn topology(&self, k: usize) -> &Topology {
        self.scenario.context.topology.at(self.log.steps().start + k as u64)
    }

    /// First sample at or after `time`, s.
    pub fn sample_at(&self, time: f64) -> usize {
        (time / self.dt() - 1e-9).ceil() as usize
    }

    /// First sample of the last quarter: the smallest k >= 0.75 n, where n is the number of periods.
    pub fn last_quarter(&self) -> usize {
        (0.75 * (self.samples() - 1) as f64).ceil() as usize
    }

    /// Whether `role` publishes `field` for `agent` (from 0).
    pub fn offers(&self, role: Role, agent: usize, field: &str) -> bool {
        self.find(&topic(role, agent), field).is_some()
    }

    /// A signal of one agent (from 0).
    ///
    /// # Errors
    /// [`MetricError::MissingSignal`].
    pub fn signal(&self, role: Role, agent: usize, field: &str) -> Result<Series<'a>, MetricError> {
        let topic = topic(role, agent);
        let found = self.find(&topic, field);
        found.ok_or_else(|| MetricError::MissingSignal {
            topic,
            field: field.into(),
            set: self.scenario.metrics.clone(),
        })
    }

    fn find(&self, topic: &str, field: &str) -> Option<Series<'a>> {
        self.asked.borrow_mut().insert((topic.into(), field.into()));
        self.log.signal(topic, field)
    }

    /// A signal of every agent.
    ///
    /// # Errors
    /// [`MetricError::MissingSignal`].
    pub fn signals(&self, role: Role, field: &str) -> Result<Vec<Series<'a>>, MetricError> {
        (0..self.agents()).map(|agent| self.signal(role, agent, field)).collect()
    }

    /// The values of `compute(k)` at all samples.
    pub fn history(&self, compute: impl FnMut(usize) -> f64) -> Vec<f64> {
        (0..self.samples()).map(compute).collect()
    }
}

fn topic(role: Role, agent: usize) -> String {
    format!("/agent_{}/{}", agent + 1, role.channel())
}
