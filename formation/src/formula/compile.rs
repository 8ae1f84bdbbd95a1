//! Postfix terms to code: names bound, constants folded, the depth of the value stack bounded.

use std::sync::Arc;

use super::evaluate::{Operation, STACK};
use super::function::{Binary, MOST_OPERATIONS, Term, Unary};
use super::parse::Name;
use super::real::Real;
use super::{Curve, Formula, FormulaError};

/// What a free name stands for.
#[derive(Clone, Debug)]
pub enum Operand {
    /// A number, folded into the code.
    Constant(f64),
    /// The value at this index of the slots that the formula will be evaluated on.
    Slot(usize),
    /// A formula over the same slots, put in place of the name: a named sub-expression.
    Formula(Formula),
}

/// Asks for the meaning of every name once.
///
/// # Errors
/// A [`FormulaError`] at the first one for which `resolve` returns `None`.
pub(super) fn bind(
    names: &[Name],
    mut resolve: impl FnMut(&str) -> Option<Operand>,
) -> Result<Vec<Operand>, FormulaError> {
    let unknown = |name: &Name| FormulaError::new(name.offset, format!("expected a known name, found '{}'", name.text));
    names.iter().map(|name| resolve(&name.text).ok_or_else(|| unknown(name))).collect()
}

/// Compiles terms that leave one value, with the curves that they read and the meanings of their names.
///
/// # Errors
/// See [`Expression::compile`](super::Expression::compile).
pub(super) fn compile(
    terms: &[(usize, Term)],
    curves: &[Arc<Curve>],
    operands: &[Operand],
) -> Result<Formula, FormulaError> {
    let mut compiler = Compiler::default();
    for &(offset, term) in terms {
        match term {
            Term::Number(value) => compiler.operand(&[Operation::Constant(value)], 1),
            Term::Slot(slot) => compiler.operand(&[Operation::Slot(slot)], 1),
            Term::Name(index) => match &operands[index] {
                Operand::Constant(value) => compiler.operand(&[Operation::Constant(*value)], 1),
                Operand::Slot(slot) => compiler.operand(&[Operation::Slot(*slot)], 1),
                Operand::Formula(formula) => compiler.operand(&formula.code, formula.depth),
            },
            Term::Unary(unary) => compiler.unary(unary),
            Term::Binary(binary) => compiler.binary(binary),
            Term::Curve(index) => compiler.curve(&curves[index]),
            Term::Select => compiler.select(),
        }
        compiler.check(offset)?;
    }
    let depth = compiler.parts.last().map_or(0, |part| part.depth);
    Ok(Formula { code: compiler.code.into(), depth })
}

/// A stretch of code that leaves one value on the stack; it ends where the next one starts.
#[derive(Clone, Copy, Debug)]
struct Part {
    start: usize,
    /// Values that the stack holds at most while the part runs.
    depth: usize,
}

#[derive(Debug, Default)]
struct Compiler {
    code: Vec<Operation>,
    /// The operands that wait for their operation.
    parts: Vec<Part>,
}

impl Compiler {
    fn operand(&mut self, code: &[Operation], depth: usize) {
        self.parts.push(Part { start: self.code.len(), depth });
        self.code.extend_from_slice(code);
    }

    fn unary(&mut self, unary: Unary) {
        let operand = self.parts[self.parts.len() - 1];
        if let [Operation::Constant(value)] = self.code[operand.start..] {
            self.code[operand.start] = Operation::Constant(value.unary(unary));
        } else {
            self.code.push(Operation::Unary(unary));
        }
    }

    fn curve(&mut self, curve: &Arc<Curve>) {
        let place = self.parts[self.parts.len() - 1];
        if let [Operation::Constant(x)] = self.code[place.start..] {
            self.code[place.start] = Operation::Constant(x.follow(curve));
        } else {
            self.code.push(Operation::Curve(Arc::clone(curve)));
        }
    }

    fn binary(&mut self, binary: Binary) {
        // The parser emits an operation behind its operands, so both are there.
        let (left, right) = (self.parts[self.parts.len() - 2], self.parts[self.parts.len() - 1]);
        self.parts.truncate(self.parts.len() - 2);
        let depth = if let [Operation::Constant(first), Operation::Constant(second)] = self.code[left.start..] {
            self.code.truncate(left.start);
            self.code.push(Operation::Constant(first.binary(binary, second)));
            1
        } else {
            self.join(left, right, binary);
            // The left value waits on the stack while the right one is computed.
            left.depth.max(right.depth + 1)
        };
        self.parts.push(Part { start: left.start, depth });
    }

    /// The condition and both branches become the other branch, the branch that it chooses if it holds, and the condition: so a row of
    /// `if` behind each other needs no more of the stack than one.
    fn select(&mut self) {
        let first = self.parts.len() - 3;
        let [condition, chosen, other] = [0, 1, 2].map(|place| self.parts[first + place]);
        self.parts.truncate(first);
        let start = condition.start;
        let depth = if let [Operation::Constant(truth)] = self.code[start..chosen.start] {
            let unused = if truth == 0.0 { start..other.start } else { other.start..self.code.len() };
            self.code.drain(unused);
            if truth != 0.0 {
                self.code.remove(start);
            }
            if truth == 0.0 { other.depth } else { chosen.depth }
        } else {
            let code = &mut self.code[start..];
            code.rotate_left(chosen.start - start);
            let branches = code.len() - (chosen.start - start);
            code[..branches].rotate_left(other.start - chosen.start);
            self.code.push(Operation::Select);
            other.depth.max(chosen.depth + 1).max(condition.depth + 2)
        };
        self.parts.push(Part { start, depth });
    }

    /// Appends the operation; an operand that is a mere number or slot becomes a part of it.
    fn join(&mut self, left: Part, right: Part, binary: Binary) {
        let operation = match (&self.code[left.start..right.start], &self.code[right.start..]) {
            (_, &[Operation::Constant(number)]) => Operation::BinaryConstant(binary, number),
            (_, &[Operation::Slot(slot)]) => Operation::BinarySlot(binary, slot),
            (&[Operation::Constant(number)], _) => {
                self.code.remove(left.start);
                self.code.push(Operation::ConstantBinary(number, binary));
                return;
            }
            _ => {
                self.code.push(Operation::Binary(binary));
                return;
            }
        };
        self.code.truncate(right.start);
        self.code.push(operation);
    }

    fn check(&self, offset: usize) -> Result<(), FormulaError> {
        if self.code.len() > MOST_OPERATIONS {
            let message = format!(
                "expected at most {MOST_OPERATIONS} operations, named parts included, found {}",
                self.code.len()
            );
            return Err(FormulaError::new(offset, message));
        }
        let depth = self.parts.last().map_or(0, |part| part.depth);
        if depth > STACK {
            let message = format!(
                "expected at most {STACK} intermediate results at a time, found {depth}; \
                 write the deeply nested operand of a sum or product in front of the simple one"
            );
            return Err(FormulaError::new(offset, message));
        }
        Ok(())
    }
}
