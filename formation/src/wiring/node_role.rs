//! Which participant a node of the network is.

use crate::role::Role;

/// What a node of the network is: a role and the agents (from 0) that it serves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeRole {
    /// The role.
    pub role: Role,
    /// The agents, from 0.
    pub agents: Vec<usize>,
}
