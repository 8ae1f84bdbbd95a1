//! What there is: the components by role, and the scenarios that come with the program.

use formation::wiring::Roles;

/// All components of this program.
pub const ROLES: Roles = Roles {
    plant: plant::KINDS,
    planner: high_level_planner::KINDS,
    observer: observer::KINDS,
    controller: low_level_ctrl::KINDS,
};

/// A scenario that is compiled into the program.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// Its name, `uav`.
    pub name: &'static str,
    /// Where its file is in the repository.
    pub file: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(Shipped {
            name: $name,
            file: concat!("scenarios/", $name, ".toml"),
            text: include_str!(concat!("../../scenarios/", $name, ".toml")),
        }),*]
    };
}

/// The scenarios of the thesis, in order of its chapters, and behind them those of the documentation.
pub const SCENARIOS: &[Shipped] = shipped![
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
