//! What there is: the components by role, and the scenarios that come with the program.

use formation::scenario::Shipped;
use formation::shipped;
use formation::wiring::Roles;

/// All components of this program.
pub const ROLES: Roles = Roles::new(plant::KINDS, high_level_planner::KINDS, observer::KINDS, low_level_ctrl::KINDS);

/// The scenarios of the thesis, in order of its chapters, and behind them those of the documentation.
pub const SCENARIOS: &[Shipped] = shipped![
    "../../scenarios/",
    "dsm-ftdo",
    "dsm-cnn",
    "rca",
    "limited-information",
    "cida",
    "compensated",
    "compensated-experiment",
    "lp-regulation",
    "uav",
    "mixed",
    "triangle"
];
