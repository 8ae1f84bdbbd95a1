//! What lies between the command and the vehicle.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::math::BoucWen;

/// `[vehicle.actuator]`: the actuators of all inputs of all agents.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Whether the actuators have hysteresis; if not, they are ideal.
    pub hysteresis: bool,
    /// The hysteresis, which controllers may know even if the actuators are ideal.
    pub bouc_wen: BoucWen,
}
