//! One fixed step of an ordinary differential equation.

use schemars::JsonSchema;
use serde::Deserialize;

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

/// A method with fixed steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Explicit Euler, order 1.
    Euler,
    /// Semi-implicit (symplectic) Euler, order 1: velocities first, then the rest with the new velocities.
    SemiImplicit,
    /// Classical Runge-Kutta, order 4.
    #[default]
    Rk4,
    /// Dormand and Prince, order 5, without control of the step (J. Comput. Appl. Math. 6, 1980).
    Dopri5,
}

/// A [`Method`] with its memory, for states of a fixed length. The same bits every time, no allocation after construction.
///
/// ```
/// use formation::math::{Integrator, Method};
/// let mut integrator = Integrator::new(Method::Dopri5, 1, &[false]);
/// let mut state = [1.0];
/// for step in 0..10 {
///     integrator.step(0.1 * f64::from(step), 0.1, &mut state, |_, x, out| out[0] = -x[0]);
/// }
/// assert!((state[0] - (-1.0f64).exp()).abs() < 1e-8);
/// ```
#[derive(Clone, Debug)]
pub struct Integrator(Memory);

#[derive(Clone, Debug)]
enum Memory {
    Euler { slope: Vec<f64> },
    SemiImplicit { slope: Vec<f64>, leading: Vec<bool> },
    Rk4(Rk4),
    Dopri5(Dopri5),
}

impl Integrator {
    /// For states of `length` numbers; `leading` says which are velocities, for the semi-implicit method. All others ignore it.
    pub fn new(method: Method, length: usize, leading: &[bool]) -> Self {
        let slope = vec![0.0; length];
        Self(match method {
            Method::Euler => Memory::Euler { slope },
            Method::SemiImplicit => Memory::SemiImplicit { slope, leading: leading.to_vec() },
            Method::Rk4 => Memory::Rk4(Rk4::new(length)),
            Method::Dopri5 => Memory::Dopri5(Dopri5::new(length)),
        })
    }

    /// Advances `state` from `time` by `dt`; `slope(time, state, out)` writes the time derivative into `out`.
    pub fn step(&mut self, time: f64, dt: f64, state: &mut [f64], mut slope: impl FnMut(f64, &[f64], &mut [f64])) {
        match &mut self.0 {
            Memory::Rk4(rk4) => rk4.step(time, dt, state, slope),
            Memory::Dopri5(dopri5) => dopri5.step(time, dt, state, slope),
            Memory::Euler { slope: rates } => {
                slope(time, state, rates);
                for (value, rate) in state.iter_mut().zip(rates) {
                    *value += dt * *rate;
                }
            }
            Memory::SemiImplicit { slope: rates, leading } => {
                for turn in [true, false] {
                    slope(time, state, rates);
                    for ((value, rate), leads) in state.iter_mut().zip(&*rates).zip(&*leading) {
                        if *leads == turn {
                            *value += dt * *rate;
                        }
                    }
                }
            }
        }
    }
}

/// The method of order 5 of Dormand and Prince.
#[derive(Clone, Debug)]
struct Dopri5 {
    slopes: [Vec<f64>; 6],
    stage: Vec<f64>,
}

/// Where in the step each stage is.
const NODES: [f64; 6] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0];

/// How the slopes before make up each stage.
const STAGES: [&[f64]; 6] = [
    &[],
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
];

/// How the slopes make up the step.
const WEIGHTS: [f64; 6] = [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];

impl Dopri5 {
    fn new(length: usize) -> Self {
        Self { slopes: std::array::from_fn(|_| vec![0.0; length]), stage: vec![0.0; length] }
    }

    fn step(&mut self, time: f64, dt: f64, state: &mut [f64], mut slope: impl FnMut(f64, &[f64], &mut [f64])) {
        for (place, (node, factors)) in NODES.iter().zip(STAGES).enumerate() {
            let (before, now) = self.slopes.split_at_mut(place);
            combine(&mut self.stage, state, before, factors, dt);
            slope(time + node * dt, &self.stage, &mut now[0]);
        }
        combine(&mut self.stage, state, &self.slopes, &WEIGHTS, dt);
        state.copy_from_slice(&self.stage);
    }
}

/// `out = state + dt * (factors · slopes)`
fn combine(out: &mut [f64], state: &[f64], slopes: &[Vec<f64>], factors: &[f64], dt: f64) {
    for (j, (out, value)) in out.iter_mut().zip(state).enumerate() {
        let sum: f64 = slopes.iter().zip(factors).map(|(slope, factor)| factor * slope[j]).sum();
        *out = value + dt * sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(method: Method, steps: usize) -> f64 {
        let mut integrator = Integrator::new(method, 2, &[false, true]);
        let mut state = [1.0, 0.0];
        let dt = 2.0 / steps as f64;
        for k in 0..steps {
            integrator.step(k as f64 * dt, dt, &mut state, |_, x, out| {
                out[0] = x[1];
                out[1] = -x[0];
            });
        }
        (state[0] - libm::cos(2.0)).abs()
    }

    #[test]
    fn each_method_has_its_order() {
        for (method, order) in
            [(Method::Euler, 1.0), (Method::SemiImplicit, 1.0), (Method::Rk4, 4.0), (Method::Dopri5, 5.0)]
        {
            let ratio = error_of(method, 40) / error_of(method, 80);
            assert!(
                (libm::log2(ratio) - order).abs() < 0.25,
                "{method:?}: halving the step divides the error by {ratio}"
            );
        }
    }

    #[test]
    fn the_semi_implicit_method_keeps_the_energy_of_an_oscillator_bounded() {
        let mut integrator = Integrator::new(Method::SemiImplicit, 2, &[false, true]);
        let mut state = [1.0, 0.0];
        for _ in 0..100_000 {
            integrator.step(0.0, 0.05, &mut state, |_, x, out| {
                out[0] = x[1];
                out[1] = -x[0];
            });
        }
        let energy = state[0] * state[0] + state[1] * state[1];
        assert!((0.9..1.1).contains(&energy), "{energy}");
    }

    #[test]
    fn order_four() {
        let ratio = error_of(Method::Rk4, 20) / error_of(Method::Rk4, 40);
        assert!((14.0..18.0).contains(&ratio), "halving the step divides the error by 16, here by {ratio}");
    }
}
