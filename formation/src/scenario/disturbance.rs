//! What disturbs an agent.

use crate::formula::Formula;
use crate::vehicle::MAX_COORDINATES;

/// The disturbance of an agent: formulas over the slots t, coordinates, velocities.
#[derive(Clone, Debug, Default)]
pub struct Disturbance {
    /// Added where the input acts: to the acceleration, or to the velocity of a vehicle of order 1. Empty if there is none.
    pub matched: Vec<Formula>,
    /// Added to the velocity of a vehicle of order 2. Empty if there is none.
    pub mismatched: Vec<Formula>,
}

impl Disturbance {
    /// Writes what is added where the input acts, at time `t`, coordinates `x` and velocities `v` (zeros as far as they are not
    /// given); zeros if nothing is added. These are the bits that the plant `vehicles` uses.
    ///
    /// # Panics
    /// If there are more coordinates than any vehicle has.
    pub fn matched_at(&self, t: f64, x: &[f64], v: &[f64], out: &mut [f64]) {
        evaluate(&self.matched, t, x, v, out);
    }

    /// Writes what is added to the velocities of a vehicle of order 2; zeros if nothing is.
    ///
    /// # Panics
    /// See [`Disturbance::matched_at`].
    pub fn mismatched_at(&self, t: f64, x: &[f64], v: &[f64], out: &mut [f64]) {
        evaluate(&self.mismatched, t, x, v, out);
    }
}

fn evaluate(formulas: &[Formula], t: f64, x: &[f64], v: &[f64], out: &mut [f64]) {
    let mut slots = [0.0; 1 + 2 * MAX_COORDINATES];
    let velocities = 1 + x.len();
    slots[0] = t;
    slots[1..velocities].copy_from_slice(x);
    slots[velocities..velocities + v.len()].copy_from_slice(v);
    out.fill(0.0);
    for (value, formula) in out.iter_mut().zip(formulas) {
        *value = formula.evaluate(&slots[..1 + 2 * x.len()]);
    }
}
