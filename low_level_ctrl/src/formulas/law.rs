//! The compiled law of one agent, and its values.

use formation::formula::Formula;
use formation::scenario::AdjacencyRow;
use lockstep::{Fault, Io, Slice, Step};

/// The code of a law. All formulas are evaluated on one list of numbers, the slots.
pub(super) struct Program {
    /// Number of slots.
    pub(super) slots: usize,
    /// Signals of the own agent: where each is read, which of its numbers, and the slot of it.
    pub(super) own: Vec<(Slice, usize, usize)>,
    /// Slots of signals of a neighbour, in the order in which each neighbour lists them.
    pub(super) of_neighbour: Vec<usize>,
    /// The neighbours that are heard.
    pub(super) neighbours: Vec<Neighbour>,
    /// Links of this instant.
    pub(super) row: AdjacencyRow,
    /// The own position, if links depend on distances.
    pub(super) position: Option<Slice>,
    /// Slots of the weight a_ij and of the number j.
    pub(super) link: [usize; 2],
    /// Slot of the weight b_i.
    pub(super) reference_weight: usize,
    /// Sums and definitions in the order of their evaluation, each with its slot.
    pub(super) parts: Vec<(Part, usize)>,
    /// The slot of each state of the controller, and its time derivative.
    pub(super) states: Vec<(usize, Formula)>,
    /// Inputs, then signals.
    pub(super) results: Vec<Formula>,
    /// Where each of them is written, with its text.
    pub(super) texts: Vec<(String, String)>,
    /// Values of the slots at t = 0: constants and initial states.
    pub(super) initial: Vec<(usize, f64)>,
}

/// An agent that is heard.
pub(super) struct Neighbour {
    /// Its place among the agents, from 0.
    pub(super) agent: usize,
    /// The number that formulas know it by.
    pub(super) id: u32,
    /// Its signals: where each is read, and which of its numbers.
    pub(super) signals: Vec<(Slice, usize)>,
    /// Its position, if links depend on distances.
    pub(super) position: Option<Slice>,
}

/// What has a slot of its own.
pub(super) enum Part {
    /// The value of a formula.
    Value(Formula),
    /// The sum of a formula over the neighbours.
    Sum(Formula),
}

/// A law with its memory. `update` does not allocate.
pub(super) struct Law {
    program: Program,
    slots: Vec<f64>,
    values: Vec<f64>,
    /// The weight a_ij of each neighbour that is heard.
    weights: Vec<f64>,
    /// Time derivatives of the states, of the run before.
    rates: Vec<f64>,
    /// The step of the run before.
    before: Option<u64>,
}

impl Law {
    pub(super) fn new(program: Program) -> Self {
        let mut slots = vec![0.0; program.slots];
        program.initial.iter().for_each(|&(slot, value)| slots[slot] = value);
        let values = vec![0.0; program.results.len()];
        let rates = vec![0.0; program.states.len()];
        let weights = vec![0.0; program.neighbours.len()];
        Self { program, slots, values, weights, rates, before: None }
    }

    /// Inputs and signals of the last update.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// What is wrong with the values of the last update: the first that is not finite.
    pub(super) fn fault(&self) -> Option<Fault> {
        let place = self.values.iter().position(|value| !value.is_finite())?;
        let (path, text) = &self.program.texts[place];
        Some(Fault(format!("controller.{path} is {}: \"{text}\"", self.values[place])))
    }

    /// Computes all values from the samples of this step.
    pub(super) fn update(&mut self, step: &Step, io: &Io) {
        let Self { program, slots, values, weights, rates, before } = self;
        if let Some(before) = before.replace(step.index) {
            // A controller may run at every so many steps only.
            let period = (step.index - before) as f64 * step.dt;
            for ((slot, _), rate) in program.states.iter().zip(&*rates) {
                slots[*slot] += period * rate;
            }
        }
        slots[0] = step.time();
        program.row.follow(step.index);
        slots[program.reference_weight] = program.row.reference();
        for &(slice, element, slot) in &program.own {
            slots[slot] = io.slice(slice)[element];
        }
        for (weight, neighbour) in weights.iter_mut().zip(&program.neighbours) {
            let distance = program
                .position
                .zip(neighbour.position)
                .map_or(f64::INFINITY, |(own, other)| distance(io.slice(own), io.slice(other)));
            *weight = program.row.update(neighbour.agent, distance);
        }
        for (part, slot) in &program.parts {
            slots[*slot] = match part {
                Part::Value(formula) => formula.evaluate(slots),
                Part::Sum(formula) => {
                    let mut sum = 0.0;
                    for (weight, neighbour) in weights.iter().zip(&program.neighbours) {
                        if *weight != 0.0 {
                            neighbour.write(*weight, &program.link, &program.of_neighbour, slots, io);
                            sum += formula.evaluate(slots);
                        }
                    }
                    sum
                }
            };
        }
        for (rate, (_, formula)) in rates.iter_mut().zip(&program.states) {
            *rate = formula.evaluate(slots);
        }
        for (value, formula) in values.iter_mut().zip(&program.results) {
            *value = formula.evaluate(slots);
        }
    }
}

impl Neighbour {
    /// Writes its link and its signals into the slots.
    fn write(&self, weight: f64, link: &[usize; 2], of_neighbour: &[usize], slots: &mut [f64], io: &Io) {
        slots[link[0]] = weight;
        slots[link[1]] = f64::from(self.id);
        for (&slot, &(slice, element)) in of_neighbour.iter().zip(&self.signals) {
            slots[slot] = io.slice(slice)[element];
        }
    }
}

fn distance(own: &[f64], other: &[f64]) -> f64 {
    own.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
