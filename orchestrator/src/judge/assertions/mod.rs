//! Assertions: bounds that a scenario sets to signals, checked while the run goes on and again from its log.
//!
//! ```toml
//! [[assert]]
//! name = "the wheels respect their limit"
//! signal = "peak(command.input)"
//! max = "UM"
//!
//! [[assert]]
//! name = "no two agents collide"
//! metric = "gap"          # to the nearest agent, m
//! min = 0
//!
//! [[assert]]
//! name = "what is fast keeps its distance"
//! signal = "norm(state.velocity) < 0.5 or gap > 1"
//! ```
//!
//! # Signals
//!
//! A signal is a formula with bounds, or a condition without (see [`formation::formula`]), evaluated for every agent at every
//! step. Besides the names that every
//! formula knows (`t`, `i`, `N`, `pi`, parameters of scenario and agent) and `UM`, the limit of the inputs, it may use
//!
//! | what                                | how                                                                     |
//! |-------------------------------------|-------------------------------------------------------------------------|
//! | a field of the agent's topics       | `state.position[2]`, counted from 0; a scalar without index             |
//! | a vector of it, or a difference     | `state.position`, `state.position[0:3] - reference.position`, only in:  |
//! | a vector as a number                | `norm(...)`, `peak(...)` (largest magnitude), `largest(...)`, `smallest(...)` |
//! | a metric                            | the names in [`METRICS`]                                                |
//!
//! The participants do not notice any of it: the orchestrator evaluates the samples that it fetches for the log.

mod bound;
mod field;
mod finding;
mod fold;
mod geometry;
mod history;
mod message;
mod read;
mod signal;
mod slot;
mod span;
mod watch;

#[cfg(test)]
mod tests;

pub use finding::{Finding, Findings, Violation};
pub(in crate::judge) use geometry::Geometry;
pub use geometry::METRICS;
#[cfg(test)]
pub(crate) use history::check;
pub(crate) use history::history;
pub(crate) use message::{DEFINITION, TOPIC, encode};
pub use read::read;
pub(crate) use read::schema;
pub(in crate::judge) use signal::{AgentSignal, constant};
pub use watch::Watch;

use formation::formula::{Condition, Formula};
use schemars::JsonSchema;
use serde::Deserialize;
use slot::Slot;

/// What a violation means for the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The run fails, with an exit code of its own.
    #[default]
    Fail,
    /// It is reported.
    Warn,
}

/// How the values of the agents become what is compared with the bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Across {
    /// Each by itself.
    #[default]
    Each,
    /// The root of the sum of their squares: the norm of the vector of all agents.
    Norm,
    /// Their sum.
    Sum,
}

/// A bound of a signal, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct Assertion {
    /// What it says, in words; each name once.
    pub name: String,
    /// The signal as the scenario writes it.
    pub signal: String,
    /// What a violation means.
    pub severity: Severity,
    /// Whether a violation ends the run.
    pub stop: bool,
    /// First and last step that are checked.
    pub steps: (u64, u64),
    across: Across,
    subjects: Vec<Subject>,
}

/// What an assertion compares.
#[derive(Clone, Debug)]
enum Signal {
    /// A number with its bounds.
    Number(Formula),
    /// A condition; its margin is what the bounds 0 and infinity are for.
    Condition(Condition),
}

/// The signal of one agent with its bounds.
#[derive(Clone, Debug)]
struct Subject {
    /// Number of the agent.
    agent: u32,
    signal: Signal,
    slots: Vec<Slot>,
    /// Lower bound, or minus infinity.
    min: f64,
    /// Upper bound, or infinity.
    max: f64,
}
