//! Text to tokens.

use super::tree::Relation;
use super::{Cursor, FormulaError};

/// A word of the language.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind<'a> {
    Number(f64),
    Name(&'a str),
    /// A name in backticks, which is never a function or a keyword.
    Quoted(&'a str),
    /// What stands between two quotation marks of a kind.
    Text(&'a str),
    Relation(Relation),
    /// An operator, a parenthesis or a comma.
    Symbol(char),
    /// Behind the last word.
    End,
}

/// A word and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Token<'a> {
    pub(super) kind: Kind<'a>,
    /// Byte offset of its start in the formula.
    pub(super) offset: usize,
    text: &'a str,
}

impl Token<'_> {
    /// The token as a message calls it.
    pub(super) fn describe(&self) -> String {
        match self.kind {
            Kind::End => "the end of the formula".into(),
            _ => format!("'{}'", self.text),
        }
    }
}

impl<'a> Cursor<'a> {
    /// The next token; [`Kind::End`] again and again at the end.
    ///
    /// # Errors
    /// A [`FormulaError`] for a character that no token starts with and for a malformed or infinite number.
    pub(super) fn token(&mut self) -> Result<Token<'a>, FormulaError> {
        self.skip_space();
        let offset = self.offset();
        let kind = match self.peek() {
            None => Kind::End,
            Some('0'..='9') => Kind::Number(self.number()?),
            Some(first) if first.is_alphabetic() || first == '_' => Kind::Name(self.take_name()),
            Some('`') => Kind::Quoted(self.take_quoted()?),
            Some(mark @ ('"' | '\'')) => Kind::Text(self.take_text(mark)?),
            Some('<' | '>') => Kind::Relation(self.relation()),
            Some(symbol @ ('+' | '-' | '*' | '/' | '^' | '(' | ')' | ',')) => {
                self.take(symbol);
                Kind::Symbol(symbol)
            }
            Some('=' | '!') => {
                let message = "expected <, <=, > or >=: numbers are not compared for equality; for a whole number write 2.5 < i < 3.5";
                return Err(FormulaError::new(offset, message));
            }
            Some('.') => {
                return Err(FormulaError::new(offset, "expected a digit in front of the point: write 0.5, not .5"));
            }
            Some(other) => {
                let message =
                    format!("expected a number, a name, an operator or a parenthesis, found the character {other:?}");
                return Err(FormulaError::new(offset, message));
            }
        };
        Ok(Token { kind, offset, text: self.since(offset) })
    }

    /// Steps over a text between two of these quotation marks, which are left out.
    fn take_text(&mut self, mark: char) -> Result<&'a str, FormulaError> {
        let start = self.offset();
        self.take(mark);
        let text = self.take_while(|character| character != mark);
        match self.take(mark) {
            true => Ok(text),
            false => {
                let message = format!("expected a second {mark} to end the text that this one begins");
                Err(FormulaError::new(start, message))
            }
        }
    }

    fn relation(&mut self) -> Relation {
        let is_greater = !self.take('<') && self.take('>');
        match (is_greater, self.take('=')) {
            (false, false) => Relation::Less,
            (false, true) => Relation::LessOrEqual,
            (true, false) => Relation::Greater,
            (true, true) => Relation::GreaterOrEqual,
        }
    }

    fn number(&mut self) -> Result<f64, FormulaError> {
        let offset = self.offset();
        self.digits();
        if self.take('.') && !self.digits() {
            return Err(FormulaError::new(self.offset(), "expected a digit behind the point: write 1.0, not 1."));
        }
        let mut exponent = *self;
        if exponent.take('e') || exponent.take('E') {
            let _has_sign = exponent.take('+') || exponent.take('-');
            // Without a digit the letter starts a name, and the parser says what is wrong with that.
            if exponent.digits() {
                *self = exponent;
            }
        }
        let digits = self.since(offset);
        match digits.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(FormulaError::new(offset, format!("expected a number below 1.8e308, found '{digits}'"))),
        }
    }

    /// Steps over digits; whether there were any.
    fn digits(&mut self) -> bool {
        !self.take_while(|character| character.is_ascii_digit()).is_empty()
    }
}
