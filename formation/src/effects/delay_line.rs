//! Samples that are on their way.

use super::limits::{Findings, check_not_negative};

/// The longest delay, in steps.
const MOST_DELAY: f64 = 1e5;

/// How much earlier than due a step may be, in steps: 1e-9, and what rounding makes of a time of so many steps.
pub(super) fn tolerance(steps: f64) -> f64 {
    1e-9 + 1e-15 * steps
}

/// The first step at or after a time [s].
pub(super) fn first_step(time: f64, dt: f64) -> u64 {
    let steps = time / dt;
    (steps - tolerance(steps)).ceil() as u64
}

/// The smallest number of steps that are at least a delay [s].
pub(super) fn delay_steps(delay: f64, dt: f64) -> u64 {
    first_step(delay, dt).min(MOST_DELAY as u64)
}

/// Samples with the steps at which they were taken, until they are old enough: a ring of fixed size.
#[derive(Clone, Debug)]
pub(super) struct DelayLine {
    delay: u64,
    width: usize,
    steps: Vec<u64>,
    values: Vec<f64>,
    front: usize,
    count: usize,
}

impl DelayLine {
    /// For samples of `width` numbers that come at most `rate` times a step and are put out `delay` steps later.
    pub(super) fn new(delay: u64, rate: f64, width: usize) -> Self {
        // Those on their way, the one that is put out, and a new one.
        let capacity = (delay as f64 * rate).ceil() as usize + 2;
        Self { delay, width, steps: vec![0; capacity], values: vec![0.0; capacity * width], front: 0, count: 0 }
    }

    /// A place for the sample of this step.
    pub(super) fn push(&mut self, step: u64) -> &mut [f64] {
        if self.count == self.steps.len() {
            self.pop();
        }
        let slot = (self.front + self.count) % self.steps.len();
        self.count += 1;
        self.steps[slot] = step;
        &mut self.values[slot * self.width..][..self.width]
    }

    /// The newest sample that is old enough at this step, or else the oldest one: its step, whether it is old enough, its values.
    pub(super) fn front(&mut self, step: u64) -> Option<(u64, bool, &[f64])> {
        let delay = self.delay;
        let due = |taken: u64| taken.saturating_add(delay) <= step;
        while self.count > 1 && due(self.steps[(self.front + 1) % self.steps.len()]) {
            self.pop();
        }
        let taken = self.steps[self.front];
        (self.count > 0).then(|| (taken, due(taken), &self.values[self.front * self.width..][..self.width]))
    }

    fn pop(&mut self) {
        self.front = (self.front + 1) % self.steps.len();
        self.count -= 1;
    }
}

pub(super) fn check_delay(findings: &mut Findings, delay: f64, dt: f64) {
    check_not_negative(findings, [("delay", delay)]);
    if delay.is_finite() && delay / dt > MOST_DELAY {
        let most = MOST_DELAY * dt;
        findings.push(("delay", format!("expected at most {MOST_DELAY} steps, which are {most} s, found {delay} s")));
    }
}
