//! Tokens to postfix terms, by recursive descent.

use super::FormulaError;
use super::function::{Binary, Function, Unary};
use super::token::{Kind, Token, Tokens};

/// Longest formula in bytes.
const LONGEST: usize = 4096;

/// Deepest nesting of parentheses, calls, signs and exponents. Bounds the recursion of the parser.
const DEEPEST: usize = 64;

/// An operand, or an operation on the operands before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Term {
    Number(f64),
    /// Index into [`Parsed::names`].
    Name(usize),
    Apply(Function),
}

/// A free name of a formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Name {
    pub(super) text: String,
    /// Byte offset of its first appearance.
    pub(super) offset: usize,
}

/// A formula in postfix order: each operation follows its operands, and one value remains at the end.
#[derive(Clone, Debug, Default)]
pub(super) struct Parsed {
    /// Terms, each with its byte offset in the text.
    pub(super) terms: Vec<(usize, Term)>,
    /// Free names in order of first appearance.
    pub(super) names: Vec<Name>,
}

/// Parses a whole formula.
///
/// # Errors
/// A [`FormulaError`] at the first token that does not fit, or if the formula is too long or too deeply nested.
pub(super) fn parse(text: &str) -> Result<Parsed, FormulaError> {
    if text.len() > LONGEST {
        let message = format!("expected a formula of at most {LONGEST} bytes, found one of {}", text.len());
        return Err(FormulaError::new(0, message));
    }
    let mut tokens = Tokens::new(text);
    let token = tokens.next()?;
    if token.kind == Kind::End {
        return Err(FormulaError::new(0, "expected a formula, found an empty text"));
    }
    let mut parser = Parser { tokens, token, depth: 0, parsed: Parsed::default() };
    parser.sum()?;
    match parser.token.kind {
        Kind::End => Ok(parser.parsed),
        _ => Err(parser.unexpected("an operator or the end of the formula")),
    }
}

struct Parser<'a> {
    tokens: Tokens<'a>,
    /// The token that is to be consumed next.
    token: Token<'a>,
    depth: usize,
    parsed: Parsed,
}

impl<'a> Parser<'a> {
    fn sum(&mut self) -> Result<(), FormulaError> {
        self.chain(Self::product, |symbol| match symbol {
            '+' => Some(Binary::Add),
            '-' => Some(Binary::Subtract),
            _ => None,
        })
    }

    fn product(&mut self) -> Result<(), FormulaError> {
        self.chain(Self::signed, |symbol| match symbol {
            '*' => Some(Binary::Multiply),
            '/' => Some(Binary::Divide),
            _ => None,
        })
    }

    /// Operands joined by operators of one precedence, from left to right.
    fn chain(
        &mut self,
        operand: impl Fn(&mut Self) -> Result<(), FormulaError>,
        operator: impl Fn(char) -> Option<Binary>,
    ) -> Result<(), FormulaError> {
        operand(self)?;
        while let Kind::Symbol(symbol) = self.token.kind
            && let Some(binary) = operator(symbol)
        {
            let offset = self.advance()?.offset;
            operand(self)?;
            self.emit(offset, Term::Apply(Function::Binary(binary)));
        }
        Ok(())
    }

    fn signed(&mut self) -> Result<(), FormulaError> {
        if self.token.kind != Kind::Symbol('-') {
            return self.power();
        }
        let offset = self.advance()?.offset;
        self.nested(Self::signed)?;
        self.emit(offset, Term::Apply(Function::Unary(Unary::Negate)));
        Ok(())
    }

    fn power(&mut self) -> Result<(), FormulaError> {
        self.primary()?;
        if self.token.kind == Kind::Symbol('^') {
            let offset = self.advance()?.offset;
            // The exponent may have a sign and, by the recursion, a power of its own: 2^-3^2 = 2^(-(3^2)).
            self.nested(Self::signed)?;
            self.emit(offset, Term::Apply(Function::Binary(Binary::Power)));
        }
        Ok(())
    }

    fn primary(&mut self) -> Result<(), FormulaError> {
        let token = self.token;
        match token.kind {
            Kind::Number(value) => {
                self.advance()?;
                self.emit(token.offset, Term::Number(value));
                Ok(())
            }
            Kind::Name(name) => {
                self.advance()?;
                if self.token.kind == Kind::Symbol('(') { self.call(token, name) } else { self.name(token, name) }
            }
            Kind::Symbol('(') => {
                self.advance()?;
                self.nested(Self::sum)?;
                self.close(token, "an operator or ')'")
            }
            _ => Err(self.unexpected("a number, a name or '('")),
        }
    }

    fn name(&mut self, token: Token<'a>, name: &str) -> Result<(), FormulaError> {
        if name == "pi" {
            self.emit(token.offset, Term::Number(std::f64::consts::PI));
            return Ok(());
        }
        if Function::named(name).is_some() {
            let message = format!("expected '(' behind the function '{name}', found {}", self.token.describe());
            return Err(FormulaError::new(self.token.offset, message));
        }
        let names = &mut self.parsed.names;
        let index = names.iter().position(|known| known.text == name).unwrap_or_else(|| {
            names.push(Name { text: name.into(), offset: token.offset });
            names.len() - 1
        });
        self.emit(token.offset, Term::Name(index));
        Ok(())
    }

    fn call(&mut self, token: Token<'a>, name: &str) -> Result<(), FormulaError> {
        let Some(function) = Function::named(name) else {
            let message = format!(
                "expected one of the functions {}, found '{name}('; a product is written with '*'",
                Function::names()
            );
            return Err(FormulaError::new(token.offset, message));
        };
        let parenthesis = self.advance()?;
        self.nested(Self::sum)?;
        let mut found = 1;
        while self.token.kind == Kind::Symbol(',') {
            self.advance()?;
            self.nested(Self::sum)?;
            found += 1;
        }
        self.close(parenthesis, "an operator, ',' or ')'")?;
        let expected = function.arguments();
        if found != expected {
            let plural = if expected == 1 { "" } else { "s" };
            let message = format!("expected {expected} argument{plural} of the function '{name}', found {found}");
            return Err(FormulaError::new(token.offset, message));
        }
        self.emit(token.offset, Term::Apply(function));
        Ok(())
    }

    fn close(&mut self, parenthesis: Token<'a>, expected: &str) -> Result<(), FormulaError> {
        if self.token.kind == Kind::Symbol(')') {
            return self.advance().map(|_| ());
        }
        let column = parenthesis.offset + 1;
        Err(self.unexpected(&format!("{expected} to end what the '(' in column {column} begins")))
    }

    fn nested(&mut self, inner: impl Fn(&mut Self) -> Result<(), FormulaError>) -> Result<(), FormulaError> {
        if self.depth == DEEPEST {
            let message = format!(
                "expected at most {DEEPEST} parentheses, calls, signs and exponents within each other, found more"
            );
            return Err(FormulaError::new(self.token.offset, message));
        }
        self.depth += 1;
        inner(self)?;
        self.depth -= 1;
        Ok(())
    }

    /// Steps to the next token and returns the one that was the current.
    fn advance(&mut self) -> Result<Token<'a>, FormulaError> {
        Ok(std::mem::replace(&mut self.token, self.tokens.next()?))
    }

    fn emit(&mut self, offset: usize, term: Term) {
        self.parsed.terms.push((offset, term));
    }

    fn unexpected(&self, expected: &str) -> FormulaError {
        let hint = match self.token.kind {
            Kind::Number(_) | Kind::Name(_) | Kind::Symbol('(') => "; a product is written with '*'",
            _ => "",
        };
        FormulaError::new(self.token.offset, format!("expected {expected}, found {}{hint}", self.token.describe()))
    }
}
