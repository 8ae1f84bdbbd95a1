//! What every agent has to track: reference trajectories, virtual agents, reference correction.

mod correction;
mod reference;
mod reference_correction;
mod trajectory;
mod virtual_agents;

pub use correction::{Correction, Tangent};
pub use reference::Reference;
pub use reference_correction::{ReferenceCorrection, Source};
pub use trajectory::{Trajectory, TrajectorySample};
pub use virtual_agents::{SaturatedVirtualAgents, VirtualAgents, VirtualLayer, VirtualLayerGains};

use formation::wiring::Kind;

/// Every planner that a scenario may name.
pub const KINDS: &[Kind] = &[
    Kind::of::<Reference>("reference", "the reference trajectory of each agent, as the scenario gives it"),
    Kind::of::<ReferenceCorrection>(
        "reference_correction",
        "the reference, or virtual agents that form up on it, kept reachable around obstacles (Algorithm 1)",
    ),
    Kind::of::<SaturatedVirtualAgents>(
        "saturated_virtual_agents",
        "virtual agents with bounded acceleration that form up on the reference (7.13) to (7.18)",
    ),
    Kind::of::<VirtualAgents>("virtual_agents", "virtual agents that form up on the reference (7.55) to (7.58)"),
];
