//! The dynamic sliding variable of chapter 2, which all its controllers drive to zero. (2.9), (2.14)

use std::borrow::Cow;

use formation::math::NeighbourhoodSchedule;
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::vehicle::Drive;
use formation::wiring::{Bind, Refusal, Role};
use lockstep::{In, Io, Timing};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use crate::LocalError;

/// Errors of an agent relative to the reference, and to its neighbours if it has any, at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingErrors {
    /// δv of the agent itself.
    pub own_velocity: Vector3<f64>,
    /// ex, or δx of the agent alone.
    pub position: Vector3<f64>,
    /// ev, or δv of the agent alone.
    pub velocity: Vector3<f64>,
    /// The derivative of `velocity`, if the accelerations are known.
    pub acceleration: Option<Vector3<f64>>,
}

/// `ξ = dρ/dt + λ ρ` with `ρ = ev + k ex`.
#[derive(Clone, Debug, PartialEq)]
pub struct DynamicSlidingVariable {
    /// k, 1/s.
    k: f64,
    /// λ, 1/s.
    lambda: f64,
    /// ρ of the step before.
    before: Option<Vector3<f64>>,
    /// ξ.
    pub value: Vector3<f64>,
}

impl DynamicSlidingVariable {
    /// A variable with these slopes, in 1/s.
    pub fn new(k: f64, lambda: f64) -> Self {
        Self { k, lambda, before: None, value: Vector3::zeros() }
    }

    /// Forms ξ at this instant. Without accelerations the derivative of ρ is its last backward difference, 0 at first.
    pub fn update(&mut self, dt: f64, errors: &SlidingErrors) {
        let rho = errors.velocity + self.k * errors.position; // (2.9), (2.14)
        let rate = match (errors.acceleration, self.before) {
            (Some(acceleration), _) => acceleration + self.k * errors.velocity,
            (None, Some(before)) => (rho - before) / dt,
            (None, None) => Vector3::zeros(),
        };
        self.value = rate + self.lambda * rho;
        self.before = Some(rho);
    }
}

/// Where the accelerations in the derivative of ρ come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccelerationSource {
    /// `bd`: from nowhere, ρ is differentiated by a backward difference.
    Difference,
    /// `ftdo`: input and estimated uncertainty of every agent concerned.
    Observer,
    /// `true`: the plant says them.
    Plant,
}

impl<'de> Deserialize<'de> for AccelerationSource {
    /// The command line takes a bare `true` for a boolean, so that is read as well.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SourceVisitor)
    }
}

impl JsonSchema for AccelerationSource {
    fn schema_name() -> Cow<'static, str> {
        "AccelerationSource".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "enum": ["bd", "ftdo", "true", true] })
    }
}

struct SourceVisitor;

impl serde::de::Visitor<'_> for SourceVisitor {
    type Value = AccelerationSource;

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str("one of \"bd\", \"ftdo\", \"true\"")
    }

    fn visit_bool<E: serde::de::Error>(self, value: bool) -> Result<AccelerationSource, E> {
        self.visit_str(if value { "true" } else { "false" })
    }

    fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<AccelerationSource, E> {
        match value {
            "bd" => Ok(AccelerationSource::Difference),
            "ftdo" => Ok(AccelerationSource::Observer),
            "true" => Ok(AccelerationSource::Plant),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(value), &self)),
        }
    }
}

/// The laws of this chapter take the input for an acceleration.
pub(crate) fn require_integrator(context: &Context, agent: usize) -> Result<(), Refusal> {
    match context.agents[agent].nominal.omni() {
        Some(omni) if omni.drive == Drive::Acceleration => Ok(()),
        _ => {
            let message = "dynamic sliding mode works on accelerations of x, y and heading: it needs `kind = \"integrator\"` in `[vehicle]`";
            Err(Refusal(message.into()))
        }
    }
}

/// The signals that the errors are formed from.
#[derive(Clone, Debug)]
pub(crate) struct ErrorPorts {
    position: LocalError,
    velocity: LocalError,
    acceleration: AccelerationPorts,
}

#[derive(Clone, Debug)]
enum AccelerationPorts {
    None,
    Plant(LocalError),
    Observer { graph: NeighbourhoodSchedule, own: ObservedAcceleration, others: Vec<ObservedAcceleration> },
}

/// What makes up `u + γ2 - ddxd` of one agent.
#[derive(Clone, Copy, Debug)]
struct ObservedAcceleration {
    /// u of this instant, which its controller announced at the step before.
    input: In<3>,
    disturbance: In<3>,
    reference: In<3>,
}

impl ErrorPorts {
    /// Binds what `agent` and its in-neighbours publish.
    pub(crate) fn formation(
        context: &Context,
        agent: usize,
        bind: &mut Bind,
        source: AccelerationSource,
    ) -> Result<Self, Refusal> {
        let acceleration = match source {
            AccelerationSource::Difference => AccelerationPorts::None,
            AccelerationSource::Plant => {
                AccelerationPorts::Plant(LocalError::new(context, agent, bind, "acceleration")?)
            }
            AccelerationSource::Observer => {
                let graph = context.topology.neighbourhood(agent);
                let own = ObservedAcceleration::new(agent, bind)?;
                let others = graph.heard().iter().map(|&other| ObservedAcceleration::new(other, bind));
                AccelerationPorts::Observer { own, others: others.collect::<Result<_, _>>()?, graph }
            }
        };
        Ok(Self {
            position: LocalError::new(context, agent, bind, "position")?,
            velocity: LocalError::new(context, agent, bind, "velocity")?,
            acceleration,
        })
    }

    /// Binds what `agent` itself publishes.
    pub(crate) fn alone(agent: usize, bind: &mut Bind, source: AccelerationSource) -> Result<Self, Refusal> {
        let acceleration = match source {
            AccelerationSource::Difference => AccelerationPorts::None,
            AccelerationSource::Plant => AccelerationPorts::Plant(LocalError::alone(agent, bind, "acceleration")?),
            AccelerationSource::Observer => {
                let message =
                    "`accel = \"ftdo\"` needs the disturbance observers of a formation; this law works without";
                return Err(Refusal(message.into()));
            }
        };
        Ok(Self {
            position: LocalError::alone(agent, bind, "position")?,
            velocity: LocalError::alone(agent, bind, "velocity")?,
            acceleration,
        })
    }

    pub(crate) fn read(&self, io: &Io) -> SlidingErrors {
        let acceleration = match &self.acceleration {
            AccelerationPorts::None => None,
            AccelerationPorts::Plant(errors) => Some(errors.local(io)),
            AccelerationPorts::Observer { graph, own, others } => {
                Some(graph.local_error(io.step(), &own.read(io), |place| others[place].read(io)))
            }
        };
        SlidingErrors {
            own_velocity: self.velocity.own(io),
            position: self.position.local(io),
            velocity: self.velocity.local(io),
            acceleration,
        }
    }
}

impl ObservedAcceleration {
    fn new(agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        Ok(Self {
            input: bind.read(Role::Controller, agent, "next_input", Timing::Delayed)?,
            disturbance: bind.estimate(agent, "disturbance")?,
            reference: bind.reference(agent, "acceleration")?,
        })
    }

    fn read(&self, io: &Io) -> Vector3<f64> {
        let [input, disturbance, reference] =
            [self.input, self.disturbance, self.reference].map(|signal| Vector3::from(io.get(signal)));
        input + disturbance - reference
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(position: f64, velocity: f64, acceleration: Option<f64>) -> SlidingErrors {
        SlidingErrors {
            own_velocity: Vector3::zeros(),
            position: Vector3::repeat(position),
            velocity: Vector3::repeat(velocity),
            acceleration: acceleration.map(Vector3::repeat),
        }
    }

    #[test]
    fn backward_difference_with_nothing_before_the_first_step() {
        let mut sliding = DynamicSlidingVariable::new(3.0, 2.0);
        sliding.update(0.1, &errors(1.0, 0.5, None));
        assert_eq!(sliding.value, Vector3::repeat(2.0 * 3.5));
        sliding.update(0.1, &errors(1.1, 0.4, None));
        assert!((sliding.value[0] - ((3.7 - 3.5) / 0.1 + 2.0 * 3.7)).abs() < 1e-12);
    }

    #[test]
    fn a_known_acceleration_replaces_the_difference() {
        let mut sliding = DynamicSlidingVariable::new(3.0, 2.0);
        sliding.update(0.1, &errors(1.0, 0.5, Some(-0.7)));
        assert!((sliding.value[0] - (-0.7 + 1.5 + 2.0 * 3.5)).abs() < 1e-12);
    }

    /// On the surface ξ = 0 the error obeys (d/dt + λ)(d/dt + k) ex = 0 and dies out at the slower of the two rates.
    #[test]
    fn errors_die_out_on_the_surface() {
        let (k, lambda, dt) = (3.0, 2.0, 1e-4);
        let (mut x, mut v) = (1.0, 0.0);
        for _ in 0..50_000 {
            let acceleration = -(k + lambda) * v - k * lambda * x;
            let mut sliding = DynamicSlidingVariable::new(k, lambda);
            sliding.update(dt, &errors(x, v, Some(acceleration)));
            assert!(sliding.value.norm() < 1e-12);
            (x, v) = (x + dt * v, v + dt * acceleration);
        }
        assert!(x.abs() < 3.1 * libm::exp(-2.0 * 5.0), "{x}");
    }
}
