//! Quadcopters: six coordinates, thrust and three torques. (7.1) to (7.3)

/// Acceleration of gravity, m/s².
pub(super) const GRAVITY: f64 = 9.81;

/// A quadcopter with coordinates (px, py, pz, roll φ, pitch θ, yaw ψ) in m and rad and inputs (T, τ1, τ2, τ3) in N.
#[derive(Clone, Debug, PartialEq)]
pub struct Quadcopter {
    /// Mass, kg.
    pub mass: f64,
    /// Arm length, m.
    pub arm: f64,
    /// Moments of inertia about the body axes, kg m² (printed as N s²/rad).
    pub inertia: [f64; 3],
    /// Drag coefficient, N s/m.
    pub drag: f64,
    /// Thrust-to-torque factor υ of a rotor.
    pub torque_factor: f64,
}

impl Quadcopter {
    /// The diagonal of g_a: angular acceleration per unit of torque input. (7.3)
    pub fn torque_effect(&self) -> [f64; 3] {
        let [x, y, z] = self.inertia;
        [self.arm / x, self.arm / y, self.torque_factor / z]
    }

    /// The forces of the four motors that make up thrust and torques, N; the inverse of (7.2).
    pub fn motor_forces(&self, input: &[f64; 4]) -> [f64; 4] {
        let [thrust, roll, pitch, yaw] = *input;
        [
            thrust / 4.0 - pitch / 2.0 - yaw / 4.0,
            thrust / 4.0 - roll / 2.0 + yaw / 4.0,
            thrust / 4.0 + pitch / 2.0 - yaw / 4.0,
            thrust / 4.0 + roll / 2.0 + yaw / 4.0,
        ]
    }

    /// Acceleration of the six coordinates that the inputs cause, gravity aside. (7.3)
    pub(super) fn effect(&self, x: &[f64], u: &[f64], out: &mut [f64]) {
        let (sin_roll, cos_roll) = libm::sincos(x[3]);
        let (sin_pitch, cos_pitch) = libm::sincos(x[4]);
        let (sin_yaw, cos_yaw) = libm::sincos(x[5]);
        out[0] = (cos_roll * sin_pitch * cos_yaw + sin_roll * sin_yaw) / self.mass * u[0];
        out[1] = (cos_roll * sin_pitch * sin_yaw - sin_roll * cos_yaw) / self.mass * u[0];
        out[2] = cos_roll * cos_pitch / self.mass * u[0];
        for (j, effect) in self.torque_effect().into_iter().enumerate() {
            out[3 + j] = effect * u[1 + j];
        }
    }

    pub(super) fn parameter(&self, name: &str) -> Option<f64> {
        match name {
            "m" => Some(self.mass),
            "R" => Some(self.arm),
            "Jx" => Some(self.inertia[0]),
            "Jy" => Some(self.inertia[1]),
            "Jz" => Some(self.inertia[2]),
            "K" => Some(self.drag),
            "upsilon" => Some(self.torque_factor),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motor_forces_add_up_to_thrust_and_torques() {
        let quadcopter = Quadcopter { mass: 2.0, arm: 0.3, inertia: [1.2, 1.3, 2.5], drag: 0.0, torque_factor: 0.05 };
        let [u1, u2, u3, u4] = quadcopter.motor_forces(&[20.0, 1.0, -2.0, 0.5]);
        assert!((u1 + u2 + u3 + u4 - 20.0).abs() < 1e-12);
        assert!((u4 - u2 - 1.0).abs() < 1e-12 && (u3 - u1 + 2.0).abs() < 1e-12);
        assert!((u2 + u4 - u1 - u3 - 0.5).abs() < 1e-12);
    }

    #[test]
    fn level_flight_lifts_straight_up() {
        let quadcopter = Quadcopter { mass: 2.0, arm: 0.3, inertia: [1.2, 1.3, 2.5], drag: 0.0, torque_factor: 0.05 };
        let mut out = [0.0; 6];
        quadcopter.effect(&[0.0; 6], &[20.0, 0.0, 0.0, 0.0], &mut out);
        assert_eq!(out, [0.0, 0.0, 10.0, 0.0, 0.0, 0.0]);
    }
}
