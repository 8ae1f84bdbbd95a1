//! Vehicles by equations: named states and inputs, `dx/dt = f(t, x, u)` with f in formulas.

use lockstep::Field;

use crate::formula::Formula;

/// A state, an input or a parameter, with its unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Its name in formulas, signals and rows of agents.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
}

/// A signal that the plant publishes besides the states.
#[derive(Clone, Debug)]
pub struct ModelOutput {
    /// Name, length and unit.
    pub field: Field,
    /// A formula for each of its numbers, over the slots of the model.
    pub formulas: Vec<Formula>,
}

/// The model of one agent, with its parameters in place.
///
/// All formulas are evaluated on one list of numbers, the *slots*: t, the states, the inputs, and then the definitions, which are
/// computed from the slots before them.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Its name in messages and in the library, `unicycle`.
    pub kind: String,
    /// The states in order.
    pub states: Vec<Variable>,
    /// The inputs in order.
    pub inputs: Vec<Variable>,
    /// The least and the greatest value of each input that acts.
    pub limits: Vec<(f64, f64)>,
    /// Named numbers of this agent, for formulas.
    pub parameters: Vec<(String, f64)>,
    /// Values of the states at t = 0.
    pub initial: Vec<f64>,
    /// Parts of the formulas that have names, in order.
    pub definitions: Vec<Formula>,
    /// The time derivative of each state.
    pub rates: Vec<Formula>,
    /// The position of the agent, 1 to 3 coordinates; empty if the model has none.
    pub position: Vec<Formula>,
    /// The time derivative of the position, as far as it is known.
    pub velocity: Vec<Formula>,
    /// The other signals.
    pub outputs: Vec<ModelOutput>,
    /// Which states are angles.
    pub angles: Vec<bool>,
    /// The states that the coordinates of the position are; empty if it has other formulas.
    pub position_states: Vec<usize>,
    /// Which coordinates of the position are angles.
    pub position_angles: Vec<bool>,
    /// Units of the position and of the velocity.
    pub units: [String; 2],
    /// Which states a semi-implicit method advances first: velocities, on which the rates of the others depend.
    pub leading: Vec<bool>,
}

impl Model {
    /// Number of slots.
    pub fn slots(&self) -> usize {
        self.first_definition() + self.definitions.len()
    }

    /// The slots of a model at rest at t = 0.
    pub fn start(&self) -> Vec<f64> {
        let mut slots = vec![0.0; self.slots()];
        slots[1..=self.states.len()].copy_from_slice(&self.initial);
        self.define(&mut slots);
        slots
    }

    /// Sets the time and the states, and computes the definitions. The inputs stay. Does not allocate.
    ///
    /// # Panics
    /// If there are not as many slots as the model has, or other numbers of states.
    pub fn set(&self, slots: &mut [f64], time: f64, states: &[f64]) {
        slots[0] = time;
        slots[1..=self.states.len()].copy_from_slice(states);
        self.define(slots);
    }

    /// The inputs among the slots.
    ///
    /// # Panics
    /// If there are not as many slots as the model has.
    pub fn inputs_mut<'a>(&self, slots: &'a mut [f64]) -> &'a mut [f64] {
        &mut slots[1 + self.states.len()..self.first_definition()]
    }

    /// Writes the time derivatives of all states at these slots. Does not allocate.
    ///
    /// # Panics
    /// If there are fewer slots or states than the model has.
    pub fn slope(&self, slots: &[f64], out: &mut [f64]) {
        evaluate(&self.rates, slots, out);
    }

    /// The value of the parameter called `name`.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// What the input is called and measured in.
    pub fn input_field(&self) -> Field {
        Field::vector("input", self.inputs.len(), &units(self.inputs.iter().map(|input| input.unit.as_str())))
    }

    /// What the plant publishes, in order.
    pub fn fields(&self) -> Vec<Field> {
        let [position, velocity] = &self.units;
        let vectors = [("position", &self.position, position), ("velocity", &self.velocity, velocity)];
        let vectors = vectors.into_iter().filter(|(_, formulas, _)| !formulas.is_empty());
        let states = self.states.iter().map(|state| Field::scalar(&state.name, &state.unit));
        vectors
            .map(|(name, formulas, unit)| Field::vector(name, formulas.len(), unit))
            .chain(states)
            .chain(self.outputs.iter().map(|output| output.field.clone()))
            .collect()
    }

    fn first_definition(&self) -> usize {
        1 + self.states.len() + self.inputs.len()
    }

    fn define(&self, slots: &mut [f64]) {
        for (place, formula) in (self.first_definition()..).zip(&self.definitions) {
            slots[place] = formula.evaluate(slots);
        }
    }
}

/// Writes the value of each formula. Does not allocate.
///
/// # Panics
/// If there are fewer slots than the formulas use.
pub fn evaluate(formulas: &[Formula], slots: &[f64], out: &mut [f64]) {
    for (value, formula) in out.iter_mut().zip(formulas) {
        *value = formula.evaluate(slots);
    }
}

/// The units of several numbers: one if it is the same for all, else all.
pub fn units<'a>(each: impl Iterator<Item = &'a str>) -> String {
    let each: Vec<&str> = each.collect();
    match each.first() {
        Some(first) if each.iter().all(|unit| unit == first) => first.to_string(),
        _ => each.iter().map(|unit| if unit.is_empty() { "1" } else { unit }).collect::<Vec<_>>().join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::units;

    #[test]
    fn equal_units_are_written_once() {
        assert_eq!(units(["m", "m"].into_iter()), "m");
        assert_eq!(units(["m/s", "rad/s"].into_iter()), "m/s, rad/s");
        assert_eq!(units(["", "rad"].into_iter()), "1, rad");
        assert_eq!(units(["", ""].into_iter()), "");
    }
}
