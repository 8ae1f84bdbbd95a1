//! Shipped scenarios in this process, step by step, and their values compared with golden ones.
//!
//! Nothing here depends on the crate `processes`, so a law is tested without building what runs processes.

use formation::scenario::Selection;
use formation::wiring::Assembly;
use lockstep::Local;
use schemes::{ROLES, SCENARIOS};

/// A shipped scenario that runs in this process, step by step.
pub struct Bench {
    local: Local,
    /// The last step that ran.
    step: Option<u64>,
    dt: f64,
}

impl Bench {
    /// Prepares the scenario `name` with overrides `PATH=VALUE`.
    ///
    /// # Panics
    /// If the scenario is not valid.
    pub fn new(name: &str, overrides: &[&str]) -> Self {
        let shipped = SCENARIOS.iter().find(|shipped| shipped.name == name).expect("a shipped scenario");
        let selection =
            Selection { overrides: overrides.iter().map(|o| o.to_string()).collect(), ..Selection::default() };
        let assembly =
            Assembly::load(shipped.file, shipped.text, &selection, &ROLES).unwrap_or_else(|p| panic!("{}", p[0]));
        let nodes: Vec<usize> = (0..assembly.network.nodes.len()).collect();
        let participants = assembly.participants(&nodes).unwrap_or_else(|p| panic!("{}", p[0]));
        let dt = assembly.scenario.context.timing.dt;
        let local = Local::new(assembly.network, participants, dt).expect("no algebraic loop");
        Self { local, step: None, dt }
    }

    /// Runs up to and including the step at `time` seconds.
    ///
    /// # Panics
    /// If a participant faults.
    pub fn run_to(&mut self, time: f64) {
        let last = (time / self.dt).round() as u64;
        while self.step.is_none_or(|step| step < last) {
            self.step = Some(self.local.step().expect("no fault"));
        }
    }

    /// The values of a signal at the last step.
    ///
    /// # Panics
    /// If there is no such signal.
    pub fn signal(&self, topic: &str, field: &str) -> Vec<f64> {
        let channels = &self.local.network().channels;
        let id = channels.iter().position(|channel| channel.topic == topic).unwrap_or_else(|| panic!("no {topic}"));
        let (start, length) = channels[id].layout.find(field).unwrap_or_else(|| panic!("no {field} in {topic}"));
        self.local.store().read(lockstep::ChannelId(id), self.step.expect("a step"))[start..start + length].to_vec()
    }

    /// Compares a signal (from its element `first` on) with golden values, given to nine digits.
    ///
    /// # Panics
    /// If a value differs by more than one unit of the ninth digit, and by more than `floor`.
    pub fn expect(&self, topic: &str, field: &str, first: usize, golden: &[f64], floor: f64) {
        self.expect_within(topic, field, first, golden, 1e-8, floor);
    }

    /// Compares a signal with golden values up to a relative tolerance, or `floor` where that is larger.
    ///
    /// # Panics
    /// If a value differs by more.
    pub fn expect_within(&self, topic: &str, field: &str, first: usize, golden: &[f64], relative: f64, floor: f64) {
        let values = self.signal(topic, field);
        for (j, expected) in golden.iter().enumerate() {
            let value = values[first + j];
            let tolerance = (expected.abs() * relative).max(floor);
            assert!(
                (value - expected).abs() <= tolerance,
                "{topic} {field}[{}] at step {}: {value:.12e}, expected {expected:e} within {tolerance:e}",
                first + j,
                self.step.expect("a step"),
            );
        }
    }
}
