//! Three-wheel omni-directional robots, driven by wheel speeds or by wheel forces, and the double integrator behind them.

use nalgebra::{Matrix3, Vector3};

const PI_3: f64 = std::f64::consts::FRAC_PI_3;

/// What the input of a planar robot is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// Wheel speeds in m/s: `dx/dt = T_f(heading, R) u`. (5.1)
    Speed,
    /// Wheel forces in N: `dv/dt = M T_s(heading, R) u`, `M = diag(1/m, 1/m, 1/I)`. (2.1)
    Force,
    /// Generalised accelerations: `dv/dt = u`.
    Acceleration,
}

/// A planar robot with coordinates (x, y, heading) in m, m, rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Omni {
    /// What the input is.
    pub drive: Drive,
    /// Radius from the centre to the wheels, m; also that of the disc for collisions.
    pub radius: f64,
    /// Mass, kg. Used with forces only.
    pub mass: f64,
    /// Moment of inertia, kg m². Used with forces only.
    pub inertia: f64,
    /// Friction coefficient of the wheels, N s/m. For formulas only.
    pub friction: f64,
}

impl Omni {
    /// 1 with wheel speeds, else 2.
    pub fn order(&self) -> usize {
        if self.drive == Drive::Speed { 1 } else { 2 }
    }

    pub(super) fn input_unit(&self) -> &'static str {
        match self.drive {
            Drive::Speed => "m/s",
            Drive::Force => "N",
            Drive::Acceleration => "m/s^2, m/s^2, rad/s^2",
        }
    }

    /// The input matrix g at a heading in rad: `T_f`, `M T_s` or the identity.
    pub fn matrix(&self, heading: f64) -> Matrix3<f64> {
        let [first, second] = directions(heading);
        let turn = match self.drive {
            Drive::Acceleration => return Matrix3::identity(),
            Drive::Speed => return rows(first, second, Vector3::repeat(1.0 / self.radius)),
            Drive::Force => Vector3::repeat(self.radius / self.inertia),
        };
        rows(first / self.mass, second / self.mass, turn)
    }

    /// The inverse of [`Omni::matrix`], in closed form: it exists at every heading.
    pub fn inverse(&self, heading: f64) -> Matrix3<f64> {
        let [first, second] = directions(heading);
        let (push, turn) = match self.drive {
            Drive::Acceleration => return Matrix3::identity(),
            Drive::Speed => (2.0 / 3.0, self.radius / 3.0),
            Drive::Force => (2.0 * self.mass / 3.0, self.inertia / (3.0 * self.radius)),
        };
        Matrix3::from_columns(&[first * push, second * push, Vector3::repeat(turn)])
    }

    pub(super) fn parameter(&self, name: &str) -> Option<f64> {
        match name {
            "m" => Some(self.mass),
            "R" => Some(self.radius),
            "I" => Some(self.inertia),
            "fric" => Some(self.friction),
            _ => None,
        }
    }
}

/// The first two rows of `T_s` and `T_f`: what each wheel contributes along x and y.
fn directions(heading: f64) -> [Vector3<f64>; 2] {
    let (minus, plus) = (PI_3 - heading, PI_3 + heading);
    [
        Vector3::new(-libm::sin(heading), -libm::sin(minus), libm::sin(plus)),
        Vector3::new(libm::cos(heading), -libm::cos(minus), -libm::cos(plus)),
    ]
}

fn rows(first: Vector3<f64>, second: Vector3<f64>, third: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_rows(&[first.transpose(), second.transpose(), third.transpose()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_closed_form_is_the_inverse(heading in -7.0..7.0f64, radius in 0.05..0.5f64, mass in 1.0..9.0f64, inertia in 0.05..0.5f64) {
            for drive in [Drive::Speed, Drive::Force, Drive::Acceleration] {
                let omni = Omni { drive, radius, mass, inertia, friction: 0.0 };
                let residual = omni.matrix(heading) * omni.inverse(heading) - Matrix3::identity();
                prop_assert!(residual.norm() < 1e-12, "{drive:?}: {residual}");
            }
        }
    }
}
