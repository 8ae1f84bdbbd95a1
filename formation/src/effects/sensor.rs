//! What a sensor makes of the true value: biases, noise, outliers, saturation, quantisation, sampling, lost samples and delay.
//!
//! Noise and biases are those of IEEE Std 952, with the discretisation of Kalibr (its wiki, "IMU Noise Model"). Sampling, loss and
//! delay are those of TrueTime (Cervin et al., IEEE Control Systems Magazine 23(3), 2003). Outliers are the contamination of Huber
//! (Ann. Math. Statist. 35, 1964).

use schemars::JsonSchema;
use serde::Deserialize;

use super::delay_line::{DelayLine, check_delay, delay_steps, tolerance};
use super::limits::{check_finite, check_limits, check_not_negative, check_positive, quantised, saturated};
use crate::math::RandomStream;

/// The errors of a sensor. By default there are none.
///
/// They act in this order: true value, scale, biases, noise, outlier, saturation, quantiser, sampling and loss, delay. All
/// numbers of a signal have the same errors but their own random numbers; sampling, loss and delay concern all at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SensorErrors {
    /// Scale-factor error: 0.01 makes 101 of 100.
    pub scale: f64,
    /// Constant bias (unit of the signal).
    pub bias: f64,
    /// Standard deviation of a random constant bias (unit of the signal), drawn once a run (turn-on bias).
    pub bias_deviation: f64,
    /// K, the bias random walk (unit of the signal / s / sqrt(Hz)): over an interval h it changes by K sqrt(h).
    pub bias_walk: f64,
    /// Standard deviation of a bias that changes and returns (unit of the signal): a Gauss-Markov process of order 1.
    pub bias_instability: f64,
    /// Correlation time of `bias_instability` (s).
    pub bias_time: f64,
    /// Standard deviation of the white noise of a sample (unit of the signal).
    pub noise: f64,
    /// N, density of the white noise (unit of the signal / sqrt(Hz)): at the interval h of the samples, its standard deviation is
    /// N / sqrt(h). It adds to `noise` in variance.
    pub noise_density: f64,
    /// Probability that a sample is an outlier.
    pub outliers: f64,
    /// Standard deviation of what an outlier adds (unit of the signal).
    pub outlier_size: f64,
    /// Smallest value (unit of the signal). Without it there is no lower limit.
    pub min: Option<f64>,
    /// Largest value (unit of the signal). Without it there is no upper limit.
    pub max: Option<f64>,
    /// Resolution (unit of the signal): values are rounded to multiples of it. 0 means none.
    pub quantum: f64,
    /// Samples per second; in between the last one is held. Without it, or above the rate of the steps, every step has one.
    pub rate_hz: Option<f64>,
    /// Time of the first sample at `rate_hz` (s). Until then the sensor holds a sample of the first step.
    pub phase: f64,
    /// Probability that a sample is lost; then the last one is held. The first one is never lost.
    pub dropout: f64,
    /// Delay (s): the newest sample that is at least that old is put out. Until there is one, it is the first sample.
    pub delay: f64,
}

impl SensorErrors {
    /// What is wrong with these numbers at steps of `dt` (s): field and message.
    pub fn findings(&self, dt: f64) -> Vec<(&'static str, String)> {
        let mut findings = Vec::new();
        check_finite(&mut findings, [("scale", self.scale), ("bias", self.bias)]);
        check_not_negative(
            &mut findings,
            [
                ("bias_deviation", self.bias_deviation),
                ("bias_walk", self.bias_walk),
                ("bias_instability", self.bias_instability),
                ("bias_time", self.bias_time),
                ("noise", self.noise),
                ("noise_density", self.noise_density),
                ("outlier_size", self.outlier_size),
                ("quantum", self.quantum),
                ("phase", self.phase),
            ],
        );
        for (field, value) in [("outliers", self.outliers), ("dropout", self.dropout)] {
            if !(0.0..=1.0).contains(&value) {
                findings.push((field, format!("expected a number from 0 to 1, found {value}")));
            }
        }
        if self.bias_instability > 0.0 && self.bias_time == 0.0 {
            findings.push(("bias_time", "expected a number > 0 beside bias_instability, found 0".into()));
        }
        if self.outliers > 0.0 && self.outlier_size == 0.0 {
            findings.push(("outlier_size", "expected a number > 0 beside outliers, found 0".into()));
        }
        check_limits(&mut findings, self.min, self.max);
        check_positive(&mut findings, "rate_hz", self.rate_hz);
        if self.rate_hz.is_none() && self.phase > 0.0 {
            findings.push(("phase", format!("expected rate_hz beside it, found phase = {} alone", self.phase)));
        }
        check_delay(&mut findings, self.delay, dt);
        findings
    }
}

/// Places of the random numbers of a step: `LOSS` is for the signal, the others are per number of the signal, `PLACES` apart.
const LOSS: u32 = 0;
const PLACES: u32 = 8;
const TURN_ON: u32 = 1;
const WALK: u32 = 2;
const INSTABILITY: u32 = 3;
const NOISE: u32 = 4;
const OUTLIER: u32 = 5;
const OUTLIER_SIZE: u32 = 6;

/// A sensor of a signal of a fixed number of numbers.
///
/// Every random number is a pure function of seed, name, step and place. What is carried from step to step are the biases, the
/// samples that are on their way, and the time of the last sample.
#[derive(Clone, Debug)]
pub struct Sensor {
    law: Law,
    dt: f64,
    /// Samples per step, at most 1.
    rate: f64,
    /// Time of the first sample at this rate, in steps.
    phase: f64,
    /// Number of the last instant of a sample; -1 is the first step of a late first instant.
    instant: f64,
    /// Step of the last instant of a sample.
    sampled: Option<u64>,
    biases: Vec<Bias>,
    line: DelayLine,
    /// Step of the sample that was put out last.
    shown: Option<u64>,
    held: bool,
    age: u64,
}

/// The biases of one number.
#[derive(Clone, Copy, Debug)]
struct Bias {
    constant: f64,
    walk: f64,
    instability: f64,
}

impl Sensor {
    /// The sensor of a signal of `width` numbers at steps of `dt` (s).
    pub fn new(errors: &SensorErrors, width: usize, dt: f64, stream: RandomStream) -> Self {
        let per_step = errors.rate_hz.unwrap_or(f64::INFINITY) * dt;
        let rate = if per_step > 0.0 && per_step < 1.0 { per_step } else { 1.0 };
        let density = errors.noise_density;
        let noise = (errors.noise * errors.noise + density * density * rate / dt).sqrt();
        let law = Law { errors: *errors, noise: if density == 0.0 { errors.noise } else { noise }, stream };
        let biases = (0..width).map(|j| Bias {
            constant: errors.bias + law.normal(errors.bias_deviation, 0, j, TURN_ON),
            walk: 0.0,
            instability: 0.0,
        });
        let delay = delay_steps(errors.delay, dt);
        Self {
            law,
            dt,
            rate,
            phase: errors.phase / dt,
            instant: f64::NEG_INFINITY,
            sampled: None,
            biases: biases.collect(),
            line: DelayLine::new(delay, rate, width),
            shown: None,
            held: false,
            age: 0,
        }
    }

    /// The measurement `out` of `truth` at this step. Steps come in order.
    ///
    /// A sample is due at the first step at or after `phase + n / rate` for a whole number n, and at the first step of all.
    pub fn update(&mut self, step: u64, truth: &[f64], out: &mut [f64]) {
        let (law, time) = (self.law, step as f64);
        let instant = ((time + tolerance(time) - self.phase) * self.rate).floor().max(-1.0);
        if instant > self.instant {
            self.instant = instant;
            self.wander(step);
            // A lost sample is one that is not kept: all else is as if it had arrived.
            let lost = law.errors.dropout > 0.0 && law.stream.uniform(step, LOSS) < law.errors.dropout;
            if !lost || self.shown.is_none() {
                let sample = self.line.push(step);
                for (j, ((sample, truth), bias)) in sample.iter_mut().zip(truth).zip(&self.biases).enumerate() {
                    *sample = law.measured(*truth, bias, step, j);
                }
            }
        }
        if let Some((taken, _, sample)) = self.line.front(step) {
            for (out, value) in out.iter_mut().zip(sample) {
                *out = *value;
            }
            self.held = self.shown == Some(taken);
            self.age = step.saturating_sub(taken);
            self.shown = Some(taken);
        }
    }

    /// Whether the value of the last update is a sample that an earlier update has put out already.
    pub fn held(&self) -> bool {
        self.held
    }

    /// How old the value of the last update is, in steps.
    pub fn age_steps(&self) -> u64 {
        self.age
    }

    /// How old the value of the last update is (s).
    pub fn age(&self) -> f64 {
        self.age as f64 * self.dt
    }

    /// Moves the biases on to this step. Both are exact at any interval.
    fn wander(&mut self, step: u64) {
        let (law, SensorErrors { bias_walk, bias_instability, bias_time, .. }) = (self.law, self.law.errors);
        let interval = self.sampled.map(|last| step.saturating_sub(last) as f64 * self.dt);
        self.sampled = Some(step);
        if bias_walk != 0.0 {
            let deviation = bias_walk * interval.unwrap_or(0.0).sqrt();
            for (j, bias) in self.biases.iter_mut().enumerate() {
                bias.walk += law.normal(deviation, step, j, WALK);
            }
        }
        if bias_instability != 0.0 {
            // exp(-h / tau), and sigma sqrt(1 - exp(-2 h / tau)). The first value is drawn from the stationary distribution.
            let decay = match interval {
                Some(interval) if bias_time > 0.0 => -interval / bias_time,
                _ => f64::NEG_INFINITY,
            };
            let (factor, deviation) = (libm::exp(decay), bias_instability * (-libm::expm1(2.0 * decay)).sqrt());
            for (j, bias) in self.biases.iter_mut().enumerate() {
                bias.instability = factor * bias.instability + law.normal(deviation, step, j, INSTABILITY);
            }
        }
    }
}

/// What does not change from step to step.
#[derive(Clone, Copy, Debug)]
struct Law {
    errors: SensorErrors,
    /// Standard deviation of all white noise of a sample (unit of the signal).
    noise: f64,
    stream: RandomStream,
}

impl Law {
    /// A normal number with this standard deviation for number `j` of the signal.
    fn normal(&self, deviation: f64, step: u64, j: usize, place: u32) -> f64 {
        if deviation == 0.0 { 0.0 } else { deviation * self.stream.normal(step, place_of(j, place)) }
    }

    /// The sample of number `j` of the signal. What is not finite passes.
    fn measured(&self, truth: f64, bias: &Bias, step: u64, j: usize) -> f64 {
        let errors = &self.errors;
        if !truth.is_finite() {
            return truth;
        }
        let mut error = errors.scale * truth + bias.constant + bias.walk + bias.instability;
        error += self.normal(self.noise, step, j, NOISE);
        if errors.outliers > 0.0 && self.stream.uniform(step, place_of(j, OUTLIER)) < errors.outliers {
            error += self.normal(errors.outlier_size, step, j, OUTLIER_SIZE);
        }
        // So that not even the sign of a zero changes without errors.
        let value = if error == 0.0 { truth } else { truth + error };
        quantised(saturated(value, errors.min, errors.max), errors.quantum)
    }
}

fn place_of(j: usize, place: u32) -> u32 {
    (j as u32).wrapping_mul(PLACES).wrapping_add(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 0.01;

    fn sensor(errors: SensorErrors, width: usize, name: &str) -> Sensor {
        Sensor::new(&errors, width, DT, RandomStream::new(11, name))
    }

    /// The measurements of a truth in steps `0..count`, with whether they are held and how old they are.
    fn run(errors: SensorErrors, count: u64, truth: impl Fn(u64) -> f64) -> Vec<(f64, bool, u64)> {
        let (mut sensor, mut out) = (sensor(errors, 1, "test"), [0.0]);
        let mut row = |step| {
            sensor.update(step, &[truth(step)], &mut out);
            assert_eq!(sensor.age(), sensor.age_steps() as f64 * DT);
            (out[0], sensor.held(), sensor.age_steps())
        };
        (0..count).map(&mut row).collect()
    }

    fn values(errors: SensorErrors, count: u64, truth: impl Fn(u64) -> f64) -> Vec<f64> {
        run(errors, count, truth).into_iter().map(|(value, ..)| value).collect()
    }

    /// Mean and standard deviation.
    fn moments(values: &[f64]) -> (f64, f64) {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / values.len() as f64;
        (mean, variance.sqrt())
    }

    /// The Allan deviation over clusters of `length` samples (IEEE Std 952, annex C), and their number.
    fn allan(values: &[f64], length: usize) -> (f64, f64) {
        let means: Vec<f64> =
            values.chunks_exact(length).map(|part| part.iter().sum::<f64>() / length as f64).collect();
        let squares: f64 = means.windows(2).map(|pair| (pair[1] - pair[0]) * (pair[1] - pair[0])).sum();
        let count = (means.len() - 1) as f64;
        ((squares / (2.0 * count)).sqrt(), count)
    }

    /// Within four standard errors. A variance from `n` differences with correlation r between neighbours has the relative
    /// standard error sqrt(2 (1 + 2 r^2) / n), a deviation half of it. r is -1/2 for white noise, where the error is largest, and
    /// 1/4 for a walk.
    fn assert_allan(values: &[f64], length: usize, expected: f64, correlation: f64) {
        let (found, count) = allan(values, length);
        let error = expected * ((1.0 + 2.0 * correlation * correlation) / (2.0 * count)).sqrt();
        assert!((found - expected).abs() < 4.0 * error, "{found} instead of {expected} +- {error}");
    }

    #[test]
    fn allan_deviation_of_white_noise() {
        let noise = values(SensorErrors { noise_density: 0.01, ..Default::default() }, 1 << 18, |_| 5.0);
        assert_allan(&noise, 100, 0.01, -0.5);
        assert_allan(&noise, 1, 0.1, -0.5);
        assert_allan(&noise, 1000, 0.01 / 10.0_f64.sqrt(), -0.5);
        // A density means the same at any rate; here three of four values are held.
        let slow = SensorErrors { noise_density: 0.01, rate_hz: Some(25.0), ..Default::default() };
        assert_allan(&values(slow, 1 << 18, |_| 5.0), 100, 0.01, -0.5);
        // Both kinds of noise add in variance.
        let both = SensorErrors { noise: 0.2, noise_density: 0.01, ..Default::default() };
        assert_allan(&values(both, 1 << 16, |_| 5.0), 1, 0.05_f64.sqrt(), -0.5);
    }

    #[test]
    fn allan_deviation_of_the_walk() {
        let walk = SensorErrors { bias_walk: 0.001, ..Default::default() };
        let fast = values(walk, 1 << 18, |_| 5.0);
        assert_eq!(fast[0], 5.0);
        assert_allan(&fast, 300, 0.001, 0.25);
        assert_allan(&fast, 100, 0.001 / 3.0_f64.sqrt(), 0.25);
    }

    #[test]
    fn allan_deviation_of_the_instability() {
        let (sigma, tau) = (0.3, 1.0);
        let errors = SensorErrors { bias_instability: sigma, bias_time: tau, ..Default::default() };
        let drift = values(errors, 1 << 18, |_| 5.0);
        for length in [50, 189, 1000] {
            let x = length as f64 * DT / tau;
            let bracket = 1.0 - (3.0 - 4.0 * libm::exp(-x) + libm::exp(-2.0 * x)) / (2.0 * x);
            assert_allan(&drift, length, sigma * (2.0 * bracket / x).sqrt(), 0.5);
        }
        // The samples of a time of 2 tau count as one.
        let (mean, deviation) = moments(&drift);
        let count = (1 << 18) as f64 * DT / (2.0 * tau);
        assert!((mean - 5.0).abs() < 4.0 * sigma / count.sqrt(), "{mean}");
        assert!((deviation / sigma - 1.0).abs() < 4.0 / count.sqrt(), "{deviation}");
    }

    /// At 30 Hz, samples are 3 or 4 steps apart; both processes have their law over time nevertheless.
    #[test]
    fn biases_are_exact_at_uneven_intervals() {
        const WIDTH: usize = 4096;
        let spread = |errors: SensorErrors, steps: &[u64]| {
            let (mut sensor, mut out) = (sensor(errors, WIDTH, "many"), vec![0.0; WIDTH]);
            let mut rows = Vec::new();
            for step in 0..=steps[steps.len() - 1] {
                sensor.update(step, &[0.0; WIDTH], &mut out);
                if steps.contains(&step) {
                    rows.push(out.clone());
                }
            }
            rows
        };
        let error = 4.0 / (2.0 * WIDTH as f64).sqrt();
        let rate_hz = Some(30.0);
        let walk = spread(SensorErrors { bias_walk: 2.0, rate_hz, ..Default::default() }, &[40]);
        assert!((moments(&walk[0]).1 / (2.0 * 0.4_f64.sqrt()) - 1.0).abs() < error);
        let errors = SensorErrors { bias_instability: 2.0, bias_time: 0.4, rate_hz, ..Default::default() };
        let drift = spread(errors, &[0, 40]);
        for row in &drift {
            assert!((moments(row).1 / 2.0 - 1.0).abs() < error);
        }
        let products: Vec<f64> = drift[0].iter().zip(&drift[1]).map(|(a, b)| a * b / 4.0).collect();
        assert!((moments(&products).0 - libm::exp(-1.0)).abs() < 4.0 * (1.2 / WIDTH as f64).sqrt());
        let constant = spread(SensorErrors { bias: 7.0, bias_deviation: 2.0, ..Default::default() }, &[0, 9]);
        assert!((moments(&constant[0]).1 / 2.0 - 1.0).abs() < error);
        assert!((moments(&constant[0]).0 - 7.0).abs() < 4.0 * 2.0 / 64.0);
        assert_eq!(constant[0], constant[1]);
    }

    #[test]
    fn without_errors_nothing_happens() {
        let (mut sensor, mut out) = (sensor(SensorErrors::default(), 5, "ideal"), [1.0; 5]);
        let truth = [0.1, -0.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE];
        for step in 0..3 {
            sensor.update(step, &truth, &mut out);
            assert_eq!(out.map(f64::to_bits), truth.map(f64::to_bits));
            assert!(!sensor.held() && sensor.age_steps() == 0);
        }
        assert_eq!(serde_json::from_str::<SensorErrors>("{}").unwrap(), SensorErrors::default());
        assert!(serde_json::from_str::<SensorErrors>(r#"{"nois": 1}"#).is_err());
    }

    #[test]
    fn the_order_of_scale_bias_saturation_and_quantum() {
        let errors = SensorErrors {
            scale: 0.1,
            bias: 0.3,
            min: Some(-2.0),
            max: Some(3.1),
            quantum: 0.25,
            ..Default::default()
        };
        let truth = [1.0, 2.0, 9.0, -9.0, -0.3];
        // 1.4, 2.5, 3.1, -2, -0.03
        assert_eq!(values(errors, 5, |step| truth[step as usize]), [1.5, 2.5, 3.0, -2.0, 0.0]);
        let linear = SensorErrors { scale: 0.5, bias: 1.0, ..Default::default() };
        assert_eq!(values(linear, 2, |step| 2.0 - 4.0 * step as f64), [4.0, -2.0]);
        let halves = SensorErrors { quantum: 0.5, ..Default::default() };
        assert_eq!(values(halves, 4, |step| [0.25, 0.75, -0.25, 0.24][step as usize]), [0.5, 1.0, -0.5, 0.0]);
        assert_eq!(quantised(1e308, 1e-300), 1e308);
    }

    #[test]
    fn samples_come_at_their_rate() {
        let times = |rate: f64, phase: f64, count: u64| -> Vec<u64> {
            let rows =
                run(SensorErrors { rate_hz: Some(rate), phase, ..Default::default() }, count, |step| step as f64);
            for (step, (value, held, age)) in (0..).zip(&rows) {
                assert_eq!((*value, *held), ((step - age) as f64, *age > 0));
            }
            (0..).zip(rows).filter(|(_, (_, held, _))| !held).map(|(step, _)| step).collect()
        };
        assert_eq!(times(10.0, 0.0, 31), [0, 10, 20, 30]);
        assert_eq!(times(30.0, 0.0, 21), [0, 4, 7, 10, 14, 17, 20]);
        assert_eq!(times(10.0, 0.03, 31), [0, 3, 13, 23]);
        assert_eq!(times(10.0, 0.25, 41), [0, 25, 35]);
        assert_eq!(times(10.0, 0.031, 31), [0, 4, 14, 24]);
        assert_eq!(times(100.0, 0.0, 4), [0, 1, 2, 3]);
        assert_eq!(times(5000.0, 0.0, 4), [0, 1, 2, 3]);
        assert_eq!(times(10.0, 0.05 + 1e-12, 16), [0, 5, 15]);
        assert_eq!(times(10.0, 0.05 + 1e-10, 17), [0, 6, 16]);
        // Neither the decimals of the rate nor the length of a run moves a sample.
        let rates = (2..300).map(|period| (1.0 / (period as f64 * DT), period));
        for (rate, period) in rates.chain([(30.0, 10), (70.0, 10), (0.1, 1000)]) {
            for start in [0, 10_000_000, 3_000_000_000_u64] {
                let mut sensor = sensor(SensorErrors { rate_hz: Some(rate), ..Default::default() }, 1, "late");
                let due = (start + 1).next_multiple_of(period);
                sensor.update(due - 1, &[0.0], &mut [0.0]);
                sensor.update(due, &[0.0], &mut [0.0]);
                assert!(!sensor.held(), "{rate} {due}");
                sensor.update(due + 1, &[0.0], &mut [0.0]);
                assert!(sensor.held(), "{rate} {due}");
            }
        }
    }

    #[test]
    fn a_delay_is_the_newest_sample_that_is_old_enough() {
        // 2.5 steps are 3 steps.
        for (delay, steps) in [(0.025, 3), (0.03, 3), (0.07, 7), (0.0, 0)] {
            for (step, row) in (0..).zip(run(SensorErrors { delay, ..Default::default() }, 50, |step| step as f64)) {
                let taken = u64::saturating_sub(step, steps);
                assert_eq!(row, (taken as f64, step > 0 && step <= steps, step - taken));
            }
            for (rate, period) in [(10.0, 10), (50.0, 2)] {
                let errors = SensorErrors { delay, rate_hz: Some(rate), ..Default::default() };
                for (step, (value, held, age)) in (0..).zip(run(errors, 90, |step| step as f64)) {
                    let taken = u64::saturating_sub(step, steps) / period * period;
                    let before = step.saturating_sub(steps + 1) / period * period;
                    assert_eq!((value, held, age), (taken as f64, step > 0 && taken == before, step - taken));
                }
            }
        }
    }

    #[test]
    fn lost_samples_and_outliers_have_their_frequency() {
        const COUNT: u64 = 20_000;
        let near = |found: usize, share: f64| {
            let deviation = (share * (1.0 - share) * COUNT as f64).sqrt();
            (found as f64 - share * COUNT as f64).abs() < 4.0 * deviation
        };
        let noise = SensorErrors { noise: 1.0, bias_walk: 1.0, ..Default::default() };
        let lossy = SensorErrors { dropout: 0.2, ..noise };
        let (all, some) = (values(noise, COUNT, |_| 0.0), run(lossy, COUNT, |_| 0.0));
        assert!(near(some.iter().filter(|(_, held, _)| *held).count(), 0.2));
        // What arrives is what would have arrived without loss.
        for (step, (value, held, age)) in some.iter().enumerate() {
            assert_eq!((*value, *held), (all[step - *age as usize], *age > 0));
        }
        let never = run(SensorErrors { dropout: 1.0, ..Default::default() }, 5, |step| step as f64 + 1.0);
        assert!(never.iter().all(|(value, ..)| *value == 1.0));

        let wild = values(SensorErrors { outliers: 0.1, outlier_size: 50.0, ..Default::default() }, COUNT, |_| 5.0);
        let added: Vec<f64> = wild.iter().map(|value| value - 5.0).filter(|error| *error != 0.0).collect();
        assert!(near(added.len(), 0.1));
        assert!((moments(&added).1 / 50.0 - 1.0).abs() < 4.0 / (2.0 * added.len() as f64).sqrt());
    }

    #[test]
    fn random_numbers_depend_on_name_step_and_place_only() {
        const COUNT: u64 = 1 << 14;
        let errors = SensorErrors {
            noise: 1.0,
            bias_deviation: 1.0,
            bias_walk: 0.1,
            bias_instability: 1.0,
            bias_time: 1.0,
            outliers: 0.1,
            outlier_size: 9.0,
            dropout: 0.1,
            ..Default::default()
        };
        let (mut one, mut three) = (sensor(errors, 1, "a"), sensor(errors, 3, "a"));
        for step in 0..500 {
            let (mut single, mut triple) = ([0.0], [0.0; 3]);
            one.update(step, &[1.0], &mut single);
            three.update(step, &[1.0; 3], &mut triple);
            assert_eq!((single[0], one.held()), (triple[0], three.held()));
            assert!(triple[0] != triple[1] && triple[1] != triple[2] && triple[2] != triple[0]);
        }
        let mut places = vec![LOSS];
        for j in 0..5 {
            places.extend([TURN_ON, WALK, INSTABILITY, NOISE, OUTLIER, OUTLIER_SIZE].map(|place| place_of(j, place)));
        }
        assert!(places.is_sorted_by(|one, next| one < next), "{places:?}");
        let noise = SensorErrors { noise: 1.0, ..Default::default() };
        let (mut pair, mut other) = (sensor(noise, 2, "a"), sensor(noise, 1, "b"));
        let (mut sums, mut rows) = ([0.0; 3], ([0.0; 2], [0.0]));
        for step in 0..COUNT {
            let before = rows.0[0];
            pair.update(step, &[0.0; 2], &mut rows.0);
            other.update(step, &[0.0], &mut rows.1);
            let first = rows.0[0];
            for (sum, factor) in sums.iter_mut().zip([rows.0[1], rows.1[0], before]) {
                *sum += first * factor / (COUNT as f64).sqrt();
            }
        }
        assert!(sums.iter().all(|sum| sum.abs() < 4.0), "{sums:?}");
    }

    #[test]
    fn no_number_stops_a_sensor() {
        for odd in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300] {
            let errors = SensorErrors {
                scale: odd,
                bias_instability: odd,
                bias_time: odd,
                noise_density: odd,
                min: Some(odd),
                max: Some(-odd),
                quantum: odd,
                rate_hz: Some(odd),
                phase: odd,
                delay: odd,
                dropout: odd,
                outliers: odd,
                ..Default::default()
            };
            let mut sensor = sensor(errors, 2, "odd");
            for step in [0, 1, 1, 5, 2, u64::MAX, 3] {
                sensor.update(step, &[f64::NAN, f64::NEG_INFINITY], &mut [0.0; 2]);
                sensor.update(step, &[1.0], &mut [0.0; 3]);
            }
        }
        // What is not finite leaves no trace.
        let errors = SensorErrors { noise: 1.0, max: Some(2.0), quantum: 0.1, ..Default::default() };
        let usual = values(errors, 20, |_| 1.0);
        let found = values(errors, 20, |step| if step == 3 { f64::INFINITY } else { 1.0 });
        assert_eq!((found[3], &found[4..]), (f64::INFINITY, &usual[4..]));
    }

    #[test]
    fn findings_name_the_field() {
        let fields = |errors: SensorErrors| -> Vec<&str> {
            let findings = errors.findings(DT);
            assert!(findings.iter().all(|(_, text)| text.starts_with("expected ") && text.contains(", found ")));
            findings.into_iter().map(|(field, _)| field).collect()
        };
        let ideal = SensorErrors::default();
        assert!(fields(ideal).is_empty());
        assert!(fields(SensorErrors { rate_hz: Some(1e6), phase: 1.0, delay: 1000.0, ..ideal }).is_empty());
        assert_eq!(fields(SensorErrors { noise: -1.0, bias: f64::NAN, ..ideal }), ["bias", "noise"]);
        assert_eq!(
            fields(SensorErrors { outliers: 1.5, dropout: f64::NAN, ..ideal }),
            ["outliers", "dropout", "outlier_size"]
        );
        assert_eq!(fields(SensorErrors { min: Some(1.0), max: Some(1.0), ..ideal }), ["min"]);
        assert_eq!(fields(SensorErrors { bias_instability: 1.0, ..ideal }), ["bias_time"]);
        assert_eq!(fields(SensorErrors { rate_hz: Some(0.0), ..ideal }), ["rate_hz"]);
        assert_eq!(fields(SensorErrors { phase: 0.1, ..ideal }), ["phase"]);
        assert_eq!(fields(SensorErrors { delay: 1000.1, ..ideal }), ["delay"]);
        assert_eq!(fields(SensorErrors { delay: f64::INFINITY, ..ideal }), ["delay"]);
    }
}
