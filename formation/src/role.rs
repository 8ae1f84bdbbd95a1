//! The roles of a participant.

use serde::{Deserialize, Serialize};

/// The four roles of a participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Integrates the vehicles and publishes their states.
    Plant,
    /// Publishes what every agent has to track.
    Planner,
    /// Estimates what the sensors of one agent do not tell.
    Observer,
    /// Computes the input of one agent.
    Controller,
}

impl Role {
    /// All roles in order of a step.
    pub const ALL: [Role; 4] = [Role::Plant, Role::Planner, Role::Observer, Role::Controller];

    /// The section of a scenario file and the first part of a node's name.
    pub fn name(self) -> &'static str {
        match self {
            Role::Plant => "plant",
            Role::Planner => "planner",
            Role::Observer => "observer",
            Role::Controller => "controller",
        }
    }

    /// Last part of the topics on which the role publishes.
    pub fn channel(self) -> &'static str {
        match self {
            Role::Plant => "state",
            Role::Planner => "reference",
            Role::Observer => "estimate",
            Role::Controller => "command",
        }
    }
}

impl std::fmt::Display for Role {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}
