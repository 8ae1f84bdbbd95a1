//! The result of a conformance test: one check for each point of the contract.

/// The result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The requirement is met.
    Pass,
    /// It is not met.
    Fail,
    /// Information without a requirement.
    Note,
    /// Could not be checked, because an earlier check failed.
    Untried,
}

impl Verdict {
    /// In one word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "FAIL",
            Self::Note => "note",
            Self::Untried => "----",
        }
    }
}

/// A check of one point of the contract.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// Its name, one word; stable, for programs.
    pub name: &'static str,
    /// What is required.
    pub requirement: &'static str,
    /// The result.
    pub verdict: Verdict,
    /// What was seen.
    pub finding: String,
    /// What to do about it; empty if it passes.
    pub advice: &'static str,
}

/// All checks, in the order in which they were made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The checks.
    pub checks: Vec<Check>,
}

/// The points of the contract: name, requirement, what to do if it is not met.
const CONTRACT: &[(&str, &str, &str)] = &[
    (
        "start",
        "it connects in time",
        "start it by hand: outside a run, a program that works says only how it is started",
    ),
    (
        "alone",
        "outside a run it says so and ends with an exit code other than 0",
        "call serve first thing in main and return its exit code; do not wait for anything",
    ),
    ("plan", "it refuses a plan whose digest is wrong", "let the library read the plan; do not read plan.json by hand"),
    (
        "signals",
        "it refuses a run whose signals are not those that it was written for",
        "bind every signal by its name, and pass the refusal on instead of going on without it",
    ),
    (
        "steps",
        "it answers every step, with every number of the outputs that it binds",
        "return from every step within the deadline and write every output that you bind; report what you cannot compute as a fault, do not exit or abort",
    ),
    (
        "outputs",
        "which of its outputs are zero at every step, as what it does not bind",
        "bind and write the outputs that others read",
    ),
    ("ranges", "its outputs stay within the ranges that --range gives", "limit the output, or correct the range"),
    (
        "inputs",
        "it leaves the samples of others as they are",
        "read the inputs through the library only; never write into shared memory yourself",
    ),
    (
        "end",
        "after the last step it ends by itself, with exit code 0",
        "return the exit code of serve from main, and do nothing that lasts after it",
    ),
    (
        "left",
        "it leaves no process behind",
        "end the processes that you started, and wait for them, before you return from main",
    ),
    (
        "output",
        "it prints little",
        "print at the start and on trouble, not at every step; what is worth keeping belongs into an output",
    ),
    (
        "repeat",
        "the same inputs give the same outputs, bit by bit",
        "use no clock, no random numbers without a fixed seed, no threads that race, no memory that was not written",
    ),
    (
        "stop",
        "stopped in the middle it ends by itself in time, with exit code 0",
        "return from main when serve returns; install no handler that keeps the process alive",
    ),
    (
        "absurd",
        "inputs out of all bounds neither hang nor crash it",
        "bound every loop by a number of rounds, and check what you divide by and index with",
    ),
    ("reference", "how far it departs from what was recorded", ""),
    ("speed", "how long a step takes", ""),
];

impl Report {
    /// Adds a check of the point called `name`.
    ///
    /// # Panics
    /// If the contract has no such point.
    pub(super) fn add(&mut self, name: &str, verdict: Verdict, finding: impl Into<String>) {
        let (name, requirement, advice) =
            *CONTRACT.iter().find(|check| check.0 == name).expect("a point of the contract");
        let advice = if verdict == Verdict::Fail { advice } else { "" };
        self.checks.push(Check { name, requirement, verdict, finding: finding.into(), advice });
    }

    /// Adds a check with its own advice.
    ///
    /// # Panics
    /// See [`Report::add`].
    pub(super) fn add_with(&mut self, name: &str, verdict: Verdict, finding: String, advice: &'static str) {
        self.add(name, verdict, finding);
        if let Some(check) = self.checks.last_mut() {
            check.advice = advice;
        }
    }

    /// Adds a check that passes or fails.
    pub(super) fn judge(&mut self, name: &str, kept: bool, finding: impl Into<String>) {
        self.add(name, if kept { Verdict::Pass } else { Verdict::Fail }, finding);
    }

    /// Adds checks that could not be made.
    pub(super) fn skip(&mut self, names: &[&str], reason: &str) {
        names.iter().for_each(|name| self.add(name, Verdict::Untried, reason));
    }

    /// Whether every check was made and none failed.
    pub fn ok(&self) -> bool {
        self.checks.iter().all(|check| matches!(check.verdict, Verdict::Pass | Verdict::Note))
    }
}
