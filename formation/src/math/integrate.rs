//! One fixed step of an ordinary differential equation.

/// The classical Runge-Kutta method of order four, for states of a fixed length.
///
/// Four evaluations a step, no allocation after construction, the same bits every time.
#[derive(Clone, Debug)]
pub struct Rk4 {
    slopes: [Vec<f64>; 4],
    stage: Vec<f64>,
}

impl Rk4 {
    /// For states of `length` numbers.
    pub fn new(length: usize) -> Self {
        Self { slopes: std::array::from_fn(|_| vec![0.0; length]), stage: vec![0.0; length] }
    }

    /// Advances `state` from `time` by `dt`; `slope(time, state, out)` writes the time derivative into `out`.
    pub fn step(&mut self, time: f64, dt: f64, state: &mut [f64], mut slope: impl FnMut(f64, &[f64], &mut [f64])) {
        let [k1, k2, k3, k4] = &mut self.slopes;
        let stage = &mut self.stage;
        slope(time, state, k1);
        advance(stage, state, k1, 0.5 * dt);
        slope(time + 0.5 * dt, stage, k2);
        advance(stage, state, k2, 0.5 * dt);
        slope(time + 0.5 * dt, stage, k3);
        advance(stage, state, k3, dt);
        slope(time + dt, stage, k4);
        for (j, value) in state.iter_mut().enumerate() {
            *value += dt / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
        }
    }
}

fn advance(stage: &mut [f64], state: &[f64], slope: &[f64], dt: f64) {
    for ((stage, value), slope) in stage.iter_mut().zip(state).zip(slope) {
        *stage = value + dt * slope;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_at_two_seconds(steps: usize) -> f64 {
        let mut rk4 = Rk4::new(2);
        let mut state = [1.0, 0.0];
        let dt = 2.0 / steps as f64;
        for k in 0..steps {
            rk4.step(k as f64 * dt, dt, &mut state, |_, x, out| {
                out[0] = x[1];
                out[1] = -x[0];
            });
        }
        (state[0] - libm::cos(2.0)).abs()
    }

    #[test]
    fn order_four() {
        let ratio = error_at_two_seconds(20) / error_at_two_seconds(40);
        assert!((14.0..18.0).contains(&ratio), "halving the step divides the error by 16, here by {ratio}");
    }
}
