//! Models of the agents: what their inputs do. Used by the plant, and by the observers and controllers that know it.

mod actuator;
mod omni;
mod quadcopter;

pub use actuator::Actuator;
pub use omni::{Drive, Omni};
pub use quadcopter::Quadcopter;

use lockstep::Field;

/// A vehicle with its parameters.
///
/// The generalised coordinates obey `dx/dt = g(x) u` (order 1) or `dv/dt = g(x) u + drift` (order 2), disturbances aside.
#[derive(Clone, Debug, PartialEq)]
pub enum Vehicle {
    /// A planar robot: three-wheel omni-directional base, or a double integrator.
    Omni(Omni),
    /// A quadcopter with thrust and torques as inputs.
    Quadcopter(Quadcopter),
}

/// Largest number of generalised coordinates of any vehicle.
pub const MAX_COORDINATES: usize = 6;

/// Largest number of inputs of any vehicle.
pub const MAX_INPUTS: usize = 4;

impl Vehicle {
    /// Number of generalised coordinates: 3 or 6.
    pub fn coordinates(&self) -> usize {
        match self {
            Vehicle::Omni(_) => 3,
            Vehicle::Quadcopter(_) => 6,
        }
    }

    /// Number of inputs: 3 or 4.
    pub fn inputs(&self) -> usize {
        match self {
            Vehicle::Omni(_) => 3,
            Vehicle::Quadcopter(_) => 4,
        }
    }

    /// 1 if the inputs set velocities, 2 if they set accelerations.
    pub fn order(&self) -> usize {
        match self {
            Vehicle::Omni(omni) => omni.order(),
            Vehicle::Quadcopter(_) => 2,
        }
    }

    /// What the input is called and measured in.
    pub fn input_field(&self) -> Field {
        let unit = match self {
            Vehicle::Omni(omni) => omni.input_unit(),
            Vehicle::Quadcopter(_) => "N",
        };
        Field::vector("input", self.inputs(), unit)
    }

    /// Names of the coordinates in formulas, in order.
    pub fn coordinate_names(&self) -> &'static [&'static str] {
        match self {
            Vehicle::Omni(_) => &["px", "py", "theta"],
            Vehicle::Quadcopter(_) => &["px", "py", "pz", "phi", "theta", "psi"],
        }
    }

    /// Names of the velocities in formulas, in order.
    pub fn velocity_names(&self) -> &'static [&'static str] {
        match self {
            Vehicle::Omni(_) => &["vx", "vy", "omega"],
            Vehicle::Quadcopter(_) => &["vx", "vy", "vz", "dphi", "dtheta", "dpsi"],
        }
    }

    /// Writes `g(x) u`, the acceleration (or velocity, order 1) that the input causes at the coordinates `x`.
    pub fn effect(&self, x: &[f64], u: &[f64], out: &mut [f64]) {
        match self {
            Vehicle::Omni(omni) => {
                let effect = omni.matrix(x[2]) * nalgebra::Vector3::from_column_slice(u);
                out[..3].copy_from_slice(effect.as_slice());
            }
            Vehicle::Quadcopter(quadcopter) => quadcopter.effect(x, u, out),
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
            Vehicle::Quadcopter(_) => None,
        }
    }

    /// The quadcopter, if this is one.
    pub fn quadcopter(&self) -> Option<&Quadcopter> {
        match self {
            Vehicle::Quadcopter(quadcopter) => Some(quadcopter),
            Vehicle::Omni(_) => None,
        }
    }

    /// Value of the parameter called `name` in scenario files, for use in formulas.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        match self {
            Vehicle::Omni(omni) => omni.parameter(name),
            Vehicle::Quadcopter(quadcopter) => quadcopter.parameter(name),
        }
    }
}
