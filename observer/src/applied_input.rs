//! The input that acted since the last step, as an observer may know it.

use formation::math::clip;
use formation::nalgebra::SVector;
use formation::scenario::Context;
use formation::vehicle::{MAX_COORDINATES, MAX_INPUTS, Vehicle};
use formation::wiring::{Bind, Refusal, Role};
use lockstep::{Io, Slice, Timing};

/// The command of the step before, within the limits of the actuators, and what the nominal vehicle makes of it.
#[derive(Clone, Debug)]
pub(crate) struct AppliedInput {
    vehicle: Vehicle,
    limit: Option<f64>,
    command: Slice,
}

impl AppliedInput {
    /// Binds the command of `agent`.
    pub(crate) fn new(context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let vehicle = context.agents[agent].nominal.clone();
        let command = bind.slice(Role::Controller, agent, "input", vehicle.inputs(), Timing::Delayed)?;
        Ok(Self { vehicle, limit: context.input_limit, command })
    }

    /// The input as the actuators clipped it, 0 behind its last component.
    pub(crate) fn values(&self, io: &Io) -> [f64; MAX_INPUTS] {
        let mut values = [0.0; MAX_INPUTS];
        for (value, command) in values.iter_mut().zip(io.slice(self.command)) {
            *value = self.limit.map_or(*command, |limit| clip(*command, limit));
        }
        values
    }

    /// `ĝ(x) u` and the known drift, for these coordinates x.
    pub(crate) fn effect<const D: usize>(&self, io: &Io, coordinates: &SVector<f64, D>) -> SVector<f64, D> {
        let mut effect = [0.0; MAX_COORDINATES];
        let values = self.values(io);
        self.vehicle.effect(coordinates.as_slice(), &values[..self.vehicle.inputs()], &mut effect);
        SVector::from_fn(|j, _| effect[j] + self.vehicle.drift(j))
    }
}
