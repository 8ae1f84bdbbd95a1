//! What is computed from a log: one file per scheme, a set of metrics each.

mod cida;
mod compensated;
mod compensated_experiment;
mod dsm;
mod limited_information;
mod lp_regulation;
mod mixed;
mod rca;
mod speed_formation;
mod uav;

use orchestrator::judge::metrics::{DerivedSignal, MetricSet};

/// All sets of metrics.
pub const SETS: &[MetricSet] = &[
    MetricSet { name: "dsm", compute: dsm::compute, definitions: dsm::DEFINITIONS },
    MetricSet { name: "rca", compute: rca::compute, definitions: rca::DEFINITIONS },
    MetricSet {
        name: "limited-information",
        compute: limited_information::compute,
        definitions: limited_information::DEFINITIONS,
    },
    MetricSet { name: "cida", compute: cida::compute, definitions: cida::DEFINITIONS },
    MetricSet { name: "compensated", compute: compensated::compute, definitions: compensated::DEFINITIONS },
    MetricSet {
        name: "compensated-experiment",
        compute: compensated_experiment::compute,
        definitions: compensated_experiment::DEFINITIONS,
    },
    MetricSet { name: "lp_regulation", compute: lp_regulation::compute, definitions: lp_regulation::DEFINITIONS },
    MetricSet { name: "uav", compute: uav::compute, definitions: uav::DEFINITIONS },
    MetricSet { name: "mixed", compute: mixed::compute, definitions: mixed::DEFINITIONS },
];

/// Quantities of figures that no participant publishes.
pub const SIGNALS: &[DerivedSignal] = &[
    // ‖E - Ê‖ of robots that are commanded by speeds: their whole uncertainty, that of the wheels' effect included.
    DerivedSignal { name: "uncertainty_error", compute: speed_formation::uncertainty_error },
    // ‖E - Ê‖ of a network that learns `dw/dt + (k + λ) w`.
    DerivedSignal { name: "network_error", compute: dsm::network_error },
    // ‖s‖ made of the true velocities, which the controller does not know.
    DerivedSignal { name: "sliding", compute: limited_information::sliding },
];
