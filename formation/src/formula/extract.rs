//! Parts of a formula that depend on one slot only, taken out to be computed once for many evaluations.

use super::Formula;
use super::evaluate::Operation;

/// A stretch of code that leaves one value on the stack; it ends where the next one starts.
#[derive(Clone, Copy)]
struct Part {
    start: usize,
    /// It reads nothing but the slot, and numbers.
    pure: bool,
}

impl Formula {
    /// Takes out the largest parts that read no slot but `slot` and compute something: the rest of the formula, which reads
    /// their values in the slots from `first` on, and the parts in this order. The rest on the values of the parts has the
    /// bits of the formula itself.
    pub fn extract(&self, slot: usize, first: usize) -> (Formula, Vec<Formula>) {
        let mut extraction = Extraction { code: Vec::new(), parts: Vec::new(), first, depth: self.depth };
        let mut stack: Vec<Part> = Vec::new();
        for operation in &self.code {
            let start = extraction.code.len();
            let part = match *operation {
                Operation::Constant(_) => Part { start, pure: true },
                Operation::Slot(read) => Part { start, pure: read == slot },
                Operation::Unary(_)
                | Operation::Curve(_)
                | Operation::BinaryConstant(..)
                | Operation::ConstantBinary(..) => stack.pop().unwrap_or(Part { start, pure: false }),
                Operation::BinarySlot(_, read) => {
                    let left = stack.pop().unwrap_or(Part { start, pure: false });
                    if left.pure && read != slot {
                        extraction.take(left.start, start);
                    }
                    Part { pure: left.pure && read == slot, ..left }
                }
                Operation::Binary(_) => {
                    // The compiler emits an operation behind its operands, so both are there.
                    let right = stack.pop().unwrap_or(Part { start, pure: false });
                    let left = stack.pop().unwrap_or(Part { start, pure: false });
                    match (left.pure, right.pure) {
                        (true, false) => extraction.take(left.start, right.start),
                        (false, true) => extraction.take(right.start, start),
                        _ => {}
                    }
                    Part { start: left.start, pure: left.pure && right.pure }
                }
                Operation::Select => {
                    let mut end = start;
                    let operands = [(); 3].map(|()| {
                        let operand = stack.pop().unwrap_or(Part { start, pure: false });
                        (operand, std::mem::replace(&mut end, operand.start))
                    });
                    let pure = operands.iter().all(|(operand, _)| operand.pure);
                    // The last one first, as it moves none of the others.
                    for (operand, end) in operands.iter().filter(|(operand, _)| operand.pure && !pure) {
                        extraction.take(operand.start, *end);
                    }
                    Part { start: end, pure }
                }
            };
            extraction.code.push(operation.clone());
            stack.push(part);
        }
        if stack.last().is_some_and(|whole| whole.pure) {
            let end = extraction.code.len();
            extraction.take(0, end);
        }
        (Formula { code: extraction.code.into(), depth: self.depth }, extraction.parts)
    }
}

struct Extraction {
    code: Vec<Operation>,
    parts: Vec<Formula>,
    first: usize,
    depth: usize,
}

impl Extraction {
    /// Puts a slot in the place of a stretch of code, if that computes anything.
    fn take(&mut self, start: usize, end: usize) {
        if end - start > 1 {
            let slot = Operation::Slot(self.first + self.parts.len());
            let code = self.code.splice(start..end, [slot]).collect();
            self.parts.push(Formula { code, depth: self.depth });
        }
    }
}
