//! A function of time at one instant and just right of it.

use super::function::{Binary, Unary};
use super::real::Real;
use super::{Curve, Jet};

/// The value of a function at an instant, and its limit and derivatives to the right. The two differ where it jumps: at t = 2,
/// `sign(t-2)` is 0, and 1 to the right. So `sign(t-2)*(t-2)` has the slope 1 there, and not 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct OneSidedJet {
    /// The value at the instant.
    value: f64,
    /// The limit from the right, and the derivatives.
    right: Jet,
}

impl OneSidedJet {
    /// The value at the instant with the derivatives to the right.
    pub(super) fn jet(self) -> Jet {
        Jet { value: self.value, ..self.right }
    }

    /// Whether the value at the instant is the limit from the right, to the bit.
    fn is_continuous(self) -> bool {
        self.value.to_bits() == self.right.value.to_bits()
    }
}

impl From<Jet> for OneSidedJet {
    fn from(right: Jet) -> Self {
        Self { value: right.value, right }
    }
}

// A jet has the value that a plain number has, except in a jump. So the value is computed again only behind what may jump.
impl Real for OneSidedJet {
    fn constant(value: f64) -> Self {
        Self { value, right: Jet::constant(value) }
    }

    fn unary(self, operation: Unary) -> Self {
        let right = self.right.unary(operation);
        let is_same = self.is_continuous() && !operation.can_jump();
        Self { value: if is_same { right.value } else { self.value.unary(operation) }, right }
    }

    fn binary(self, operation: Binary, other: Self) -> Self {
        let right = self.right.binary(operation, other.right);
        let is_same = self.is_continuous() && other.is_continuous() && !operation.can_jump();
        Self { value: if is_same { right.value } else { self.value.binary(operation, other.value) }, right }
    }

    fn follow(self, curve: &Curve) -> Self {
        Self { value: curve.value(self.value), right: self.right.follow(curve) }
    }

    fn select(condition: Self, if_true: Self, if_false: Self) -> Self {
        Self {
            value: f64::select(condition.value, if_true.value, if_false.value),
            right: Jet::select(condition.right, if_true.right, if_false.right),
        }
    }
}
