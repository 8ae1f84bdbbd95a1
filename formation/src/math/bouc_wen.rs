//! Hysteresis of actuators by the model of Bouc and Wen, forward and inverse. (2.2), (2.3), (2.22)

use schemars::JsonSchema;
use serde::Deserialize;

use super::sign;

/// Steps into which one change of the input is cut at most.
const MOST_STEPS: f64 = 1000.0;

/// The model of one actuator: `h = μ u + μ̄ ζ` with a memory ζ that moves only while the input u moves.
///
/// It does not depend on how fast the input changes, so a held input needs no integration: each jump of the input moves the
/// memory once, in steps that are short enough for explicit Euler.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoucWen {
    /// μ, weight of the input itself.
    #[serde(rename = "mu")]
    pub direct: f64,
    /// μ̄, weight of the memory.
    #[serde(rename = "mu_bar")]
    pub hysteretic: f64,
    /// χ̄, shape of the loop.
    #[serde(rename = "chi_bar")]
    pub width: f64,
    /// χ, shape of the loop, smaller than χ̄.
    #[serde(rename = "chi")]
    pub slant: f64,
    /// m, smoothness of the initial slope, at least 1.
    #[serde(rename = "m_bw")]
    pub smoothness: f64,
    /// Longest change of the input that is one Euler step.
    #[serde(rename = "du_sub")]
    pub substep: f64,
}

impl BoucWen {
    /// What is wrong with these numbers: field and message.
    pub fn findings(&self) -> Vec<(&'static str, String)> {
        let mut findings = Vec::new();
        for (field, value) in [("mu", self.direct), ("chi_bar", self.width), ("du_sub", self.substep)] {
            if !(value.is_finite() && value > 0.0) {
                findings.push((field, format!("expected a number > 0, found {value}")));
            }
        }
        if !(self.hysteretic.is_finite() && self.hysteretic >= 0.0) {
            findings.push(("mu_bar", format!("expected a number >= 0, found {}", self.hysteretic)));
        }
        if self.slant.is_nan() || self.width.is_nan() || self.slant.abs() >= self.width {
            let message =
                format!("expected a number between -chi_bar and chi_bar = {}, found {}", self.width, self.slant);
            findings.push(("chi", message));
        }
        if !(self.smoothness.is_finite() && self.smoothness >= 1.0) {
            findings.push(("m_bw", format!("expected a number >= 1, found {}", self.smoothness)));
        }
        findings
    }

    /// The largest memory that can be reached from 0: `(χ̄ + χ)^(-1/m)`.
    #[cfg(test)]
    fn memory_limit(&self) -> f64 {
        libm::pow(self.width + self.slant, -1.0 / self.smoothness)
    }

    /// h, what the actuator makes of its input. (2.2)
    pub fn output(&self, input: f64, memory: f64) -> f64 {
        self.direct * input + self.hysteretic * memory
    }

    /// The memory after the input has changed by `change`. (2.3)
    pub fn forward(&self, memory: f64, change: f64) -> f64 {
        let (steps, step) = self.cut(change);
        let direction = sign(change);
        let mut memory = memory;
        for _ in 0..steps {
            memory += step * self.slope(memory, direction);
        }
        memory
    }

    /// The change of the input that changes the output by `change`, and the memory after it. (2.22)
    pub fn inverse(&self, memory: f64, change: f64) -> (f64, f64) {
        let (steps, step) = self.cut(change);
        let direction = sign(change);
        let (mut memory, mut input_change) = (memory, 0.0);
        for _ in 0..steps {
            let slope = self.slope(memory, direction);
            let part = step / (self.direct + self.hysteretic * slope);
            input_change += part;
            memory += part * slope;
        }
        (input_change, memory)
    }

    /// g, the slope of the memory over the input. (2.22)
    fn slope(&self, memory: f64, direction: f64) -> f64 {
        let size = memory.abs();
        // |ζ|^(m-1); with the usual m = 2 that takes no power, which is most of the time of a large jump.
        let power = if self.smoothness == 2.0 { size } else { libm::pow(size, self.smoothness - 1.0) };
        1.0 - self.width * direction * power * memory - self.slant * power * size
    }

    /// Number and length of the Euler steps of a change. What is no number becomes one step, which passes it on.
    fn cut(&self, change: f64) -> (u32, f64) {
        let steps = if change.is_nan() { 1.0 } else { (change.abs() / self.substep).ceil().clamp(1.0, MOST_STEPS) };
        (steps as u32, change / steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MODEL: BoucWen =
        BoucWen { direct: 1.5, hysteretic: 3.0, width: 1.0, slant: 0.5, smoothness: 2.0, substep: 0.01 };

    fn models() -> impl Strategy<Value = BoucWen> {
        (0.5..3.0f64, 0.0..4.0f64, 0.2..2.0f64, -0.95..0.95f64, 1.0..3.0f64).prop_map(
            |(direct, hysteretic, width, share, smoothness)| BoucWen {
                direct,
                hysteretic,
                width,
                slant: share * width,
                smoothness,
                substep: 0.01,
            },
        )
    }

    proptest! {
        #[test]
        fn the_memory_stays_in_its_bounds(model in models(), changes in proptest::collection::vec(-3.0..3.0f64, 1..40)) {
            let mut memory = 0.0;
            for change in changes {
                memory = model.forward(memory, change);
                prop_assert!(memory.abs() <= model.memory_limit() + 1e-9, "{memory}");
            }
        }

        #[test]
        fn the_inverse_undoes_the_model(model in models(), changes in proptest::collection::vec(-1.0..1.0f64, 1..30)) {
            let (mut input, mut inner, mut memory, mut wanted) = (0.0, 0.0, 0.0, 0.0);
            for change in changes {
                let (input_change, next) = model.inverse(inner, change);
                inner = next;
                input += input_change;
                wanted += change;
                memory = model.forward(memory, input_change);
                prop_assert!((memory - inner).abs() < 0.03, "{memory} {inner}");
                prop_assert!((model.output(input, memory) - wanted).abs() < 0.1);
            }
        }

        #[test]
        fn odd_and_independent_of_the_rate(model in models(), memory in -0.4..0.4f64, change in 0.0..2.0f64, parts in 1..20u32) {
            prop_assert_eq!(model.forward(-memory, -change), -model.forward(memory, change));
            let mut slowly = memory;
            for _ in 0..parts {
                slowly = model.forward(slowly, change / f64::from(parts));
            }
            prop_assert!((slowly - model.forward(memory, change)).abs() < 0.03);
        }
    }

    /// One Euler step of 0.01 from a memory of 0.5, against and along it.
    #[test]
    fn one_step_by_hand() {
        assert!((MODEL.forward(0.5, 0.01) - (0.5 + 0.01 * (1.0 - 0.25 - 0.125))).abs() < 1e-15);
        assert!((MODEL.forward(0.5, -0.01) - (0.5 - 0.01 * (1.0 + 0.25 - 0.125))).abs() < 1e-15);
        let (change, memory) = MODEL.inverse(0.5, 0.01);
        assert!((change - 0.01 / (1.5 + 3.0 * 0.625)).abs() < 1e-15);
        assert!((memory - (0.5 + change * 0.625)).abs() < 1e-15);
        assert_eq!((MODEL.forward(0.5, 0.0), MODEL.inverse(0.5, 0.0)), (0.5, (0.0, 0.5)));
    }

    #[test]
    fn a_full_loop_saturates() {
        let up = MODEL.forward(0.0, 10.0);
        assert!((up - MODEL.memory_limit()).abs() < 0.01, "{up}");
        assert!(MODEL.forward(up, -10.0) < -0.99 * MODEL.memory_limit());
    }

    #[test]
    fn what_is_not_finite_passes_without_end() {
        assert!(!MODEL.forward(0.1, f64::INFINITY).is_finite());
        assert!(MODEL.forward(0.1, f64::NAN).is_nan());
    }

    #[test]
    fn findings_name_the_field() {
        assert!(MODEL.findings().is_empty());
        let fields = |model: BoucWen| model.findings().into_iter().map(|(field, _)| field).collect::<Vec<_>>();
        assert_eq!(fields(BoucWen { slant: -1.0, smoothness: 0.5, ..MODEL }), ["chi", "m_bw"]);
        assert_eq!(fields(BoucWen { direct: 0.0, substep: f64::NAN, ..MODEL }), ["mu", "du_sub"]);
    }
}
