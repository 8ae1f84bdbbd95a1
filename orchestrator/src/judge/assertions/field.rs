//! The operands of a signal that formulas do not know: fields of topics, vectors that become a number, metrics.

use formation::formula::{Cursor, FormulaError, Operands};
use formation::wiring::Assembly;

use super::fold::Fold;
use super::geometry::{Geometry, Nearest, place};
use super::slot::{About, Slot};
use super::span::Span;

/// What the signal of the agent at this place reads: `state.position[2]`, `norm(state.position[0:3] - reference.position)`, `t`
/// and metrics are slots.
pub(super) struct Fields<'a> {
    assembly: &'a Assembly,
    geometry: &'a Geometry,
    agent: usize,
    /// What fills the slots.
    pub(super) slots: Vec<Slot>,
    /// Slots that have a name: `t` and metrics.
    named: Vec<(String, usize)>,
}

impl Operands for Fields<'_> {
    fn read(&mut self, name: &str, start: usize, text: &mut Cursor) -> Result<Option<usize>, FormulaError> {
        if let Some((_, slot)) = self.named.iter().find(|(known, _)| known == name) {
            return Ok(Some(*slot));
        }
        let fold = Fold::ALL.into_iter().find(|(known, _)| *known == name).map(|(_, fold)| fold);
        let slot = match (text.peek(), fold) {
            (Some('.'), _) => Slot::Word(self.scalar(name, start, text)?),
            (_, Some(fold)) => {
                text.skip_space();
                if !text.take('(') {
                    return Err(text.unexpected(&format!("'(' behind '{name}'")));
                }
                self.folded(fold, text)?
            }
            _ => {
                let Some(slot) = self.named(name) else { return Ok(None) };
                self.named.push((name.into(), self.slots.len()));
                slot.map_err(|why| FormulaError::new(start, why))?
            }
        };
        self.slots.push(slot);
        Ok(Some(self.slots.len() - 1))
    }
}

impl<'a> Fields<'a> {
    pub(super) fn new(assembly: &'a Assembly, geometry: &'a Geometry, agent: usize) -> Self {
        Self { assembly, geometry, agent, slots: Vec::new(), named: Vec::new() }
    }

    /// The time, or a metric by its name; a reason if the scenario lacks what it needs.
    fn named(&self, name: &str) -> Option<Result<Slot, String>> {
        let find = |topic, field| Span::find(self.assembly, self.agent, topic, field);
        match name {
            "t" => Some(Ok(Slot::Time)),
            "link_age" => Some(self.links(About::Age)),
            "link_loss" => Some(self.links(About::Loss)),
            "link_messages" => Some(self.links(About::Messages)),
            "tracking" => {
                let angles = self.assembly.scenario.context.agents[self.agent].angles.clone();
                let own = find("state", "position");
                Some(own.and_then(|own| Ok(Slot::Tracking(own, place(self.assembly, self.agent)?, angles))))
            }
            _ => {
                Nearest::named(name, self.assembly, self.geometry, self.agent).map(|nearest| nearest.map(Slot::Nearest))
            }
        }
    }

    fn links(&self, about: About) -> Result<Slot, String> {
        Ok(Slot::Links(about, Span::of_links(self.assembly, self.agent)?))
    }

    fn scalar(&self, topic: &str, start: usize, text: &mut Cursor) -> Result<Span, FormulaError> {
        let span = self.span(topic, start, text)?;
        if span.length == 1 {
            return Ok(span);
        }
        let length = span.length;
        let message = format!(
            "expected a number, found a vector of {length}: name a component, as in [0], or fold it, as in norm(...)"
        );
        Err(FormulaError::new(start, message))
    }

    /// The argument of a fold and the parenthesis behind it.
    fn folded(&self, fold: Fold, text: &mut Cursor) -> Result<Slot, FormulaError> {
        let first = self.vector(text)?;
        let mut less = None;
        text.skip_space();
        if text.take('-') {
            text.skip_space();
            let start = text.offset();
            let second = self.vector(text)?;
            let (expected, found) = (first.length, second.length);
            if expected != found {
                let message = format!(
                    "expected {expected} values to subtract, found {found}; choose some of them, as in [0:{}]",
                    expected.min(found)
                );
                return Err(FormulaError::new(start, message));
            }
            less = Some(second);
            text.skip_space();
        }
        if !text.take(')') {
            return Err(text.unexpected("')', or '-' and another field, as the argument is one field or a difference"));
        }
        Ok(Slot::Folded(fold, first, less))
    }

    fn vector(&self, text: &mut Cursor) -> Result<Span, FormulaError> {
        text.skip_space();
        let start = text.offset();
        let topic = text.take_name();
        if topic.is_empty() || text.peek() != Some('.') {
            return Err(FormulaError::new(start, "expected a field of a topic, such as state.position"));
        }
        self.span(topic, start, text)
    }

    /// `.position`, `.position[2]` or `.position[0:3]` behind the name of a topic that starts at byte `start`.
    fn span(&self, topic: &str, start: usize, text: &mut Cursor) -> Result<Span, FormulaError> {
        text.take('.');
        let field = text.take_name();
        let whole = Span::find(self.assembly, self.agent, topic, field);
        let whole = whole.map_err(|message| FormulaError::new(start, message))?;
        let bracket = text.offset();
        if !text.take('[') {
            return Ok(whole);
        }
        let inside = text.take_while(|character| character != ']');
        let (first, last) = match inside.split_once(':') {
            Some((first, last)) => (first.trim().parse().ok(), last.trim().parse().ok()),
            None => {
                let index: Option<usize> = inside.trim().parse().ok();
                (index, index.and_then(|index| index.checked_add(1)))
            }
        };
        match (first, last, text.take(']')) {
            (Some(first), Some(last), true) if first < last && last <= whole.length => Ok(whole.part(first, last)),
            _ => {
                let length = whole.length;
                let message = format!(
                    "expected an index [K] or a range [FIRST:END] within the {length} values of {topic}.{field}, counted from 0"
                );
                Err(FormulaError::new(bracket, message))
            }
        }
    }
}
