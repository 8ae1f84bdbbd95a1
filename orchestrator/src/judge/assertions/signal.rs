//! The text of a signal to a formula, or a condition, over slots.

use formation::formula::{Condition, Expression, Formula, FormulaError, Operand};
use formation::wiring::Assembly;
use lockstep::ChannelId;

use super::Signal;
use super::field::Fields;
use super::fold::Fold;
use super::geometry::{Geometry, METRICS};
use super::slot::Slot;

/// Compiles the signal `text` of the agent at this place, which is a number.
///
/// # Errors
/// The first mistake.
pub(super) fn number(
    text: &str,
    assembly: &Assembly,
    geometry: &Geometry,
    agent: usize,
) -> Result<(Formula, Vec<Slot>), FormulaError> {
    let mut fields = Fields::new(assembly, geometry, agent);
    let constant = |name: &str| constant(name, assembly, agent).map(Operand::Constant);
    let formula = Expression::parse_with(text, &mut fields).and_then(|expression| expression.compile(constant));
    Ok((formula.map_err(|error| hinted(error, text))?, fields.slots))
}

/// Compiles the signal `text` of the agent at this place, which is a condition.
///
/// # Errors
/// The first mistake.
pub(super) fn condition(
    text: &str,
    assembly: &Assembly,
    geometry: &Geometry,
    agent: usize,
) -> Result<(Condition, Vec<Slot>), FormulaError> {
    let mut fields = Fields::new(assembly, geometry, agent);
    let constant = |name: &str| constant(name, assembly, agent).map(Operand::Constant);
    let condition = Condition::parse(text, &mut fields, constant);
    Ok((condition.map_err(|error| hinted(error, text))?, fields.slots))
}

/// A signal of one agent, evaluated by others than assertions.
#[derive(Clone, Debug)]
pub(in crate::judge) struct AgentSignal {
    signal: Signal,
    slots: Vec<Slot>,
}

impl AgentSignal {
    /// Compiles the signal `text` of the agent at this place: a number, or a condition.
    ///
    /// # Errors
    /// The first mistake.
    pub(in crate::judge) fn compile(
        text: &str,
        assembly: &Assembly,
        geometry: &Geometry,
        agent: usize,
        is_condition: bool,
    ) -> Result<Self, FormulaError> {
        Ok(match is_condition {
            true => {
                let (condition, slots) = condition(text, assembly, geometry, agent)?;
                Self { signal: Signal::Condition(condition), slots }
            }
            false => {
                let (formula, slots) = number(text, assembly, geometry, agent)?;
                Self { signal: Signal::Number(formula), slots }
            }
        })
    }

    /// Its value at `time`, in s; of a condition, 1 where it holds, else 0. `values` is room for the slots.
    pub(in crate::judge) fn value<'s>(
        &self,
        time: f64,
        sample: &impl Fn(ChannelId) -> &'s [f64],
        values: &mut Vec<f64>,
    ) -> f64 {
        values.clear();
        values.extend(self.slots.iter().map(|slot| slot.value(time, sample)));
        match &self.signal {
            Signal::Number(formula) => formula.evaluate(values),
            Signal::Condition(condition) => f64::from(u8::from(condition.holds(values))),
        }
    }
}

fn hinted(error: FormulaError, text: &str) -> FormulaError {
    let names = METRICS.iter().map(|(name, _)| *name).chain(Fold::ALL.map(|(name, _)| name)).chain(["t", "UM"]);
    error.with_hint(text, names)
}

/// The value of a name that does not vary during a run.
pub(in crate::judge) fn constant(name: &str, assembly: &Assembly, agent: usize) -> Option<f64> {
    let context = &assembly.scenario.context;
    if name == "UM" {
        return context.input_limit;
    }
    context.constant(&context.agents[agent], name)
}
