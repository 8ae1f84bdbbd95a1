//! `on_failure`: what is to be done when a participant fails.

use lockstep::wait_time;
use serde::Deserialize;

use crate::config::{Node, Problems, read};

/// Restarts of a process that a run allows if the scenario does not say.
const RESTARTS: u32 = 3;
/// Most restarts of a process that a scenario may allow.
pub const MOST_RESTARTS: u32 = 20;
/// How long a phase of a step may take if the scenario does not say, s.
const DEADLINE: f64 = 10.0;

/// What is to be done when a participant fails: dies, hangs or reports a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnFailure {
    /// The run ends.
    #[default]
    Abort,
    /// It is started anew, computes all steps again from the recorded inputs, and goes on; nobody can tell from the log.
    Restart,
    /// Its last samples stand until the end of the run, marked as stale.
    Hold,
}

impl OnFailure {
    /// All of them with their names.
    pub const NAMES: [(&str, Self); 3] = [("abort", Self::Abort), ("restart", Self::Restart), ("hold", Self::Hold)];

    /// The policy of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, policy)| policy)
    }
}

/// The policies of all participants.
#[derive(Clone, Debug, PartialEq)]
pub struct FailurePolicy {
    /// Name of a participant or of a role, and what is to be done if it fails; the last entry that fits counts, that of a
    /// participant before that of its role.
    pub participants: Vec<(String, OnFailure)>,
    /// The policy of all others.
    pub others: OnFailure,
    /// How often a process may be restarted.
    pub restarts: u32,
    /// How long a phase of a step may take before those who have not finished count as failed, s.
    pub deadline: f64,
}

impl Default for FailurePolicy {
    fn default() -> Self {
        Self { participants: Vec::new(), others: OnFailure::Abort, restarts: RESTARTS, deadline: DEADLINE }
    }
}

impl FailurePolicy {
    /// What is to be done if `participant` fails.
    pub fn of(&self, participant: &str) -> OnFailure {
        let role = participant.split('_').next().unwrap_or(participant);
        let find = |name: &str| self.participants.iter().rev().find(|(known, _)| known == name);
        find(participant).or_else(|| find(role)).map_or(self.others, |&(_, policy)| policy)
    }

    /// Whether any participant is to be replaced when it fails.
    pub fn replaces_anybody(&self) -> bool {
        self.others != OnFailure::Abort || self.participants.iter().any(|&(_, policy)| policy != OnFailure::Abort)
    }

    /// Reads `on_failure`: a policy for all participants, or a table by participant.
    pub(super) fn read(root: &Node, problems: &mut Problems) -> Self {
        let mut policy = Self::default();
        let Some(node) = root.at("on_failure") else { return policy };
        let Some(table) = node.as_table() else {
            policy.others = read(node, "on_failure", problems).unwrap_or_default();
            return policy;
        };
        for (name, node) in table.iter() {
            let path = format!("on_failure.{name}");
            match name {
                "others" => policy.others = read(node, &path, problems).unwrap_or_default(),
                "restarts" => match node.as_i64().and_then(|value| u32::try_from(value).ok()) {
                    Some(restarts) if restarts <= MOST_RESTARTS => policy.restarts = restarts,
                    _ => drop(problems.at(root, &path, format!("expected a whole number from 0 to {MOST_RESTARTS}"))),
                },
                "deadline" => {
                    let checked =
                        read::<f64>(node, &path, problems).map(|deadline| wait_time(deadline).map(|_| deadline));
                    match checked {
                        Some(Ok(deadline)) => policy.deadline = deadline,
                        Some(Err(message)) => drop(problems.at(root, &path, message)),
                        None => {}
                    }
                }
                _ => {
                    if let Some(what) = read(node, &path, problems) {
                        policy.participants.push((name.replace('.', "_"), what));
                    }
                }
            }
        }
        policy
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::config::Source;

    fn read_text(text: &str) -> (FailurePolicy, String) {
        let source = Source { name: "s.toml".into(), text: text.into() };
        let mut problems = Problems::default();
        let policy = FailurePolicy::read(&Node::parse(Arc::new(source)).unwrap(), &mut problems);
        (policy, problems.to_string())
    }

    #[test]
    fn a_participant_goes_before_its_role() {
        let text =
            "[on_failure]\nothers = \"hold\"\ncontroller = \"restart\"\n\"controller.3\" = \"abort\"\nrestarts = 5\n";
        let (policy, problems) = read_text(text);
        assert_eq!(problems, "");
        let of = ["plant", "controller_1", "controller_3"].map(|name| policy.of(name));
        assert_eq!(of, [OnFailure::Hold, OnFailure::Restart, OnFailure::Abort]);
        assert_eq!(policy.restarts, 5);
    }

    #[test]
    fn one_word_stands_for_all() {
        assert_eq!(read_text("on_failure = \"restart\"").0.of("plant"), OnFailure::Restart);
        assert!(!read_text("").0.replaces_anybody());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let text = "[on_failure]\nplant = \"retry\"\nrestarts = -1\ndeadline = 0\n";
        let problems = read_text(text).1;
        for part in ["s.toml:2", "retry", "s.toml:3", "from 0 to 20", "s.toml:4", "above 0"] {
            assert!(problems.contains(part), "{part} is not in\n{problems}");
        }
    }
}
