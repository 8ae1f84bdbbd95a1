//! The text of a signal to a formula over slots.

use formation::config::nearest;
use formation::formula::{Expression, Formula, Operand};
use formation::wiring::Assembly;

use super::geometry::{Geometry, METRICS, Nearest};
use super::scan::scan;
use super::slot::{Fold, Mistake, Slot};
use super::span::Span;

/// Compiles the signal `text` of the agent at this place.
///
/// # Errors
/// The first [`Mistake`].
pub(super) fn compile(
    text: &str,
    assembly: &Assembly,
    geometry: &Geometry,
    agent: usize,
) -> Result<(Formula, Vec<Slot>), Mistake> {
    let (rewritten, mut slots) = scan(text, assembly, agent)?;
    let references = slots.len();
    let mut reason = None;
    let compiled = Expression::parse(&rewritten).and_then(|expression| {
        expression.compile(|name| {
            if let Some(index) = name.strip_prefix('_') {
                return index.parse().ok().filter(|index| *index < references).map(Operand::Slot);
            }
            let slot = match metric(name, assembly, geometry, agent) {
                _ if name == "t" => Slot::Time,
                Some(Ok(slot)) => slot,
                Some(Err(why)) => {
                    reason.get_or_insert(why);
                    return None;
                }
                None => return constant(name, assembly, agent).map(Operand::Constant),
            };
            slots.push(slot);
            Some(Operand::Slot(slots.len() - 1))
        })
    });
    match compiled {
        Ok(formula) => Ok((formula, slots)),
        Err(error) => {
            let unknown: String = text[error.offset.min(text.len())..]
                .chars()
                .take_while(|character| character.is_ascii_alphanumeric() || *character == '_')
                .collect();
            let names = METRICS.iter().map(|(name, _)| *name).chain(Fold::ALL.map(|(name, _)| name)).chain(["t", "UM"]);
            let hint = nearest(&unknown, names).map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            let message = reason.unwrap_or_else(|| format!("{}{hint}", error.message));
            Err(Mistake { offset: error.offset, message })
        }
    }
}

/// The value of a name that does not vary during a run.
pub(super) fn constant(name: &str, assembly: &Assembly, agent: usize) -> Option<f64> {
    let context = &assembly.scenario.context;
    if name == "UM" {
        return context.input_limit;
    }
    context.constant(&context.agents[agent], name)
}

/// A metric by its name; a reason if the scenario lacks what it needs.
fn metric(name: &str, assembly: &Assembly, geometry: &Geometry, agent: usize) -> Option<Result<Slot, String>> {
    if name == "tracking" {
        let find = |topic, field| Span::find(assembly, agent, topic, field);
        let place = find("reference", "desired_position").or_else(|_| find("reference", "position"));
        let slot = find("state", "position").and_then(|own| Ok(Slot::Folded(Fold::Norm, own, Some(place?))));
        return Some(slot);
    }
    Nearest::named(name, assembly, geometry, agent).map(|nearest| nearest.map(Slot::Nearest))
}
