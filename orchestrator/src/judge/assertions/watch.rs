//! Evaluating assertions step by step.

use std::path::Path;

use formation::config::Problem;
use formation::wiring::Assembly;
use lockstep::ChannelId;

use super::finding::{Finding, Findings, Limit, Moment, Violation};
use super::{Across, Assertion, Signal, Subject};
use crate::judge::JudgeError;
use recording::{Head, Log, Stream};

/// Evaluates the assertions of a run, one step after the other.
#[derive(Clone, Debug)]
pub struct Watch {
    assertions: Vec<Assertion>,
    findings: Vec<Finding>,
    /// Whether each subject of each assertion was violated at the last step.
    violated: Vec<Vec<bool>>,
    dt: f64,
    stop: bool,
    slots: Vec<f64>,
}

impl Watch {
    /// At the start of a run with steps of `dt` seconds.
    pub fn new(assertions: Vec<Assertion>, dt: f64) -> Self {
        let findings = assertions.iter().map(Finding::new).collect();
        let violated = assertions.iter().map(|assertion| vec![false; assertion.subjects.len()]).collect();
        let longest =
            assertions.iter().flat_map(|assertion| &assertion.subjects).map(|subject| subject.slots.len()).max();
        Self { assertions, findings, violated, dt, stop: false, slots: vec![0.0; longest.unwrap_or(0)] }
    }

    /// How many assertions there are.
    pub fn len(&self) -> usize {
        self.assertions.len()
    }

    /// Whether there is nothing to evaluate.
    pub fn is_empty(&self) -> bool {
        self.assertions.is_empty()
    }

    /// Evaluates everything at `step`, whose samples `sample` gives; `tell` hears of every violation that begins, with the number
    /// of its assertion, from 0.
    pub fn step<'s>(
        &mut self,
        step: u64,
        sample: &impl Fn(ChannelId) -> &'s [f64],
        mut tell: impl FnMut(usize, &Finding, &Violation),
    ) {
        let time = step as f64 * self.dt;
        let all = self.assertions.iter().zip(&mut self.findings).zip(&mut self.violated);
        for (index, ((assertion, finding), violated)) in all.enumerate() {
            if step < assertion.steps.0 || step > assertion.steps.1 {
                continue;
            }
            let mut slots = std::mem::take(&mut self.slots);
            let mut value_of = |subject: &Subject| {
                for (place, slot) in slots.iter_mut().zip(&subject.slots) {
                    *place = slot.value(time, sample);
                }
                subject.evaluate(&slots)
            };
            let mut judge = |subject: &Subject, agent: u32, (value, limit): (f64, Option<Limit>), was: &mut bool| {
                let moment = Moment { step, time, agent, value };
                let bad = finding.take(moment, (subject.min, subject.max), limit);
                if let (Some(violation), false) = (&bad, *was) {
                    self.stop |= assertion.stop;
                    tell(index, finding, violation);
                }
                *was = bad.is_some();
            };
            match assertion.across {
                Across::Each => {
                    for (subject, was) in assertion.subjects.iter().zip(violated) {
                        judge(subject, subject.agent, value_of(subject), was);
                    }
                }
                Across::Norm => {
                    let first = &assertion.subjects[0];
                    let squares = assertion.subjects.iter().map(|subject| value_of(subject).0.powi(2));
                    let norm = squares.sum::<f64>().sqrt();
                    judge(first, 0, (norm, first.beyond(norm)), &mut violated[0]);
                }
                Across::Sum => {
                    let first = &assertion.subjects[0];
                    let sum = assertion.subjects.iter().map(|subject| value_of(subject).0).sum();
                    judge(first, 0, (sum, first.beyond(sum)), &mut violated[0]);
                }
            }
            self.slots = slots;
        }
    }

    /// Whether an assertion that ends the run was violated.
    pub fn stops(&self) -> bool {
        self.stop
    }

    /// What was found up to now.
    pub fn findings(&self) -> Findings {
        Findings(self.findings.clone())
    }

    /// Evaluates the assertions of a recorded run, whose scenario is `assembly`, from its log.
    ///
    /// # Errors
    /// What is wrong with the assertions; they have been checked before the run.
    pub fn replay(assembly: &Assembly, log: &Log) -> Result<Findings, Vec<Problem>> {
        let mut watch = Self::new(super::read(assembly)?, assembly.scenario.context.timing.dt);
        if watch.is_empty() {
            return Ok(watch.findings());
        }
        let channels: Vec<_> = assembly
            .network
            .channels
            .iter()
            .map(|channel| log.samples(&channel.topic).filter(|samples| samples.width() == channel.layout.words()))
            .collect();
        if let Some(missing) = channels.iter().position(Option::is_none) {
            return Err(vec![self::missing(assembly, &assembly.network.channels[missing].topic)]);
        }
        for (row, step) in log.steps().enumerate() {
            let sample = |channel: ChannelId| channels[channel.0].map_or(&[][..], |samples| samples.row(row));
            watch.step(step, &sample, |_, _, _| {});
        }
        Ok(watch.findings())
    }

    /// The same from the log `path`, step by step, in no more memory than a few chunks take.
    ///
    /// # Errors
    /// As those of [`Watch::replay`], and [`JudgeError::Log`] if the log cannot be read.
    pub fn stream(assembly: &Assembly, path: &Path) -> Result<Findings, JudgeError> {
        let mut watch = Self::new(super::read(assembly)?, assembly.scenario.context.timing.dt);
        if watch.is_empty() {
            return Ok(watch.findings());
        }
        let head = Head::read(path)?;
        let mut topics = Vec::new();
        for channel in &assembly.network.channels {
            let known = head
                .topics
                .iter()
                .find(|(topic, layout)| *topic == channel.topic && layout.words() == channel.layout.words());
            let known = known.ok_or_else(|| vec![missing(assembly, &channel.topic)])?;
            topics.push(known.clone());
        }
        let mut stream = Stream::open(path, &topics)?;
        while stream.advance()? {
            let step = stream.step().unwrap_or_default();
            watch.step(step, &|channel: ChannelId| stream.words(channel.0), |_, _, _| {});
        }
        Ok(watch.findings())
    }
}

impl Subject {
    /// The value of a number, or the margin of a condition; and the limit that it violates.
    fn evaluate(&self, slots: &[f64]) -> (f64, Option<Limit>) {
        match &self.signal {
            Signal::Number(formula) => {
                let value = formula.evaluate(slots);
                (value, self.beyond(value))
            }
            Signal::Condition(condition) => {
                (condition.margin(slots), (!condition.holds(slots)).then_some(Limit::Condition))
            }
        }
    }

    /// The bound that a value is beyond; any of them if it is NaN.
    fn beyond(&self, value: f64) -> Option<Limit> {
        if value >= self.min && value <= self.max {
            return None;
        }
        let below = value < self.min || self.max == f64::INFINITY;
        Some(if below { Limit::Min(self.min) } else { Limit::Max(self.max) })
    }
}

fn missing(assembly: &Assembly, topic: &str) -> Problem {
    let message = format!("the log has no topic {topic} as the scenario describes it");
    assembly.scenario.problem("assert", message)
}
