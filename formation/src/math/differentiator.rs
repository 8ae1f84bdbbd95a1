//! Finite-time differentiators and disturbance observers of Levant's form. (2.11), (3.7), (4.27)

use nalgebra::SVector;

use super::{sig_vector, sign_vector};

/// Gains of a differentiator of `N` states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifferentiatorGains<const N: usize> {
    /// α1 ... αN.
    pub alpha: [f64; N],
    /// β, a bound of the highest derivative.
    pub beta: f64,
}

/// `N` states per channel, `D` channels: the first follows a measured signal, the others its derivatives.
///
/// With `r1 = α1 β^(1/N) sig(γ1 - y, (N-1)/N)`, `r2 = α2 β^(1/(N-1)) sig(r1, (N-2)/(N-1))`, ..., `rN = αN β sgn(r(N-1))` the states
/// obey `dγ1/dt = -r1 + γ2 + known` and `dγj/dt = -rj + γ(j+1)`. This is the usual recursion with `γ2 - ν1 = r1` and so on
/// substituted; forming the differences numerically would only add rounding noise to a sign function.
#[derive(Clone, Debug, PartialEq)]
pub struct Differentiator<const N: usize, const D: usize> {
    gains: DifferentiatorGains<N>,
    /// γ1 ... γN.
    pub states: [SVector<f64, D>; N],
}

impl<const N: usize, const D: usize> Differentiator<N, D> {
    /// A differentiator whose first state is `start` and whose others are 0.
    pub fn new(gains: DifferentiatorGains<N>, start: SVector<f64, D>) -> Self {
        let states = std::array::from_fn(|j| if j == 0 { start } else { SVector::zeros() });
        Self { gains, states }
    }

    /// Advances by one explicit Euler step of `dt` seconds. `measured` is the signal at the start of the interval, `known` the
    /// known part of its derivative there (zero for a plain differentiator). All right-hand sides use the old states.
    pub fn advance(&mut self, dt: f64, measured: &SVector<f64, D>, known: &SVector<f64, D>) {
        let mut error = self.states[0] - measured;
        for j in 0..N {
            // Orders count down: N, N-1, ..., 1.
            let order = (N - j) as f64;
            let correction = if j + 1 == N {
                self.gains.alpha[j] * self.gains.beta * sign_vector(&error)
            } else {
                let gain = self.gains.alpha[j] * libm::pow(self.gains.beta, 1.0 / order);
                gain * sig_vector(&error, (order - 1.0) / order)
            };
            let above = if j + 1 < N { self.states[j + 1] } else { SVector::zeros() };
            let slope = if j == 0 { -correction + above + known } else { -correction + above };
            self.states[j] += dt * slope;
            error = correction;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    #[test]
    fn derivatives_of_a_sine_come_out() {
        let gains = DifferentiatorGains { alpha: [6.0, 8.0, 8.0, 6.0], beta: 1.0 };
        let mut differentiator = Differentiator::<4, 1>::new(gains, Vector1::zeros());
        let dt = 1e-4;
        for k in 0..100_000 {
            differentiator.advance(dt, &Vector1::new(libm::sin(0.5 * k as f64 * dt)), &Vector1::zeros());
        }
        let [_, rate, acceleration, _] = differentiator.states;
        assert!((rate[0] - 0.5 * libm::cos(5.0)).abs() < 1e-3, "{rate}");
        assert!((acceleration[0] + 0.25 * libm::sin(5.0)).abs() < 1e-3, "{acceleration}");
    }

    /// The printed recursion, written out for three states.
    #[test]
    fn one_step_of_three_states() {
        let gains = DifferentiatorGains { alpha: [3.0, 6.0, 3.0], beta: 10.0 };
        let mut observer = Differentiator::<3, 1>::new(gains, Vector1::new(0.5));
        observer.states[1][0] = 0.2;
        observer.states[2][0] = -0.1;
        observer.advance(0.01, &Vector1::new(0.1), &Vector1::new(0.7));
        let r1 = 3.0 * libm::pow(10.0, 1.0 / 3.0) * libm::pow(0.4, 2.0 / 3.0);
        let r2 = 6.0 * 10f64.sqrt() * r1.sqrt();
        let expected = [0.5 + 0.01 * (-r1 + 0.2 + 0.7), 0.2 + 0.01 * (-r2 - 0.1), -0.1 - 0.01 * 30.0];
        for (state, expected) in observer.states.iter().zip(expected) {
            assert!((state[0] - expected).abs() < 1e-12, "{} {expected}", state[0]);
        }
    }
}
