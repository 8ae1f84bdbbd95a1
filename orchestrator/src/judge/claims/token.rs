//! Text of a claim to tokens.

use super::condition::Relation;

/// A claim that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mistake {
    /// Where in the text, in bytes.
    pub(super) offset: usize,
    pub(super) message: String,
}

impl Mistake {
    pub(super) fn new(offset: usize, message: impl Into<String>) -> Self {
        Self { offset, message: message.into() }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind<'a> {
    Number(f64),
    Name(&'a str),
    /// A name in backticks, which is never a function or a keyword.
    Quoted(&'a str),
    Relation(Relation),
    /// An operator, a parenthesis or a comma.
    Symbol(char),
    /// Behind the last word.
    End,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Token<'a> {
    pub(super) kind: Kind<'a>,
    /// Bytes of its start and end.
    pub(super) start: usize,
    pub(super) end: usize,
    text: &'a str,
}

impl Token<'_> {
    /// The token as a message calls it.
    pub(super) fn describe(&self) -> String {
        match self.kind {
            Kind::End => "the end of the claim".into(),
            _ => format!("'{}'", self.text),
        }
    }
}

/// Cuts a claim into tokens, one at a time.
#[derive(Debug)]
pub(super) struct Tokens<'a> {
    text: &'a str,
    position: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, position: 0 }
    }

    /// The next token; the end again and again.
    pub(super) fn next(&mut self) -> Result<Token<'a>, Mistake> {
        self.skip(char::is_whitespace);
        let start = self.position;
        let kind = match self.peek() {
            None => Kind::End,
            Some(first) if first.is_ascii_digit() => Kind::Number(self.number()?),
            Some(first) if first.is_alphabetic() || first == '_' => {
                self.skip(|c| c.is_alphanumeric() || c == '_');
                Kind::Name(&self.text[start..self.position])
            }
            Some('`') => Kind::Quoted(self.quoted()?),
            Some('<' | '>') => Kind::Relation(self.relation()),
            Some(symbol @ ('+' | '-' | '*' | '/' | '(' | ')' | ',')) => {
                self.position += 1;
                Kind::Symbol(symbol)
            }
            Some('=' | '!') => {
                return Err(Mistake::new(start, "expected <, <=, > or >=: numbers are not compared for equality"));
            }
            Some(other) => {
                let message =
                    format!("expected a metric, a number, an operator or a parenthesis, found the character {other:?}");
                return Err(Mistake::new(start, message));
            }
        };
        Ok(Token { kind, start, end: self.position, text: &self.text[start..self.position] })
    }

    /// The name of a variant behind the parenthesis that was read last, up to and without the closing one.
    ///
    /// Names of variants contain hyphens and points, so they are no tokens.
    pub(super) fn variant(&mut self) -> Result<(usize, &'a str), Mistake> {
        self.skip(char::is_whitespace);
        let start = self.position;
        if self.peek() == Some('`') {
            return Ok((start, self.quoted()?));
        }
        self.skip(|c| !matches!(c, '(' | ')' | '`' | ',' | '<' | '>'));
        let name = self.text[start..self.position].trim_end();
        if name.is_empty() {
            return Err(Mistake::new(start, "expected the name of a variant, as in dx(HFC)"));
        }
        Ok((start, name))
    }

    /// The text between two places, as it was written.
    pub(super) fn text(&self, start: usize, end: usize) -> &'a str {
        &self.text[start..end]
    }

    fn quoted(&mut self) -> Result<&'a str, Mistake> {
        let start = self.position;
        let inner = &self.text[start + 1..];
        match inner.find('`') {
            Some(0) => Err(Mistake::new(start, "expected a name between the backticks, found none")),
            Some(length) => {
                self.position = start + length + 2;
                Ok(&inner[..length])
            }
            None => Err(Mistake::new(start, "expected a second backtick to end the name that this one begins")),
        }
    }

    fn relation(&mut self) -> Relation {
        let greater = self.peek() == Some('>');
        self.position += 1;
        let or_equal = self.peek() == Some('=');
        self.position += usize::from(or_equal);
        match (greater, or_equal) {
            (false, false) => Relation::Less,
            (false, true) => Relation::LessOrEqual,
            (true, false) => Relation::Greater,
            (true, true) => Relation::GreaterOrEqual,
        }
    }

    fn number(&mut self) -> Result<f64, Mistake> {
        let start = self.position;
        let digit = |c: char| c.is_ascii_digit();
        self.skip(digit);
        if self.peek() == Some('.') {
            self.position += 1;
            self.skip(digit);
        }
        let rest = &self.text.as_bytes()[self.position..];
        if matches!(rest.first(), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(rest.get(1), Some(b'+' | b'-')));
            if rest.get(1 + sign).is_some_and(u8::is_ascii_digit) {
                self.position += 1 + sign;
                self.skip(digit);
            }
        }
        let digits = &self.text[start..self.position];
        match digits.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(Mistake::new(start, format!("expected a finite number, found '{digits}'"))),
        }
    }

    fn peek(&self) -> Option<char> {
        self.text[self.position..].chars().next()
    }

    fn skip(&mut self, belongs: impl Fn(char) -> bool) {
        while let Some(c) = self.peek().filter(|c| belongs(*c)) {
            self.position += c.len_utf8();
        }
    }
}
