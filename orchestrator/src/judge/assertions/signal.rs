//! The text of a signal to a formula, or a condition, over slots.

use formation::formula::{Condition, Expression, Formula, FormulaError, Operand};
use formation::wiring::Assembly;

use super::field::Fields;
use super::geometry::{Geometry, METRICS};
use super::slot::{Fold, Slot};

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

fn hinted(error: FormulaError, text: &str) -> FormulaError {
    let names = METRICS.iter().map(|(name, _)| *name).chain(Fold::ALL.map(|(name, _)| name)).chain(["t", "UM"]);
    error.with_hint(text, names)
}

/// The value of a name that does not vary during a run.
pub(super) fn constant(name: &str, assembly: &Assembly, agent: usize) -> Option<f64> {
    let context = &assembly.scenario.context;
    if name == "UM" {
        return context.input_limit;
    }
    context.constant(&context.agents[agent], name)
}
