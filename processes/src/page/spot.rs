//! Where processes sleep.

/// Where a process sleeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spot {
    /// The conductor.
    Bell,
    /// The workers of a phase.
    Gate(usize),
}
