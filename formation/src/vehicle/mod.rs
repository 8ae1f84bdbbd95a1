//! Models of the agents: what their inputs do. Used by the plant, and by the observers and controllers that know it.

mod actuator;
mod model;
mod omni;
mod quadcopter;

pub use actuator::Actuator;
pub use model::{Model, ModelOutput, Variable, evaluate, units};
pub use omni::{Drive, Omni};
pub use quadcopter::Quadcopter;

use std::sync::Arc;

use lockstep::Field;

/// A vehicle with its parameters.
///
/// The generalised coordinates obey `dx/dt = g(x) u` (order 1) or `dv/dt = g(x) u + drift` (order 2), disturbances aside.
#[derive(Clone, Debug)]
pub enum Vehicle {
    /// A planar robot: three-wheel omni-directional base, or a double integrator.
    Omni(Omni),
    /// A quadcopter with thrust and torques as inputs.
    Quadcopter(Quadcopter),
    /// A vehicle by equations; what is said above of `g` does not hold for it.
    Model(Arc<Model>),
}

/// Largest number of generalised coordinates of the vehicles of the thesis.
pub const MAX_COORDINATES: usize = 6;

/// Largest number of inputs of the vehicles of the thesis.
pub const MAX_INPUTS: usize = 4;

impl Vehicle {
    /// Number of generalised coordinates: 3 or 6; of a vehicle by equations, the length of its position.
    pub fn coordinates(&self) -> usize {
        match self {
            Vehicle::Omni(_) => 3,
            Vehicle::Quadcopter(_) => 6,
            Vehicle::Model(model) => model.position.len(),
        }
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        match self {
            Vehicle::Omni(_) => 3,
            Vehicle::Quadcopter(_) => 4,
            Vehicle::Model(model) => model.inputs.len(),
        }
    }

    /// 1 if the inputs set velocities, 2 if they set accelerations. That of a vehicle by equations is 2 if its velocity consists of
    /// states.
    pub fn order(&self) -> usize {
        match self {
            Vehicle::Omni(omni) => omni.order(),
            Vehicle::Quadcopter(_) => 2,
            Vehicle::Model(model) => 1 + usize::from(model.leading.contains(&true)),
        }
    }

    /// What the input is called and measured in.
    pub fn input_field(&self) -> Field {
        let unit = match self {
            Vehicle::Omni(omni) => omni.input_unit(),
            Vehicle::Quadcopter(_) => "N",
            Vehicle::Model(model) => return model.input_field(),
        };
        Field::vector("input", self.inputs(), unit)
    }

    /// Names of the coordinates in formulas, in order.
    pub fn coordinate_names(&self) -> &'static [&'static str] {
        match self {
            Vehicle::Omni(_) => &["px", "py", "theta"],
            Vehicle::Quadcopter(_) => &["px", "py", "pz", "phi", "theta", "psi"],
            Vehicle::Model(_) => &[],
        }
    }

    /// Names of the velocities in formulas, in order.
    pub fn velocity_names(&self) -> &'static [&'static str] {
        match self {
            Vehicle::Omni(_) => &["vx", "vy", "omega"],
            Vehicle::Quadcopter(_) => &["vx", "vy", "vz", "dphi", "dtheta", "dpsi"],
            Vehicle::Model(_) => &[],
        }
    }

    /// Writes `g(x) u`, the acceleration (or velocity, order 1) that the input causes at the coordinates `x`; nothing for a vehicle
    /// by equations.
    pub fn effect(&self, x: &[f64], u: &[f64], out: &mut [f64]) {
        match self {
            Vehicle::Omni(omni) => {
                let effect = omni.matrix(x[2]) * nalgebra::Vector3::from_column_slice(u);
                out[..3].copy_from_slice(effect.as_slice());
            }
            Vehicle::Quadcopter(quadcopter) => quadcopter.effect(x, u, out),
            Vehicle::Model(_) => {}
        }
    }

    /// The known constant acceleration of coordinate `j`: gravity for the height of a quadcopter, else 0.
    pub fn drift(&self, j: usize) -> f64 {
        match self {
            Vehicle::Quadcopter(_) if j == 2 => -quadcopter::GRAVITY,
            _ => 0.0,
        }
    }

    /// The planar base, if this is one.
    pub fn omni(&self) -> Option<&Omni> {
        match self {
            Vehicle::Omni(omni) => Some(omni),
            Vehicle::Quadcopter(_) | Vehicle::Model(_) => None,
        }
    }

    /// The quadcopter, if this is one.
    pub fn quadcopter(&self) -> Option<&Quadcopter> {
        match self {
            Vehicle::Quadcopter(quadcopter) => Some(quadcopter),
            Vehicle::Omni(_) | Vehicle::Model(_) => None,
        }
    }

    /// The equations, if it is given by those.
    pub fn model(&self) -> Option<&Arc<Model>> {
        match self {
            Vehicle::Model(model) => Some(model),
            Vehicle::Omni(_) | Vehicle::Quadcopter(_) => None,
        }
    }

    /// What it is called: the `kind` of scenario files.
    pub fn kind(&self) -> &str {
        match self {
            Vehicle::Omni(omni) if omni.drive == Drive::Acceleration => "integrator",
            Vehicle::Omni(_) => "omni",
            Vehicle::Quadcopter(_) => "quadcopter",
            Vehicle::Model(model) => &model.kind,
        }
    }

    /// Number of coordinates of the place where it is: 2 for a planar robot, 3 for a quadcopter.
    pub fn dimensions(&self) -> usize {
        match self {
            Vehicle::Omni(_) => 2,
            Vehicle::Quadcopter(_) => 3,
            Vehicle::Model(model) => model.position.len(),
        }
    }

    /// The signal that is the heading of a vehicle by equations in the plane, if one of its angles is called as a heading is.
    pub fn heading(&self) -> Option<&str> {
        const NAMES: [&str; 4] = ["theta", "psi", "heading", "yaw"];
        let model = self.model().filter(|model| model.position.len() == 2)?;
        let mut angles = model.states.iter().zip(&model.angles).filter(|(_, is_angle)| **is_angle);
        angles.find(|(state, _)| NAMES.contains(&state.name.as_str())).map(|(state, _)| state.name.as_str())
    }

    /// Radius of its body, m: that of a planar robot, the arm of a quadcopter, or the parameter `radius` or `arm` of equations.
    pub fn radius(&self) -> Option<f64> {
        match self {
            Vehicle::Omni(omni) => Some(omni.radius),
            Vehicle::Quadcopter(quadcopter) => Some(quadcopter.arm),
            Vehicle::Model(model) => model.parameter("radius").or_else(|| model.parameter("arm")),
        }
    }

    /// Value of the parameter called `name` in scenario files, for use in formulas.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        match self {
            Vehicle::Omni(omni) => omni.parameter(name),
            Vehicle::Quadcopter(quadcopter) => quadcopter.parameter(name),
            Vehicle::Model(model) => model.parameter(name),
        }
    }
}
