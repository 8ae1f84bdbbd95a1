//! Operands that a caller adds to the language.

use std::sync::Arc;

use super::error::{FormulaError, column};
use super::{Curve, DataCall, DataError};

/// Operands of a caller that are more than a name, such as `state.position[0]` or `dx(HFC)`. `()` adds none.
///
/// ```
/// use formation::formula::{Cursor, Expression, FormulaError, Operands};
///
/// /// `x[0]`, `x[1]`, ...: the slots by their number.
/// struct Slots;
///
/// impl Operands for Slots {
///     fn read(&mut self, name: &str, start: usize, text: &mut Cursor) -> Result<Option<usize>, FormulaError> {
///         if name != "x" || !text.take('[') {
///             return Ok(None);
///         }
///         let place = text.offset();
///         let index = text.take_while(|c| c != ']');
///         if !text.take(']') {
///             return Err(text.unexpected("']'"));
///         }
///         index.parse().map(Some).map_err(|_| FormulaError::new(start, "expected the number of a slot"))
///     }
/// }
///
/// let formula = Expression::parse_with("2*x[1]^2 + 1", &mut Slots)?.compile(|_| None)?;
/// assert_eq!(formula.evaluate(&[0.0, 3.0]), 19.0);
/// # Ok::<(), FormulaError>(())
/// ```
pub trait Operands {
    /// Reads the rest of the operand that begins with `name` at byte `start`, from the text behind the name: the slot that holds
    /// its value, or `None` if it is a mere name.
    ///
    /// # Errors
    /// A [`FormulaError`] if the operand is malformed or unknown.
    fn read(&mut self, name: &str, start: usize, text: &mut Cursor) -> Result<Option<usize>, FormulaError>;

    /// The curve through a data file that a call asks for. Without a definition of one's own, there are no data files.
    ///
    /// # Errors
    /// Says why there is no such curve.
    fn curve(&mut self, _: &DataCall) -> Result<Arc<Curve>, DataError> {
        let message = "there are no data files here: formulas of references, disturbances, vehicles and laws read them";
        Err(DataError::File(message.into()))
    }
}

impl Operands for () {
    fn read(&mut self, _: &str, _: usize, _: &mut Cursor) -> Result<Option<usize>, FormulaError> {
        Ok(None)
    }
}

/// A place in the text of a formula.
#[derive(Clone, Copy, Debug)]
pub struct Cursor<'a> {
    text: &'a str,
    offset: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, offset: 0 }
    }

    /// The byte at which it stands.
    pub fn offset(&self) -> usize {
        self.offset
    }

    /// The next character.
    pub fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// Steps over white space.
    pub fn skip_space(&mut self) {
        self.take_while(char::is_whitespace);
    }

    /// Steps over the character, if it is the next one.
    pub fn take(&mut self, wanted: char) -> bool {
        let is_next = self.peek() == Some(wanted);
        self.offset += if is_next { wanted.len_utf8() } else { 0 };
        is_next
    }

    /// Steps over all characters that belong to something, and returns them.
    pub fn take_while(&mut self, belongs: impl Fn(char) -> bool) -> &'a str {
        let rest = self.rest();
        let length = rest.find(|character| !belongs(character)).unwrap_or(rest.len());
        self.offset += length;
        &rest[..length]
    }

    /// Steps over a name: letters, digits and `_`.
    pub fn take_name(&mut self) -> &'a str {
        self.take_while(|character| character.is_alphanumeric() || character == '_')
    }

    /// Steps over a name in backticks, which is the next thing in the text.
    ///
    /// # Errors
    /// A [`FormulaError`] if it is empty or has no end.
    pub fn take_quoted(&mut self) -> Result<&'a str, FormulaError> {
        let start = self.offset;
        self.take('`');
        let name = self.take_while(|character| character != '`');
        if !self.take('`') {
            let message = "expected a second backtick to end the name that this one begins";
            return Err(FormulaError::new(start, message));
        }
        if name.is_empty() {
            return Err(FormulaError::new(start, "expected a name between the backticks, found none"));
        }
        Ok(name)
    }

    /// Steps over an index in brackets, `[2]`, which is the next thing in the text, of a vector with so many numbers.
    ///
    /// # Errors
    /// A [`FormulaError`] if there is no such number, or the bracket has no end.
    pub fn take_index(&mut self, length: usize) -> Result<usize, FormulaError> {
        self.take('[');
        let place = self.offset();
        let digits = self.take_while(|character| character != ']');
        let index = digits.trim().parse::<usize>().ok().filter(|index| *index < length);
        if !self.take(']') {
            return Err(self.unexpected("']'"));
        }
        index.ok_or_else(|| {
            FormulaError::new(place, format!("expected a number from 0 to {}, found '{digits}'", length - 1))
        })
    }

    /// That something else was expected here.
    pub fn unexpected(&self, expected: &str) -> FormulaError {
        let found = self.peek().map_or_else(|| "the end of the formula".into(), |next| format!("'{next}'"));
        FormulaError::new(self.offset, format!("expected {expected}, found {found}"))
    }

    /// What was written from byte `start` up to the cursor.
    pub(super) fn since(&self, start: usize) -> &'a str {
        &self.text[start..self.offset]
    }

    /// The column of a byte, as editors count it.
    pub(super) fn column(&self, offset: usize) -> usize {
        column(self.text, offset)
    }

    fn rest(&self) -> &'a str {
        &self.text[self.offset..]
    }
}
