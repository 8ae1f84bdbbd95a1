//! Conditions: comparisons of numbers, `and`, `or`, `not`, and numbers that they choose.

use std::ops::Range;

use super::super::FormulaError;
use super::super::function::{Binary, MOST_OPERATIONS, Term, Unary};
use super::super::token::Kind;
use super::super::tree::Tree;
use super::{Parser, Rule, Side, Start, Value};

/// A condition whose sides have been taken out of a text again, to be put into a number.
struct Truth<'t> {
    /// Where it starts in the text.
    offset: usize,
    terms: &'t [(usize, Term)],
    sides: &'t [Side],
    /// Index of the first of its sides, and of the first of its terms, when they were read.
    first_side: usize,
    first_term: usize,
}

impl Truth<'_> {
    /// The terms of a side.
    fn side(&self, side: usize) -> &[(usize, Term)] {
        let Range { start, end } = self.sides[side - self.first_side].terms;
        &self.terms[start - self.first_term..end - self.first_term]
    }
}

impl<'a, 'o> Parser<'a, 'o> {
    pub(super) fn either(&mut self) -> Result<Value, FormulaError> {
        self.combination("or", Self::both, Tree::Or)
    }

    fn both(&mut self) -> Result<Value, FormulaError> {
        self.combination("and", Self::negation, Tree::And)
    }

    fn negation(&mut self) -> Result<Value, FormulaError> {
        if self.token.kind != Kind::Name("not") {
            return self.comparison();
        }
        self.advance()?;
        let start = self.token.offset;
        let denied = self.nested(Self::negation)?.condition(start)?;
        Ok(Value::Condition(denied.negated()))
    }

    fn combination(
        &mut self,
        keyword: &str,
        part: Rule<'a, 'o>,
        combine: fn(Box<Tree>, Box<Tree>) -> Tree,
    ) -> Result<Value, FormulaError> {
        let start = self.token.offset;
        let mut all = part(self)?;
        while self.token.kind == Kind::Name(keyword) {
            let first = all.condition(start)?;
            self.advance()?;
            let start = self.token.offset;
            all = Value::Condition(combine(first, part(self)?.condition(start)?));
        }
        Ok(all)
    }

    /// `a < b`, or several in a row, each of which has to hold.
    fn comparison(&mut self) -> Result<Value, FormulaError> {
        let start = self.start();
        let first = self.sum()?;
        if !matches!(self.token.kind, Kind::Relation(_)) {
            return Ok(first);
        }
        first.number(start.offset)?;
        let mut left = self.side(start);
        let mut all = None;
        while let Kind::Relation(relation) = self.token.kind {
            self.advance()?;
            let start = self.start();
            self.number(Self::sum)?;
            let right = self.side(start);
            let next = Tree::Compare(left, relation, right);
            all = Some(match all {
                None => next,
                Some(all) => Tree::And(Box::new(all), Box::new(next)),
            });
            left = right;
        }
        Ok(all.map_or(Value::Number, Value::Condition))
    }

    pub(super) fn not_finite(&mut self) -> Result<Value, FormulaError> {
        self.advance()?;
        let parenthesis = self.open("not_finite")?;
        let start = self.start();
        self.nested(|parser| parser.number(Self::sum))?;
        let side = self.side(start);
        self.close(parenthesis, "an operator or ')'")?;
        Ok(Value::Condition(Tree::NotFinite(side)))
    }

    /// `if(condition, a, b)`.
    pub(super) fn choice(&mut self) -> Result<Value, FormulaError> {
        let token = self.advance()?;
        let parenthesis = self.open("if")?;
        let (start, first) = (self.start(), self.parsed.sides.len());
        let condition = self.nested(Self::either)?.condition(start.offset)?;
        let terms = self.parsed.terms.split_off(start.term);
        let sides = self.parsed.sides.split_off(first);
        let truth =
            Truth { offset: start.offset, terms: &terms, sides: &sides, first_side: first, first_term: start.term };
        self.truth(&condition, &truth)?;
        let mut found = 1;
        while self.token.kind == Kind::Symbol(',') {
            self.advance()?;
            self.nested(|parser| parser.number(Self::sum))?;
            found += 1;
        }
        self.close(parenthesis, "an operator, ',' or ')'")?;
        if found != 3 {
            let message = format!("expected 3 arguments of the function 'if', found {found}");
            return Err(FormulaError::new(token.offset, message));
        }
        self.emit(token.offset, Term::Select);
        Ok(Value::Number)
    }

    /// Emits terms that make 1 of a condition that holds, else 0.
    fn truth(&mut self, tree: &Tree, of: &Truth) -> Result<(), FormulaError> {
        let term = match tree {
            Tree::Compare(left, relation, right) => {
                self.repeat(*left, of)?;
                self.repeat(*right, of)?;
                Term::Binary(Binary::Compare(*relation))
            }
            Tree::Finite(side) => {
                self.repeat(*side, of)?;
                Term::Unary(Unary::Finite)
            }
            Tree::NotFinite(side) => {
                self.repeat(*side, of)?;
                Term::Unary(Unary::NotFinite)
            }
            Tree::And(first, second) => {
                self.truth(first, of)?;
                self.truth(second, of)?;
                Term::Binary(Binary::And)
            }
            Tree::Or(first, second) => {
                self.truth(first, of)?;
                self.truth(second, of)?;
                Term::Binary(Binary::Or)
            }
        };
        self.emit(of.offset, term);
        Ok(())
    }

    /// Emits the terms of a side. One between two relations is emitted twice, so nested ones could multiply without bound.
    fn repeat(&mut self, side: usize, of: &Truth) -> Result<(), FormulaError> {
        self.parsed.terms.extend_from_slice(of.side(side));
        if self.parsed.terms.len() > MOST_OPERATIONS {
            let message = format!("expected at most {MOST_OPERATIONS} operations, found more");
            return Err(FormulaError::new(of.offset, message));
        }
        Ok(())
    }

    /// Notes the number that was read last, and returns its index.
    fn side(&mut self, start: Start) -> usize {
        let terms = start.term..self.parsed.terms.len();
        self.parsed.sides.push(Side { text: start.offset..self.end, terms });
        self.parsed.sides.len() - 1
    }
}
