//! Numbers: sums, products, powers, calls and operands.

use super::super::FormulaError;
use super::super::function::{Binary, Function, Term, Unary};
use super::super::token::Kind;
use super::{Name, Parser, Rule, Value};
use crate::text::did_you_mean;

impl<'a, 'o> Parser<'a, 'o> {
    pub(super) fn sum(&mut self) -> Result<Value, FormulaError> {
        self.chain(Self::product, |symbol| match symbol {
            '+' => Some(Binary::Add),
            '-' => Some(Binary::Subtract),
            _ => None,
        })
    }

    fn product(&mut self) -> Result<Value, FormulaError> {
        self.chain(Self::signed, |symbol| match symbol {
            '*' => Some(Binary::Multiply),
            '/' => Some(Binary::Divide),
            _ => None,
        })
    }

    /// Operands joined by operators of one precedence, from left to right.
    fn chain(&mut self, operand: Rule<'a, 'o>, operator: fn(char) -> Option<Binary>) -> Result<Value, FormulaError> {
        let start = self.token.offset;
        let first = operand(self)?;
        while let Kind::Symbol(symbol) = self.token.kind
            && let Some(binary) = operator(symbol)
        {
            first.number(start)?;
            let offset = self.advance()?.offset;
            self.number(operand)?;
            self.emit(offset, Term::Binary(binary));
        }
        Ok(first)
    }

    fn signed(&mut self) -> Result<Value, FormulaError> {
        if self.token.kind != Kind::Symbol('-') {
            return self.power();
        }
        let offset = self.advance()?.offset;
        self.nested(|parser| parser.number(Self::signed))?;
        self.emit(offset, Term::Unary(Unary::Negate));
        Ok(Value::Number)
    }

    fn power(&mut self) -> Result<Value, FormulaError> {
        let start = self.token.offset;
        let base = self.primary()?;
        if self.token.kind == Kind::Symbol('^') {
            base.number(start)?;
            let offset = self.advance()?.offset;
            // The exponent may have a sign and, by the recursion, a power of its own: 2^-3^2 = 2^(-(3^2)).
            self.nested(|parser| parser.number(Self::signed))?;
            self.emit(offset, Term::Binary(Binary::Power));
        }
        Ok(base)
    }

    fn primary(&mut self) -> Result<Value, FormulaError> {
        let token = self.token;
        match token.kind {
            Kind::Number(value) => {
                self.advance()?;
                self.emit(token.offset, Term::Number(value));
                Ok(Value::Number)
            }
            Kind::Name("and" | "or" | "not") => Err(self.unexpected("a number, a name or '('")),
            Kind::Name("not_finite") => self.not_finite(),
            Kind::Name("if") => self.choice(),
            Kind::Name("table") => self.table(),
            Kind::Name("trajectory") => self.trajectory(),
            Kind::Name(name) => match Function::named(name) {
                Some(function) => self.call(name, function),
                None => self.operand(name),
            },
            Kind::Quoted(name) => self.operand(name),
            Kind::Symbol('(') => {
                self.advance()?;
                let inner = self.nested(Self::either)?;
                self.close(token, "an operator or ')'")?;
                Ok(inner)
            }
            _ => Err(self.unexpected("a number, a name or '('")),
        }
    }

    /// An operand of the caller, `pi`, or a free name.
    fn operand(&mut self, name: &str) -> Result<Value, FormulaError> {
        let token = self.token;
        let mut cursor = self.cursor;
        if let Some(slot) = self.operands.read(name, token.offset, &mut cursor)? {
            self.cursor = cursor;
            self.advance()?;
            self.emit(token.offset, Term::Slot(slot));
            return Ok(Value::Number);
        }
        self.advance()?;
        if self.token.kind == Kind::Symbol('(') {
            let functions = Function::names().collect::<Vec<_>>().join(", ");
            let hint = did_you_mean(name, Function::names());
            let message = format!(
                "expected one of the functions {functions}, found '{name}('{hint}; a product is written with '*'"
            );
            return Err(FormulaError::new(token.offset, message));
        }
        if token.kind == Kind::Name("pi") {
            self.emit(token.offset, Term::Number(std::f64::consts::PI));
            return Ok(Value::Number);
        }
        let names = &mut self.parsed.names;
        let index = names.iter().position(|known| known.text == name).unwrap_or_else(|| {
            names.push(Name { text: name.into(), offset: token.offset });
            names.len() - 1
        });
        self.emit(token.offset, Term::Name(index));
        Ok(Value::Number)
    }

    fn call(&mut self, name: &str, function: Function) -> Result<Value, FormulaError> {
        let token = self.advance()?;
        let parenthesis = self.open(name)?;
        let mut found = 0;
        loop {
            self.nested(|parser| parser.number(Self::sum))?;
            found += 1;
            for term in function.behind(found) {
                self.emit(token.offset, term);
            }
            if self.token.kind != Kind::Symbol(',') {
                break;
            }
            self.advance()?;
        }
        self.close(parenthesis, "an operator, ',' or ')'")?;
        match function.arguments() {
            Some(expected) if found != expected => {
                let plural = if expected == 1 { "" } else { "s" };
                let message = format!("expected {expected} argument{plural} of the function '{name}', found {found}");
                Err(FormulaError::new(token.offset, message))
            }
            _ => Ok(Value::Number),
        }
    }
}
