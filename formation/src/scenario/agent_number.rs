//! The number of an agent.

use std::fmt::{self, Display, Formatter};
use std::num::NonZeroUsize;

/// The number of an agent, counted from 1 as in scenario files, topics and messages.
///
/// Lists such as [`Context::agents`](super::Context::agents) are indexed with [`AgentNumber::index`].
///
/// ```
/// use formation::scenario::AgentNumber;
/// let third = AgentNumber::new(3).unwrap();
/// assert_eq!((third.to_string(), third.index()), ("3".to_string(), 2));
/// assert_eq!(AgentNumber::new(0), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AgentNumber(NonZeroUsize);

impl AgentNumber {
    /// The agent of this number; `None` for 0, which is no agent.
    pub fn new(number: usize) -> Option<Self> {
        NonZeroUsize::new(number).map(Self)
    }

    /// The agent at this index of a list of all agents.
    pub fn at(index: usize) -> Self {
        Self(NonZeroUsize::MIN.saturating_add(index))
    }

    /// Its number, from 1.
    pub fn get(self) -> usize {
        self.0.get()
    }

    /// Its index in a list of all agents, from 0.
    pub fn index(self) -> usize {
        self.0.get() - 1
    }
}

impl Display for AgentNumber {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
