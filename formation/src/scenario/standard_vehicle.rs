//! `[vehicle]` with one of the vehicles of the thesis.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::config::did_you_mean;
use crate::vehicle::Actuator;

/// `[vehicle]`: what all agents have in common.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct VehicleSection {
    /// What the agents are.
    pub(super) kind: VehicleKind,
    /// 1: the inputs are wheel speeds, 2: wheel forces; for `omni`, where the agents do not say it themselves.
    #[serde(default)]
    pub(super) order: Option<u32>,
    /// Every input is clipped to [-UM, UM] by the actuators.
    #[serde(rename = "UM")]
    pub(super) input_limit: Option<f64>,
    /// Coordinates that are angles, such as `theta`: errors of the reference and of neighbours are taken on the circle. By default, all
    /// coordinates are numbers, as in the thesis.
    #[serde(default)]
    pub(super) angles: Vec<String>,
    /// What else the actuators do to the inputs.
    pub(super) actuator: Option<Actuator>,
}

/// The kinds of [`VehicleSection`].
pub(super) const STANDARD_KINDS: &[&str] = &["omni", "integrator", "quadcopter"];

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum VehicleKind {
    /// Robots with three omnidirectional wheels.
    Omni,
    /// Robots whose inputs are accelerations of x, y and heading.
    Integrator,
    /// Quadcopters: thrust and three torques.
    Quadcopter,
}

impl VehicleSection {
    /// What is wrong with its angles, if anything.
    pub(super) fn wrong_angle(&self) -> Option<String> {
        let known: &[&str] = match self.kind {
            VehicleKind::Quadcopter => &["phi", "theta", "psi"],
            VehicleKind::Omni | VehicleKind::Integrator => &["theta"],
        };
        let wrong = self.angles.iter().find(|name| !known.contains(&name.as_str()))?;
        let hint = did_you_mean(wrong, known.iter().copied());
        Some(format!("no angle of this vehicle is called `{wrong}`, expected one of {}{hint}", known.join(", ")))
    }

    /// What is wrong with this order for the vehicle, if anything.
    pub(super) fn wrong_order(&self, order: u32) -> Option<String> {
        let expected = match self.kind {
            VehicleKind::Omni if order == 1 || order == 2 => return None,
            VehicleKind::Omni => "expected 1 (wheel speeds) or 2 (wheel forces)",
            _ if order == 2 => return None,
            VehicleKind::Integrator => "the inputs of an integrator are accelerations, so expected 2 or no order",
            VehicleKind::Quadcopter => "a quadcopter has forces and torques as inputs, so expected 2 or no order",
        };
        Some(format!("{expected}, found {order}"))
    }
}
