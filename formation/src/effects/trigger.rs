//! Formulas by which a sender decides when to send.

use crate::formula::{Condition, Cursor, Expression, Formula, FormulaError, Operand, Operands};

/// The signals that a formula may name.
#[derive(Clone, Debug, Default)]
pub struct TriggerFields {
    /// Fields of the message, with their first number and their length, in order.
    pub message: Vec<(String, usize, usize)>,
    /// Signals of the sender that are not part of the message, such as `command.input`, with their lengths, in order.
    pub others: Vec<(String, usize)>,
}

/// A condition or a formula over the time `t`, the time since the last message `since`, the fields of the message (`position[0]`), those of the
/// last message that was sent (`sent.position[0]`), other signals of the sender (`command.input[0]`, of the step before), and
/// `norm(...)` of one of them or of a difference of two: `norm(position - sent.position) > 0.02 + 0.5*exp(-t)`.
#[derive(Clone, Debug)]
pub struct Trigger {
    kind: Kind,
    folds: Vec<Fold>,
    width: usize,
    /// t, since, the message, the last message, the other signals, the norms.
    slots: Vec<f64>,
    sent_at: f64,
}

#[derive(Clone, Debug)]
enum Kind {
    Condition(Condition),
    Formula(Formula),
}

/// The norm of a vector, or of the difference of two, by their first slots and length.
#[derive(Clone, Debug, PartialEq)]
struct Fold {
    first: usize,
    less: Option<usize>,
    length: usize,
}

/// The slots before the message.
const TIME: usize = 0;
const SINCE: usize = 1;
const MESSAGE: usize = 2;

impl Trigger {
    /// Reads a condition.
    ///
    /// # Errors
    /// [`FormulaError`] for a text that is none, or that names a signal that is not there.
    pub fn condition(
        text: &str,
        fields: &TriggerFields,
        constant: &dyn Fn(&str) -> Option<f64>,
    ) -> Result<Self, FormulaError> {
        Self::read(fields, |reader| Ok(Kind::Condition(Condition::parse(text, reader, |name| named(name, constant))?)))
    }

    /// Reads a formula.
    ///
    /// # Errors
    /// See [`Trigger::condition`].
    pub fn formula(
        text: &str,
        fields: &TriggerFields,
        constant: &dyn Fn(&str) -> Option<f64>,
    ) -> Result<Self, FormulaError> {
        Self::read(fields, |reader| {
            Ok(Kind::Formula(Expression::parse_with(text, reader)?.compile(|name| named(name, constant))?))
        })
    }

    fn read(
        fields: &TriggerFields,
        compile: impl FnOnce(&mut Reader) -> Result<Kind, FormulaError>,
    ) -> Result<Self, FormulaError> {
        let width = fields.message.iter().map(|(_, first, length)| first + length).max().unwrap_or(0);
        let others: usize = fields.others.iter().map(|(_, length)| length).sum();
        let mut reader = Reader { fields, width, first_fold: MESSAGE + 2 * width + others, folds: Vec::new() };
        let kind = compile(&mut reader)?;
        let slots = vec![0.0; reader.first_fold + reader.folds.len()];
        Ok(Self { kind, folds: reader.folds, width, slots, sent_at: 0.0 })
    }

    /// Whether the condition holds, 1 or 0, or the value of the formula, for what the sender has at time `t`, s.
    pub fn value(&mut self, t: f64, message: &[f64], others: &[f64]) -> f64 {
        self.slots[TIME] = t;
        self.slots[SINCE] = t - self.sent_at;
        self.slots[MESSAGE..MESSAGE + self.width].copy_from_slice(&message[..self.width]);
        let first = MESSAGE + 2 * self.width;
        self.slots[first..first + others.len()].copy_from_slice(others);
        let norms = self.slots.len() - self.folds.len();
        for (place, fold) in self.folds.iter().enumerate() {
            let square = |k: usize| {
                let less = fold.less.map_or(0.0, |less| self.slots[less + k]);
                (self.slots[fold.first + k] - less).powi(2)
            };
            self.slots[norms + place] = (0..fold.length).map(square).sum::<f64>().sqrt();
        }
        match &self.kind {
            Kind::Condition(condition) => f64::from(u8::from(condition.holds(&self.slots))),
            Kind::Formula(formula) => formula.evaluate(&self.slots),
        }
    }

    /// Says that the message is sent at time `t`, s.
    pub fn sent(&mut self, t: f64, message: &[f64]) {
        self.sent_at = t;
        let first = MESSAGE + self.width;
        self.slots[first..first + self.width].copy_from_slice(&message[..self.width]);
    }
}

fn named(name: &str, constant: &dyn Fn(&str) -> Option<f64>) -> Option<Operand> {
    match name {
        "t" => Some(Operand::Slot(TIME)),
        "since" => Some(Operand::Slot(SINCE)),
        _ => constant(name).map(Operand::Constant),
    }
}

/// Reads signals and norms.
struct Reader<'a> {
    fields: &'a TriggerFields,
    width: usize,
    first_fold: usize,
    folds: Vec<Fold>,
}

impl Operands for Reader<'_> {
    fn read(&mut self, name: &str, start: usize, text: &mut Cursor) -> Result<Option<usize>, FormulaError> {
        if name == "norm" && text.peek() == Some('(') {
            return self.norm(text).map(Some);
        }
        let Some((first, length)) = self.signal(name, start, text)? else { return Ok(None) };
        if text.peek() == Some('[') {
            return text.take_index(length).map(|index| Some(first + index));
        }
        let message =
            format!("`{name}` has {length} numbers: expected one of them, such as {name}[0], or norm({name})");
        if length == 1 { Ok(Some(first)) } else { Err(FormulaError::new(start, message)) }
    }
}

impl Reader<'_> {
    /// The first slot of a signal, and its length.
    fn signal(&self, name: &str, start: usize, text: &mut Cursor) -> Result<Option<(usize, usize)>, FormulaError> {
        let of_message = |name: &str, first: usize| {
            let field = self.fields.message.iter().find(|(known, ..)| known == name);
            field.map(|(_, offset, length)| (first + offset, *length))
        };
        if text.peek() != Some('.') {
            return Ok(of_message(name, MESSAGE));
        }
        text.take('.');
        let field = text.take_name();
        let found = if name == "sent" {
            of_message(field, MESSAGE + self.width)
        } else {
            let mut first = MESSAGE + 2 * self.width;
            let mut found = None;
            for (known, length) in &self.fields.others {
                if known.split_once('.') == Some((name, field)) {
                    found = Some((first, *length));
                }
                first += length;
            }
            found
        };
        found.map(Some).ok_or_else(|| {
            let own = self.fields.message.iter().map(|(name, ..)| format!("{name}, sent.{name}"));
            let others = self.fields.others.iter().map(|(name, _)| name.clone());
            let known = own.chain(others).collect::<Vec<_>>().join(", ");
            FormulaError::new(start, format!("expected a signal of the sender, {known}, found '{name}.{field}'"))
        })
    }

    fn norm(&mut self, text: &mut Cursor) -> Result<usize, FormulaError> {
        text.take('(');
        let (first, length) = self.vector(text)?;
        text.skip_space();
        let mut less = None;
        if text.take('-') {
            let place = text.offset();
            let (second, other) = self.vector(text)?;
            if other != length {
                let message = format!("expected {length} values to subtract, found {other}");
                return Err(FormulaError::new(place, message));
            }
            less = Some(second);
            text.skip_space();
        }
        if !text.take(')') {
            return Err(text.unexpected("')', or '-' and another signal"));
        }
        let fold = Fold { first, less, length };
        let place = self.folds.iter().position(|known| *known == fold).unwrap_or_else(|| {
            self.folds.push(fold);
            self.folds.len() - 1
        });
        Ok(self.first_fold + place)
    }

    fn vector(&self, text: &mut Cursor) -> Result<(usize, usize), FormulaError> {
        text.skip_space();
        let start = text.offset();
        let name = text.take_name();
        self.signal(name, start, text)?.ok_or_else(|| {
            let known = self.fields.message.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>().join(", ");
            FormulaError::new(start, format!("expected a signal of the sender, {known}, found '{name}'"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields() -> TriggerFields {
        let field = |name: &str, first, length| (name.to_string(), first, length);
        TriggerFields {
            message: vec![field("position", 0, 2), field("x", 2, 1)],
            others: vec![("command.input".into(), 2), ("command.z".into(), 1)],
        }
    }

    #[test]
    fn knows_what_was_sent_and_what_else_the_sender_has() {
        let text =
            "norm(position - sent.position) > a + command.z*since and position[1] + sent.x < norm(command.input)";
        let mut trigger = Trigger::condition(text, &fields(), &|name| (name == "a").then_some(1.0)).unwrap();
        let others = [30.0, 40.0, 0.5];
        trigger.sent(1.0, &[0.0, 0.0, 7.0]);
        // 5 > 1 + 0.5*2 and 4 + 7 < 50
        assert_eq!(trigger.value(3.0, &[3.0, 4.0, 0.0], &others), 1.0);
        assert_eq!(trigger.value(9.0, &[3.0, 4.0, 0.0], &others), 0.0);
        assert_eq!(trigger.value(3.0, &[3.0, 44.0, 0.0], &others), 0.0);

        let mut interval = Trigger::formula("0.1 + x", &fields(), &|_| None).unwrap();
        assert_eq!(interval.value(0.0, &[0.0, 0.0, 0.5], &others), 0.6);
    }

    #[test]
    fn says_what_is_wrong() {
        let cases = [
            ("position > 1", "`position` has 2 numbers"),
            ("position[2] > 1", "expected a number from 0 to 1"),
            ("norm(position - x) > 1", "expected 2 values to subtract, found 1"),
            ("norm(speed) > 1", "expected a signal of the sender, position, x, found 'speed'"),
            ("command.force > 1", "found 'command.force'"),
            ("norm(position", "')'"),
        ];
        for (text, expected) in cases {
            let error = Trigger::condition(text, &fields(), &|_| None).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
