//! What an actuator makes of its command: delay, dead zone, backlash, quantisation, lag, limits and faults.
//!
//! Dead zone and backlash are those of Slotine and Li (Applied Nonlinear Control, 1991, chapter 5). The lags are sampled exactly
//! for a command that is held (Astrom and Wittenmark, Computer-Controlled Systems, 1997). Loss of effectiveness and a stuck
//! actuator are the usual faults of Blanke et al. (Diagnosis and Fault-Tolerant Control, 2003).

use schemars::JsonSchema;
use serde::Deserialize;

use super::delay_line::{DelayLine, check_delay, delay_steps, first_step};
use super::limits::{check_finite, check_limits, check_not_negative, check_positive, quantised, saturated};

/// The limits and faults of an actuator. By default there are none.
///
/// They act in this order: command, delay, dead zone, backlash, quantiser, lag of order 1 or 2, rate limit, saturation,
/// effectiveness, stuck. All inputs of a vehicle have the same limits, each with its own memory.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ActuatorLimits {
    /// Delay of the command (s). Until the first command arrives, the actuator stays at `initial`.
    pub delay: f64,
    /// Half the width of the dead zone (unit of the input): smaller commands have no effect, larger ones lose as much.
    pub dead_zone: f64,
    /// Play of a gear (unit of the input): how far the command goes back before the actuator follows.
    pub backlash: f64,
    /// Resolution of the command (unit of the input): it is rounded to multiples of this. 0 means none.
    pub quantum: f64,
    /// Time constant of a lag of order 1 (s). 0 means none.
    pub lag: f64,
    /// Natural frequency of a lag of order 2 (rad/s). By default there is no such lag.
    pub natural_frequency: Option<f64>,
    /// Damping of the lag of order 2: below 1 it overshoots.
    pub damping: f64,
    /// Fastest change (unit of the input / s). Without it there is no limit.
    pub rate_limit: Option<f64>,
    /// Smallest value (unit of the input). Without it there is no lower limit.
    pub min: Option<f64>,
    /// Largest value (unit of the input). Without it there is no upper limit.
    pub max: Option<f64>,
    /// What is left of the effect from `effectiveness_from` on: 1 all, 0 nothing, -1 the reverse.
    pub effectiveness: f64,
    /// When the effectiveness changes (s).
    pub effectiveness_from: f64,
    /// When the actuator gets stuck (s). Without it that does not happen.
    pub stuck_from: Option<f64>,
    /// Where the actuator is stuck (unit of the input). Without it, it stays where it is.
    pub stuck_at: Option<f64>,
    /// Where the actuator is at the start (unit of the input); matters with a delay, backlash, a lag or a rate limit.
    pub initial: f64,
}

impl Default for ActuatorLimits {
    fn default() -> Self {
        Self {
            delay: 0.0,
            dead_zone: 0.0,
            backlash: 0.0,
            quantum: 0.0,
            lag: 0.0,
            natural_frequency: None,
            damping: 1.0,
            rate_limit: None,
            min: None,
            max: None,
            effectiveness: 1.0,
            effectiveness_from: 0.0,
            stuck_from: None,
            stuck_at: None,
            initial: 0.0,
        }
    }
}

impl ActuatorLimits {
    /// What is wrong with these numbers at steps of `dt` (s): field and message.
    pub fn findings(&self, dt: f64) -> Vec<(&'static str, String)> {
        let mut findings = Vec::new();
        check_delay(&mut findings, self.delay, dt);
        check_not_negative(
            &mut findings,
            [
                ("dead_zone", self.dead_zone),
                ("backlash", self.backlash),
                ("quantum", self.quantum),
                ("lag", self.lag),
                ("damping", self.damping),
                ("effectiveness_from", self.effectiveness_from),
                ("stuck_from", self.stuck_from.unwrap_or(0.0)),
            ],
        );
        check_positive(&mut findings, "natural_frequency", self.natural_frequency);
        if let Some(frequency) = self.natural_frequency
            && self.lag > 0.0
        {
            let message = format!("expected no natural_frequency beside lag = {}, found {frequency}", self.lag);
            findings.push(("natural_frequency", message));
        }
        check_positive(&mut findings, "rate_limit", self.rate_limit);
        check_limits(&mut findings, self.min, self.max);
        let stuck_at = self.stuck_at.unwrap_or(0.0);
        check_finite(
            &mut findings,
            [("effectiveness", self.effectiveness), ("stuck_at", stuck_at), ("initial", self.initial)],
        );
        if self.stuck_at.is_some() && self.stuck_from.is_none() {
            findings.push(("stuck_at", format!("expected stuck_from beside it, found stuck_at = {stuck_at} alone")));
        }
        findings
    }
}

/// The actuators of a fixed number of inputs.
///
/// The output of a step is where a command that is held over the step has brought the actuator at its end, so a short lag becomes
/// no lag. The rate limit starts from the saturated value, so a limit that is reached is left at once.
#[derive(Clone, Debug)]
pub struct ActuatorLaw {
    limits: ActuatorLimits,
    filter: Filter,
    /// Largest change in a step (unit of the input).
    most_change: Option<f64>,
    /// First steps with the other effectiveness, and stuck.
    weak_from: u64,
    stuck_from: Option<u64>,
    line: DelayLine,
    inputs: Vec<Input>,
}

/// The memory of one input.
#[derive(Clone, Copy, Debug)]
struct Input {
    /// Behind the backlash (unit of the input).
    gear: f64,
    /// Behind the lag (unit of the input), and its rate of change (unit of the input / s).
    lagged: f64,
    rate: f64,
    /// Behind the saturation (unit of the input).
    position: f64,
    /// The last output that was finite (unit of the input).
    output: f64,
}

impl ActuatorLaw {
    /// The actuators of `width` inputs at steps of `dt` (s).
    pub fn new(limits: &ActuatorLimits, width: usize, dt: f64) -> Self {
        let ActuatorLimits { initial, min, max, .. } = *limits;
        let position = saturated(initial, min, max);
        Self {
            limits: *limits,
            filter: Filter::new(limits, dt),
            most_change: limits.rate_limit.map(|rate| rate * dt),
            weak_from: first_step(limits.effectiveness_from, dt),
            stuck_from: limits.stuck_from.map(|time| first_step(time, dt)),
            line: DelayLine::new(delay_steps(limits.delay, dt), 1.0, width),
            inputs: vec![Input { gear: initial, lagged: initial, rate: 0.0, position, output: position }; width],
        }
    }

    /// What the actuators do, `out`, of `command` at this step. Steps come in order.
    ///
    /// A command that is not finite passes behind the delay, and the memory stays as it was.
    pub fn update(&mut self, step: u64, command: &[f64], out: &mut [f64]) {
        for (slot, command) in self.line.push(step).iter_mut().zip(command) {
            *slot = *command;
        }
        let stuck = self.stuck_from.is_some_and(|from| step >= from);
        let weak = step >= self.weak_from && self.limits.effectiveness != 1.0;
        let Some((_, arrived, commands)) = self.line.front(step) else { return };
        for ((input, command), out) in self.inputs.iter_mut().zip(commands).zip(out) {
            if stuck {
                *out = self.limits.stuck_at.unwrap_or(input.output);
                continue;
            }
            let usable = arrived && command.is_finite();
            if usable {
                input.advance(*command, &self.limits, &self.filter, self.most_change);
            }
            let value = if arrived && !usable { *command } else { input.position };
            *out = if weak && value.is_finite() { self.limits.effectiveness * value } else { value };
            if out.is_finite() {
                input.output = *out;
            }
        }
    }
}

impl Input {
    /// The position at the end of a step with this command.
    fn advance(&mut self, command: f64, limits: &ActuatorLimits, filter: &Filter, most_change: Option<f64>) {
        let mut value = command;
        if limits.dead_zone > 0.0 {
            value -= saturated(value, Some(-limits.dead_zone), Some(limits.dead_zone));
        }
        if limits.backlash > 0.0 {
            let play = 0.5 * limits.backlash;
            self.gear = saturated(self.gear, Some(value - play), Some(value + play));
            value = self.gear;
        }
        value = quantised(value, limits.quantum);
        value = match filter {
            Filter::None => value,
            Filter::First { rest, share } => {
                self.lagged = rest * self.lagged + share * value;
                self.lagged
            }
            Filter::Second { transition: [[a, b], [c, d]] } => {
                let error = self.lagged - value;
                self.lagged = value + (a * error + b * self.rate);
                self.rate = c * error + d * self.rate;
                self.lagged
            }
        };
        if let Some(most) = most_change {
            value = saturated(value, Some(self.position - most), Some(self.position + most));
        }
        self.position = saturated(value, limits.min, limits.max);
    }
}

/// A lag over one step with a held command.
#[derive(Clone, Copy, Debug)]
enum Filter {
    None,
    /// What is left of the old value, and what the command adds.
    First {
        rest: f64,
        share: f64,
    },
    /// How the distance from the command and its rate go on: the exponential of the matrix `[0 1; -w^2 -2 z w]` times dt.
    Second {
        transition: [[f64; 2]; 2],
    },
}

impl Filter {
    fn new(limits: &ActuatorLimits, dt: f64) -> Self {
        match limits.natural_frequency {
            Some(frequency) => Self::Second { transition: second_order(frequency, limits.damping, dt) },
            None if limits.lag > 0.0 => {
                let decay = -dt / limits.lag;
                Self::First { rest: libm::exp(decay), share: -libm::expm1(decay) }
            }
            None => Self::None,
        }
    }
}

/// The transition of `x'' + 2 z w x' + w^2 x = 0` over `dt`, in closed form for each kind of damping z.
fn second_order(w: f64, z: f64, dt: f64) -> [[f64; 2]; 2] {
    // Frequency, or half the distance of the two poles.
    let split = w * (1.0 - z).abs().sqrt() * (1.0 + z).sqrt();
    // exp(-z w dt) times cos and sin/split; cosh and sinh/split; 1 and dt.
    let (even, odd) = if z < 1.0 {
        let decay = libm::exp(-z * w * dt);
        (decay * libm::cos(split * dt), decay * libm::sin(split * dt) / split)
    } else if z > 1.0 {
        // By the two poles, whose product is w^2: no difference of large numbers, no product of a large and a small one.
        let fast = z * w + split;
        let (slowly, quickly) = (libm::exp(-w * (w / fast) * dt), libm::exp(-fast * dt));
        (0.5 * (slowly + quickly), slowly * -libm::expm1(-2.0 * split * dt) / (2.0 * split))
    } else {
        let decay = libm::exp(-w * dt);
        (decay, decay * dt)
    };
    [[even + z * w * odd, odd], [-w * (w * odd), even - z * w * odd]]
}

#[cfg(test)]
mod tests {
    use libm::{cos, exp, sin};

    use super::*;

    const DT: f64 = 0.01;

    /// The outputs of one actuator in steps `0..count`.
    fn run(limits: ActuatorLimits, count: u64, command: impl Fn(u64) -> f64) -> Vec<f64> {
        let mut law = ActuatorLaw::new(&limits, 1, DT);
        let mut out = [0.0];
        let mut row = |step| {
            law.update(step, &[command(step)], &mut out);
            out[0]
        };
        (0..count).map(&mut row).collect()
    }

    fn assert_near(found: &[f64], expected: impl Fn(f64) -> f64) {
        for (j, found) in found.iter().enumerate() {
            let time = (j + 1) as f64 * DT;
            assert!((found - expected(time)).abs() < 1e-12, "{found} instead of {} at {time}", expected(time));
        }
    }

    #[test]
    fn without_limits_nothing_happens() {
        let mut law = ActuatorLaw::new(&ActuatorLimits::default(), 5, DT);
        let (command, mut out) = ([0.1, -0.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE], [1.0; 5]);
        for step in 0..3 {
            law.update(step, &command, &mut out);
            assert_eq!(out.map(f64::to_bits), command.map(f64::to_bits));
        }
        assert_eq!(serde_json::from_str::<ActuatorLimits>("{}").unwrap(), ActuatorLimits::default());
        assert!(serde_json::from_str::<ActuatorLimits>(r#"{"lagg": 1}"#).is_err());
    }

    #[test]
    fn step_response_of_order_1() {
        for lag in [0.001, 0.05, 2.0, 1e6] {
            let limits = ActuatorLimits { lag, initial: 1.0, ..Default::default() };
            assert_near(&run(limits, 500, |_| 3.0), |time| 3.0 - 2.0 * exp(-time / lag));
        }
        // A short lag has no effect.
        let short = ActuatorLimits { lag: 1e-9, ..Default::default() };
        assert_eq!(run(short, 5, |step| step as f64), [0.0, 1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn step_response_of_order_2() {
        let w = 7.0;
        let response = |damping: f64| {
            let limits = ActuatorLimits { natural_frequency: Some(w), damping, initial: 1.0, ..Default::default() };
            run(limits, 500, |_| 3.0)
        };
        for z in [0.0, 0.3, 0.7, 0.999] {
            let f = w * (1.0_f64 - z * z).sqrt();
            assert_near(&response(z), |t| 3.0 - 2.0 * exp(-z * w * t) * (cos(f * t) + z * w / f * sin(f * t)));
        }
        let critical = |t: f64| 3.0 - 2.0 * exp(-w * t) * (1.0 + w * t);
        assert_near(&response(1.0), critical);
        for z in [1.001_f64, 2.0, 30.0] {
            let root = (z * z - 1.0).sqrt();
            let (slow, fast) = (w / (z + root), w * (z + root));
            let both = |t: f64| (fast * exp(-slow * t) - slow * exp(-fast * t)) / (fast - slow);
            assert_near(&response(z), |t| 3.0 - 2.0 * both(t));
        }
        // No jump between the kinds of damping, and no overflow far from them.
        for z in [1.0 - 1e-15, 1.0 + 1e-15] {
            assert_near(&response(z), critical);
        }
        for z in [1e9, 1e200] {
            assert!(response(z).iter().all(|value| (value - 1.0).abs() < 1e-6));
        }
        for (frequency, damping) in [(1e9, 1.0), (1e300, 1.0), (1e300, 0.7), (1e300, 2.0)] {
            let stiff = ActuatorLimits { natural_frequency: Some(frequency), damping, ..Default::default() };
            assert_eq!(run(stiff, 5, |step| step as f64), [0.0, 1.0, 2.0, 3.0, 4.0]);
        }
    }

    /// Two half steps are one whole step: the transition is that of a differential equation.
    #[test]
    fn lags_do_not_depend_on_the_step() {
        for damping in [0.2, 1.0, 3.0] {
            let [whole, half] = [DT, 0.5 * DT].map(|dt| second_order(9.0, damping, dt));
            for (j, row) in whole.iter().enumerate() {
                for (k, entry) in row.iter().enumerate() {
                    assert!((entry - (half[j][0] * half[0][k] + half[j][1] * half[1][k])).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn a_ramp_through_the_rate_limit() {
        let limits = ActuatorLimits { rate_limit: Some(2.0), ..Default::default() };
        // The command rises faster than the limit for 1 s, and then waits.
        let found = run(limits, 400, |step| 5.0 * (step as f64 * DT).min(1.0));
        assert_eq!(found[0], 0.0);
        assert_near(&found, |time| if time < 2.51 { 2.0 * (time - DT) } else { 5.0 });
        // A slower one is not changed.
        assert_eq!(
            run(limits, 50, |step| 0.019 * step as f64),
            run(Default::default(), 50, |step| 0.019 * step as f64)
        );
        assert_near(&run(limits, 50, |_| -9.0), |time| -2.0 * time);
    }

    #[test]
    fn a_limit_that_is_reached_is_left_at_once() {
        let limits = ActuatorLimits { rate_limit: Some(100.0), min: Some(-2.0), max: Some(3.0), ..Default::default() };
        let found = run(limits, 12, |step| if step < 6 { 9.0 } else { -9.0 });
        assert_eq!(found, [1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 2.0, 1.0, 0.0, -1.0, -2.0, -2.0]);
    }

    #[test]
    fn the_dead_zone_and_the_quantum() {
        let command = [-3.0, -1.0, -0.5, 0.0, 0.75, 1.0, 1.25, 3.5];
        let limits = ActuatorLimits { dead_zone: 1.0, ..Default::default() };
        let found = run(limits, 8, |step| command[step as usize]);
        assert_eq!(found, [-2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25, 2.5]);
        let limits = ActuatorLimits { quantum: 0.5, ..limits };
        assert_eq!(run(limits, 8, |step| command[step as usize]), [-2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 2.5]);
    }

    #[test]
    fn a_loop_of_the_backlash() {
        let limits = ActuatorLimits { backlash: 1.0, ..Default::default() };
        let command = [0.25, 0.5, 1.0, 2.0, 1.5, 1.0, 0.5, -2.0, -1.5, -1.0, 0.0, 2.0];
        let found = run(limits, 12, |step| command[step as usize]);
        assert_eq!(found, [0.0, 0.0, 0.5, 1.5, 1.5, 1.5, 1.0, -1.5, -1.5, -1.5, -0.5, 1.5]);
        let elsewhere = ActuatorLimits { initial: 7.0, ..limits };
        assert_eq!(run(elsewhere, 3, |step| [6.75, 7.25, 8.0][step as usize]), [7.0, 7.0, 7.5]);
        // The loop at an amplitude A is a parallelogram of width b and height 2 A - b.
        let wave = |step: u64| 3.0 * sin(step as f64 * 1e-3 * std::f64::consts::TAU);
        let rows = run(limits, 2001, wave);
        let area: f64 = (1001..2001)
            .map(|step| 0.5 * (wave(step) + wave(step - 1)) * (rows[step as usize] - rows[step as usize - 1]))
            .sum();
        assert!((area - 1.0 * (2.0 * 3.0 - 1.0)).abs() < 1e-3, "{area}");
    }

    #[test]
    fn the_delay_waits_at_the_start() {
        let limits = ActuatorLimits { delay: 0.025, initial: 7.0, max: Some(6.0), ..Default::default() };
        assert_eq!(run(limits, 6, |step| step as f64), [6.0, 6.0, 6.0, 0.0, 1.0, 2.0]);
        let lag = ActuatorLimits { delay: 0.03, lag: 0.2, ..Default::default() };
        let found = run(lag, 100, |_| 1.0);
        assert_eq!(found[..3], [0.0; 3]);
        assert_near(&found[3..], |time| 1.0 - exp(-time / 0.2));
    }

    #[test]
    fn faults_come_at_their_time() {
        let weak = ActuatorLimits { effectiveness: 0.5, effectiveness_from: 0.03, ..Default::default() };
        assert_eq!(run(weak, 6, |step| step as f64), [0.0, 1.0, 2.0, 1.5, 2.0, 2.5]);
        let stuck = ActuatorLimits { stuck_from: Some(0.04), ..weak };
        assert_eq!(run(stuck, 6, |step| step as f64), [0.0, 1.0, 2.0, 1.5, 1.5, 1.5]);
        let away = ActuatorLimits { stuck_at: Some(-8.0), ..stuck };
        assert_eq!(run(away, 6, |step| step as f64), [0.0, 1.0, 2.0, 1.5, -8.0, -8.0]);
        let never = ActuatorLimits { stuck_from: Some(0.0), initial: 4.0, ..weak };
        assert_eq!(run(never, 3, |_| 1.0), [4.0; 3]);
    }

    #[test]
    fn what_is_not_finite_passes_and_leaves_no_trace() {
        let limits = ActuatorLimits {
            delay: 0.02,
            backlash: 0.1,
            lag: 0.1,
            rate_limit: Some(5.0),
            max: Some(9.0),
            effectiveness: 0.0,
            effectiveness_from: 0.05,
            stuck_from: Some(0.08),
            ..Default::default()
        };
        let found = run(limits, 12, |step| [1.0, f64::NAN, 1.0, f64::INFINITY, 1.0, f64::NAN][step.min(5) as usize]);
        let usual = run(limits, 12, |_| 1.0);
        assert!(found[3].is_nan() && found[7].is_nan());
        assert_eq!((found[2], found[4], found[5]), (usual[2], usual[3], f64::INFINITY));
        assert_eq!(found[8..], [0.0; 4]);
        for odd in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300] {
            let limits = ActuatorLimits {
                delay: odd,
                dead_zone: odd,
                backlash: odd,
                quantum: odd,
                lag: odd,
                damping: odd,
                rate_limit: Some(odd),
                min: Some(odd),
                max: Some(-odd),
                effectiveness_from: odd,
                ..Default::default()
            };
            for natural_frequency in [None, Some(odd), Some(3.0)] {
                let mut law = ActuatorLaw::new(&ActuatorLimits { natural_frequency, ..limits }, 2, DT);
                for step in [0, 1, 1, 5, 2, u64::MAX, 3] {
                    law.update(step, &[1.0], &mut [0.0; 3]);
                }
            }
        }
    }

    #[test]
    fn inputs_have_their_own_memory() {
        let limits = ActuatorLimits { natural_frequency: Some(5.0), backlash: 0.1, ..Default::default() };
        let mut law = ActuatorLaw::new(&limits, 2, DT);
        let alone = run(limits, 50, |_| -2.0);
        for (step, alone) in (0..).zip(alone) {
            let mut out = [0.0; 2];
            law.update(step, &[1.0, -2.0], &mut out);
            assert_eq!(out[1], alone);
        }
    }

    #[test]
    fn findings_name_the_field() {
        let fields = |limits: ActuatorLimits| -> Vec<&str> {
            let findings = limits.findings(DT);
            assert!(findings.iter().all(|(_, text)| text.starts_with("expected ") && text.contains(", found ")));
            findings.into_iter().map(|(field, _)| field).collect()
        };
        let ideal = ActuatorLimits::default();
        assert!(fields(ideal).is_empty());
        assert_eq!(fields(ActuatorLimits { lag: -1.0, dead_zone: f64::NAN, ..ideal }), ["dead_zone", "lag"]);
        assert_eq!(fields(ActuatorLimits { lag: 1.0, natural_frequency: Some(1.0), ..ideal }), ["natural_frequency"]);
        assert_eq!(
            fields(ActuatorLimits { rate_limit: Some(0.0), min: Some(2.0), max: Some(1.0), ..ideal }),
            ["rate_limit", "min"]
        );
        assert_eq!(fields(ActuatorLimits { stuck_at: Some(0.0), ..ideal }), ["stuck_at"]);
        assert_eq!(fields(ActuatorLimits { stuck_from: Some(-1.0), delay: 1001.0, ..ideal }), ["delay", "stuck_from"]);
        assert_eq!(fields(ActuatorLimits { effectiveness: f64::NAN, ..ideal }), ["effectiveness"]);
    }
}
