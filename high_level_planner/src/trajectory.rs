//! The reference trajectory of an agent with its time derivatives.

use formation::formula::{Formula, Jet};
use formation::nalgebra::Vector3;
use formation::scenario::Context;

/// Position of a reference and its first three derivatives, in m, rad and s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectorySample {
    /// Position.
    pub position: Vector3<f64>,
    /// First derivative.
    pub velocity: Vector3<f64>,
    /// Second derivative.
    pub acceleration: Vector3<f64>,
    /// Third derivative.
    pub jerk: Vector3<f64>,
}

/// The formulas of one agent's reference.
#[derive(Clone, Debug)]
pub struct Trajectory {
    formulas: Vec<Formula>,
}

impl Trajectory {
    /// The reference of `agent` (from 0).
    pub fn new(context: &Context, agent: usize) -> Self {
        Self { formulas: context.reference[agent].clone() }
    }

    /// Position and derivatives at `time`, in s. The derivatives are exact: the formulas are evaluated on Taylor series.
    pub fn at(&self, time: f64) -> TrajectorySample {
        let arguments = [Jet::time(time)];
        let zero = Vector3::zeros();
        let mut sample = TrajectorySample { position: zero, velocity: zero, acceleration: zero, jerk: zero };
        for (j, formula) in self.formulas.iter().enumerate() {
            let jet = formula.evaluate_jet(&arguments);
            sample.position[j] = jet.value;
            sample.velocity[j] = jet.rate;
            sample.acceleration[j] = jet.acceleration;
            sample.jerk[j] = jet.jerk;
        }
        sample
    }
}
