//! Tokens to postfix terms and to the tree of a condition, by recursive descent.

mod conditions;
mod data;
mod numbers;

use std::ops::Range;
use std::sync::Arc;

use super::function::Term;
use super::token::{Kind, Token};
use super::tree::Tree;
use super::{Cursor, Curve, FormulaError, Operands};

/// Longest formula in bytes.
const LONGEST: usize = 4096;

/// Deepest nesting of parentheses, calls, signs and exponents. Bounds the recursion of the parser.
const DEEPEST: usize = 64;

/// A free name of a formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Name {
    pub(super) text: String,
    /// Byte offset of its first appearance.
    pub(super) offset: usize,
}

/// A number of the text.
#[derive(Clone, Debug)]
pub(super) struct Side {
    /// Its bytes in the text.
    pub(super) text: Range<usize>,
    /// Its part of [`Parsed::terms`].
    pub(super) terms: Range<usize>,
}

/// What a text comes to.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// The number that all terms together are.
    Number,
    /// A condition on [`Parsed::sides`].
    Condition(Tree),
}

/// A text in postfix order: each operation follows its operands, and one value remains at the end of each number.
#[derive(Clone, Debug)]
pub(super) struct Parsed {
    /// Terms, each with its byte offset in the text.
    pub(super) terms: Vec<(usize, Term)>,
    /// Free names in order of first appearance.
    pub(super) names: Vec<Name>,
    /// The curves through data.
    pub(super) curves: Vec<Arc<Curve>>,
    /// The numbers that are compared.
    pub(super) sides: Vec<Side>,
    pub(super) value: Value,
}

/// Parses a whole text.
///
/// # Errors
/// A [`FormulaError`] at the first token that does not fit, or if the text is too long or too deeply nested.
pub(super) fn parse(text: &str, operands: &mut dyn Operands) -> Result<Parsed, FormulaError> {
    if text.len() > LONGEST {
        let message = format!("expected a formula of at most {LONGEST} bytes, found one of {}", text.len());
        return Err(FormulaError::new(0, message));
    }
    let mut cursor = Cursor::new(text);
    let token = cursor.token()?;
    if token.kind == Kind::End {
        return Err(FormulaError::new(0, "expected a formula, found an empty text"));
    }
    let (terms, names, curves, sides) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let parsed = Parsed { terms, names, curves, sides, value: Value::Number };
    let mut parser = Parser { operands, cursor, token, end: 0, depth: 0, parsed };
    let value = parser.either()?;
    match parser.token.kind {
        Kind::End => Ok(Parsed { value, ..parser.parsed }),
        _ => Err(parser.unexpected("an operator or the end of the formula")),
    }
}

impl Value {
    /// # Errors
    /// A [`FormulaError`] at `offset`, where it starts, if it is a condition.
    pub(super) fn number(&self, offset: usize) -> Result<(), FormulaError> {
        match self {
            Value::Number => Ok(()),
            Value::Condition(_) => {
                let message =
                    "expected a number, found a comparison, which holds or does not; if(a < b, 1, 0) is a number";
                Err(FormulaError::new(offset, message))
            }
        }
    }

    /// # Errors
    /// A [`FormulaError`] at `offset`, where it starts, if it is a number.
    pub(super) fn condition(self, offset: usize) -> Result<Box<Tree>, FormulaError> {
        match self {
            Value::Condition(tree) => Ok(Box::new(tree)),
            Value::Number => Err(FormulaError::new(offset, "expected a comparison such as a < b, found just a number")),
        }
    }
}

struct Parser<'a, 'o> {
    operands: &'o mut dyn Operands,
    /// Behind the token.
    cursor: Cursor<'a>,
    /// The token that is to be consumed next.
    token: Token<'a>,
    /// Where the token before it ended.
    end: usize,
    depth: usize,
    parsed: Parsed,
}

/// Parentheses stand around numbers and around conditions, so every rule may come to either.
type Rule<'a, 'o> = fn(&mut Parser<'a, 'o>) -> Result<Value, FormulaError>;

/// Where something starts.
#[derive(Clone, Copy)]
struct Start {
    offset: usize,
    term: usize,
}

impl<'a, 'o> Parser<'a, 'o> {
    fn start(&self) -> Start {
        Start { offset: self.token.offset, term: self.parsed.terms.len() }
    }

    /// What a rule comes to, if that is a number.
    fn number(&mut self, rule: Rule<'a, 'o>) -> Result<(), FormulaError> {
        let start = self.token.offset;
        rule(self)?.number(start)
    }

    fn open(&mut self, function: &str) -> Result<Token<'a>, FormulaError> {
        if self.token.kind == Kind::Symbol('(') {
            return self.advance();
        }
        let message = format!("expected '(' behind the function '{function}', found {}", self.token.describe());
        Err(FormulaError::new(self.token.offset, message))
    }

    fn close(&mut self, parenthesis: Token<'a>, expected: &str) -> Result<(), FormulaError> {
        if self.token.kind == Kind::Symbol(')') {
            return self.advance().map(|_| ());
        }
        let column = self.cursor.column(parenthesis.offset);
        Err(self.unexpected(&format!("{expected} to end what the '(' in column {column} begins")))
    }

    fn nested<T>(&mut self, inner: impl Fn(&mut Self) -> Result<T, FormulaError>) -> Result<T, FormulaError> {
        if self.depth == DEEPEST {
            let message = format!(
                "expected at most {DEEPEST} parentheses, calls, signs and exponents within each other, found more"
            );
            return Err(FormulaError::new(self.token.offset, message));
        }
        self.depth += 1;
        let result = inner(self)?;
        self.depth -= 1;
        Ok(result)
    }

    /// Steps to the next token and returns the one that was the current.
    fn advance(&mut self) -> Result<Token<'a>, FormulaError> {
        self.end = self.cursor.offset();
        Ok(std::mem::replace(&mut self.token, self.cursor.token()?))
    }

    fn emit(&mut self, offset: usize, term: Term) {
        self.parsed.terms.push((offset, term));
    }

    fn unexpected(&self, expected: &str) -> FormulaError {
        let hint = match self.token.kind {
            Kind::Name("and" | "or" | "not") => "",
            Kind::Number(_) | Kind::Name(_) | Kind::Symbol('(') => "; a product is written with '*'",
            _ => "",
        };
        FormulaError::new(self.token.offset, format!("expected {expected}, found {}{hint}", self.token.describe()))
    }
}
