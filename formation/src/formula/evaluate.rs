//! Compiled formulas and the stack machine that runs them.

use std::sync::Arc;

use super::function::{Binary, Unary};
use super::one_sided::OneSidedJet;
use super::real::Real;
use super::{Curve, Jet};

/// Most values on the stack at a time. Fixed, so that a run needs no memory but the caller's stack.
pub(super) const STACK: usize = 32;

/// A step of the stack machine.
#[derive(Clone, Debug)]
pub(super) enum Operation {
    Constant(f64),
    Slot(usize),
    Unary(Unary),
    Binary(Binary),
    /// The value of the curve at the place that is the last value.
    Curve(Arc<Curve>),
    /// A binary operation whose right operand is this number.
    BinaryConstant(Binary, f64),
    /// A binary operation whose right operand is this slot.
    BinarySlot(Binary, usize),
    /// A binary operation whose left operand is this number.
    ConstantBinary(f64, Binary),
    /// Of the three last values, the second if the third is the truth, 1, else the first.
    Select,
}

/// A formula ready for evaluation: postfix code over the slots of an input array, constants folded.
#[derive(Clone, Debug)]
pub struct Formula {
    /// Leaves exactly one value on the stack.
    pub(super) code: Box<[Operation]>,
    /// Values on the stack at most, not above [`STACK`].
    pub(super) depth: usize,
}

impl Formula {
    /// The value of the formula. Does not allocate.
    ///
    /// Outside the domain of a function the value is infinite or not a number; `min`, `max` and `sign` do not hide the
    /// latter.
    ///
    /// # Panics
    /// If `slots` is shorter than the highest slot that the formula uses.
    pub fn evaluate(&self, slots: &[f64]) -> f64 {
        self.run::<f64, _>(slots)
    }

    /// The value of the formula and its first three time derivatives, given those of the slots. Does not allocate.
    ///
    /// The value has the bits that [`Formula::evaluate`] gives on the values of the slots. Derivatives are those to the right:
    /// where `if`, `abs`, `min` or another function switches or jumps at the instant, they are the ones of the branch that holds
    /// just after it, as far as the first three derivatives of the arguments decide which one that is. Where the slope of a
    /// function is infinite, as that of `sqrt` at 0, derivatives are infinite or NaN.
    ///
    /// # Panics
    /// If `slots` is shorter than the highest slot that the formula uses.
    pub fn evaluate_jet(&self, slots: &[Jet]) -> Jet {
        self.run::<OneSidedJet, _>(slots).jet()
    }

    /// The value, if it depends on no slot.
    #[cfg(test)]
    pub(super) fn as_constant(&self) -> Option<f64> {
        match *self.code {
            [Operation::Constant(value)] => Some(value),
            _ => None,
        }
    }

    /// Whether the formula reads the slot of this index.
    #[cfg(test)]
    pub(super) fn uses_slot(&self, slot: usize) -> bool {
        self.code.iter().any(
            |operation| matches!(operation, Operation::Slot(used) | Operation::BinarySlot(_, used) if *used == slot),
        )
    }

    /// The same operations in the same order, with as much room as they need: to clear more of it costs as much as to run them.
    fn run<T: Real + From<S>, S: Copy>(&self, slots: &[S]) -> T {
        match self.depth {
            0..=4 => run::<T, S, 4>(&self.code, slots),
            5..=8 => run::<T, S, 8>(&self.code, slots),
            _ => run::<T, S, STACK>(&self.code, slots),
        }
    }
}

fn run<T: Real + From<S>, S: Copy, const ROOM: usize>(code: &[Operation], slots: &[S]) -> T {
    let mut stack = [T::constant(0.0); ROOM];
    let mut top = 0;
    for operation in code {
        match *operation {
            Operation::Constant(value) => {
                stack[top] = T::constant(value);
                top += 1;
            }
            Operation::Slot(slot) => {
                stack[top] = slots[slot].into();
                top += 1;
            }
            Operation::Unary(unary) => stack[top - 1] = stack[top - 1].unary(unary),
            Operation::Binary(binary) => {
                top -= 1;
                stack[top - 1] = stack[top - 1].binary(binary, stack[top]);
            }
            Operation::BinaryConstant(binary, right) => {
                stack[top - 1] = stack[top - 1].binary(binary, T::constant(right));
            }
            Operation::BinarySlot(binary, right) => stack[top - 1] = stack[top - 1].binary(binary, slots[right].into()),
            Operation::ConstantBinary(left, binary) => {
                stack[top - 1] = T::constant(left).binary(binary, stack[top - 1]);
            }
            Operation::Curve(ref curve) => stack[top - 1] = stack[top - 1].follow(curve),
            Operation::Select => {
                top -= 2;
                stack[top - 1] = T::select(stack[top + 1], stack[top], stack[top - 1]);
            }
        }
    }
    stack[0]
}
