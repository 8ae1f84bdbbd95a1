//! What all controllers of robots with speed-controlled wheels ask of a scenario.

use formation::config::PerAgent;
use formation::scenario::Context;
use formation::vehicle::{Drive, Omni};
use formation::wiring::{Checks, Refusal};

const UNFIT: &str = "this controller sets wheel speeds: it needs vehicles of kind `omni` and order 1";

/// Requires that the wheels of every vehicle are driven by speed.
pub(crate) fn require_speed_vehicles(checks: Checks, context: &Context) -> Checks {
    let fit = (0..context.agents.len()).all(|agent| speed_vehicle(context, agent).is_ok());
    checks.require(fit, "kind", UNFIT)
}

/// The vehicle of `agent` as its controller knows it.
pub(crate) fn speed_vehicle(context: &Context, agent: usize) -> Result<Omni, Refusal> {
    let omni = context.agents[agent].nominal.omni().filter(|omni| omni.drive == Drive::Speed);
    omni.cloned().ok_or_else(|| Refusal(UNFIT.into()))
}

/// The value of a parameter for `agent`.
pub(crate) fn resolved(parameter: &PerAgent, context: &Context, agent: usize) -> Result<f64, Refusal> {
    context.value(parameter, agent).map_err(Refusal)
}
