//! Conditions: comparisons of numbers, `and`, `or`.

use super::super::FormulaError;
use super::super::token::Kind;
use super::super::tree::Tree;
use super::{Parser, Rule, Side, Start, Value};

impl<'a, 'o> Parser<'a, 'o> {
    pub(super) fn either(&mut self) -> Result<Value, FormulaError> {
        self.combination("or", Self::both, Tree::Or)
    }

    fn both(&mut self) -> Result<Value, FormulaError> {
        self.combination("and", Self::comparison, Tree::And)
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

    /// Notes the number that was read last, and returns its index.
    fn side(&mut self, start: Start) -> usize {
        let terms = start.term..self.parsed.terms.len();
        self.parsed.sides.push(Side { text: start.offset..self.end, terms });
        self.parsed.sides.len() - 1
    }
}
