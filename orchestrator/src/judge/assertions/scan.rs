//! Reading the text of a signal: references to fields and folds become names that a formula knows.

use formation::wiring::Assembly;

use super::slot::{Fold, Mistake, Slot};
use super::span::Span;

/// Most references to fields in one signal; keeps the names of slots shorter than what they stand for.
const MOST_SLOTS: usize = 64;

/// The text with `_0`, `_1`, ... in the place of what formulas do not know, and what these stand for. Offsets stay the same.
///
/// # Errors
/// The first [`Mistake`].
pub(super) fn scan(text: &str, assembly: &Assembly, agent: usize) -> Result<(String, Vec<Slot>), Mistake> {
    let rewritten = String::with_capacity(text.len());
    let mut scanner = Scanner { text, at: 0, rewritten, slots: Vec::new(), assembly, agent };
    scanner.scan()?;
    Ok((scanner.rewritten, scanner.slots))
}

/// Replaces what formulas do not know by names of slots that are as long, so that offsets stay.
struct Scanner<'a> {
    text: &'a str,
    at: usize,
    rewritten: String,
    slots: Vec<Slot>,
    assembly: &'a Assembly,
    agent: usize,
}

impl<'a> Scanner<'a> {
    fn scan(&mut self) -> Result<(), Mistake> {
        while let Some(character) = self.peek() {
            let start = self.at;
            if character.is_ascii_digit() {
                self.skip(|c| c.is_ascii_alphanumeric() || c == '.');
            } else if character == '_' {
                return Err(self.mistake(start, "expected a name that starts with a letter"));
            } else if character.is_ascii_alphabetic() {
                let word = self.word();
                if self.peek() == Some('.') {
                    self.at = start;
                    let span = self.reference()?;
                    if span.length != 1 {
                        let message = format!(
                            "expected a number, found a vector of {}: name a component, as in [0], or fold it, as in norm(...)",
                            span.length
                        );
                        return Err(self.mistake(start, message));
                    }
                    self.replace(start, Slot::Word(span))?;
                    continue;
                }
                let fold = Fold::ALL.into_iter().find(|(name, _)| *name == word).map(|(_, fold)| fold);
                if let (Some(fold), Some('(')) = (fold, self.text[self.at..].trim_start().chars().next()) {
                    self.spaces();
                    self.at += 1;
                    let slot = self.folded(fold)?;
                    self.replace(start, slot)?;
                    continue;
                }
            } else {
                self.at += character.len_utf8();
            }
            self.rewritten.push_str(&self.text[start..self.at]);
        }
        Ok(())
    }

    /// The argument of a fold and the parenthesis behind it.
    fn folded(&mut self, fold: Fold) -> Result<Slot, Mistake> {
        let first = self.reference()?;
        self.spaces();
        let mut less = None;
        if self.peek() == Some('-') {
            self.at += 1;
            self.spaces();
            let start = self.at;
            let second = self.reference()?;
            if second.length != first.length {
                let message = format!(
                    "expected {} values to subtract, found {}; choose some of them, as in [0:{}]",
                    first.length,
                    second.length,
                    first.length.min(second.length)
                );
                return Err(self.mistake(start, message));
            }
            less = Some(second);
            self.spaces();
        }
        if self.peek() != Some(')') {
            return Err(
                self.mistake(self.at, "expected `)`, or `-` and another field: a fold takes one field or a difference")
            );
        }
        self.at += 1;
        Ok(Slot::Folded(fold, first, less))
    }

    /// `state.position`, `state.position[2]` or `state.position[0:3]`.
    fn reference(&mut self) -> Result<Span, Mistake> {
        self.spaces();
        let start = self.at;
        let topic = self.word();
        if topic.is_empty() || self.peek() != Some('.') {
            return Err(self.mistake(start, "expected a field of a topic, such as state.position"));
        }
        self.at += 1;
        let field = self.word();
        let whole =
            Span::find(self.assembly, self.agent, topic, field).map_err(|message| self.mistake(start, message))?;
        if self.peek() != Some('[') {
            return Ok(whole);
        }
        let bracket = self.at;
        let end = self.text[bracket..].find(']').map(|length| bracket + length);
        let inside = end.map(|end| &self.text[bracket + 1..end]).unwrap_or_default();
        let (first, last) = match inside.split_once(':') {
            Some((first, last)) => (first.trim().parse().ok(), last.trim().parse().ok()),
            None => {
                let index: Option<usize> = inside.trim().parse().ok();
                (index, index.and_then(|index| index.checked_add(1)))
            }
        };
        match (first, last, end) {
            (Some(first), Some(last), Some(end)) if first < last && last <= whole.length => {
                self.at = end + 1;
                Ok(whole.part(first, last))
            }
            _ => {
                let message = format!(
                    "expected an index [K] or a range [FIRST:END] within the {} values of {topic}.{field}, counted from 0",
                    whole.length
                );
                Err(self.mistake(bracket, message))
            }
        }
    }

    /// Puts the name of a new slot in the place of what was read since `start`.
    fn replace(&mut self, start: usize, slot: Slot) -> Result<(), Mistake> {
        if self.slots.len() == MOST_SLOTS {
            return Err(self.mistake(start, format!("expected at most {MOST_SLOTS} fields in one signal, found more")));
        }
        let name = format!("_{}", self.slots.len());
        self.rewritten.push_str(&format!("{name:<width$}", width = self.at - start));
        self.slots.push(slot);
        Ok(())
    }

    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn spaces(&mut self) {
        self.skip(|character| character == ' ');
    }

    fn word(&mut self) -> &'a str {
        let start = self.at;
        self.skip(|character| character.is_ascii_alphanumeric() || character == '_');
        &self.text[start..self.at]
    }

    fn skip(&mut self, belongs: impl Fn(char) -> bool) {
        self.at += self.text[self.at..].chars().take_while(|c| belongs(*c)).map(char::len_utf8).sum::<usize>();
    }

    fn mistake(&self, offset: usize, message: impl Into<String>) -> Mistake {
        Mistake { offset, message: message.into() }
    }
}
