//! Text to tokens.

use super::FormulaError;

/// A word of the language.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind<'a> {
    Number(f64),
    Name(&'a str),
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

/// Cuts a formula into tokens, one at a time.
#[derive(Debug)]
pub(super) struct Tokens<'a> {
    text: &'a str,
    position: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, position: 0 }
    }

    /// The next token; [`Kind::End`] again and again at the end.
    ///
    /// # Errors
    /// A [`FormulaError`] for a character that no token starts with and for a malformed or infinite number.
    pub(super) fn next(&mut self) -> Result<Token<'a>, FormulaError> {
        self.skip(|byte| byte.is_ascii_whitespace());
        let offset = self.position;
        let kind = match self.text[offset..].chars().next() {
            None => Kind::End,
            Some('0'..='9') => Kind::Number(self.number(offset)?),
            Some('a'..='z' | 'A'..='Z' | '_') => {
                self.skip(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
                Kind::Name(&self.text[offset..self.position])
            }
            Some(symbol @ ('+' | '-' | '*' | '/' | '^' | '(' | ')' | ',')) => {
                self.position += 1;
                Kind::Symbol(symbol)
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
        Ok(Token { kind, offset, text: &self.text[offset..self.position] })
    }

    fn number(&mut self, offset: usize) -> Result<f64, FormulaError> {
        self.digits();
        if self.peek(0) == Some(b'.') {
            self.position += 1;
            if !self.digits() {
                return Err(FormulaError::new(self.position, "expected a digit behind the point: write 1.0, not 1."));
            }
        }
        if matches!(self.peek(0), Some(b'e' | b'E')) {
            // Without a digit the letter starts a name, and the parser says what is wrong with that.
            let sign = usize::from(matches!(self.peek(1), Some(b'+' | b'-')));
            if self.peek(1 + sign).is_some_and(|byte| byte.is_ascii_digit()) {
                self.position += 1 + sign;
                self.digits();
            }
        }
        let digits = &self.text[offset..self.position];
        match digits.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(FormulaError::new(offset, format!("expected a number below 1.8e308, found '{digits}'"))),
        }
    }

    /// Skips digits; whether there were any.
    fn digits(&mut self) -> bool {
        let start = self.position;
        self.skip(|byte| byte.is_ascii_digit());
        self.position > start
    }

    fn skip(&mut self, belongs: impl Fn(u8) -> bool) {
        while self.peek(0).is_some_and(&belongs) {
            self.position += 1;
        }
    }

    fn peek(&self, ahead: usize) -> Option<u8> {
        self.text.as_bytes().get(self.position + ahead).copied()
    }
}
