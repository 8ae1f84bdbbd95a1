//! What a formula can be evaluated on, and the operations on plain numbers.

use super::Curve;
use super::function::{Binary, Unary};
use super::noise::noise;
use crate::math::wrap;

/// A number as the evaluator sees it: a plain one, or one that carries its derivatives along.
pub(super) trait Real: Copy {
    /// A number that does not change in time.
    fn constant(value: f64) -> Self;

    /// The result of an operation on this value.
    fn unary(self, operation: Unary) -> Self;

    /// The result of an operation on this value, the left operand, and `right`.
    fn binary(self, operation: Binary, right: Self) -> Self;

    /// The curve at this place.
    fn follow(self, curve: &Curve) -> Self;

    /// The one of both that the truth of the condition, 1 or 0, chooses.
    fn select(condition: Self, if_true: Self, if_false: Self) -> Self;
}

impl Real for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    // The functions of the standard library are those of the platform and differ between machines; `libm` does not. The
    // square root is correctly rounded everywhere.
    #[inline]
    fn unary(self, operation: Unary) -> Self {
        match operation {
            Unary::Negate => -self,
            Unary::Sine => libm::sin(self),
            Unary::Cosine => libm::cos(self),
            Unary::Tangent => libm::tan(self),
            Unary::Arcsine => libm::asin(self),
            Unary::Arccosine => libm::acos(self),
            Unary::Arctangent => libm::atan(self),
            Unary::HyperbolicSine => libm::sinh(self),
            Unary::HyperbolicCosine => libm::cosh(self),
            Unary::HyperbolicTangent => libm::tanh(self),
            Unary::Exponential => libm::exp(self),
            Unary::Logarithm => libm::log(self),
            Unary::SquareRoot => self.sqrt(),
            Unary::Absolute => self.abs(),
            Unary::Sign => sign(self),
            Unary::Floor => self.floor(),
            Unary::Ceiling => self.ceil(),
            Unary::Wrap => wrap(self),
            Unary::Step if self.is_nan() => self,
            Unary::Step => truth(self >= 0.0),
            Unary::Finite => truth(self.is_finite()),
            Unary::NotFinite => truth(!self.is_finite()),
        }
    }

    #[inline]
    fn binary(self, operation: Binary, right: Self) -> Self {
        match operation {
            Binary::Add => self + right,
            Binary::Subtract => self - right,
            Binary::Multiply => self * right,
            Binary::Divide => self / right,
            Binary::Power => power(self, right),
            Binary::Arctangent2 => libm::atan2(self, right),
            Binary::Minimum | Binary::Maximum if takes_right(operation, self, right) => right,
            Binary::Minimum | Binary::Maximum => self,
            Binary::SignedPower => signed_power(self, right),
            Binary::Modulo => modulo(self, right),
            Binary::Hypotenuse => libm::hypot(self, right),
            Binary::Pulse if self.is_nan() || right.is_nan() => f64::NAN,
            Binary::Pulse => truth(0.0 <= self && self < right),
            Binary::Noise => noise(self, right),
            Binary::Compare(relation) => truth(relation.holds(self, right)),
            Binary::And => truth(self != 0.0 && right != 0.0),
            Binary::Or => truth(self != 0.0 || right != 0.0),
        }
    }

    #[inline]
    fn follow(self, curve: &Curve) -> Self {
        curve.value(self)
    }

    #[inline]
    fn select(condition: Self, if_true: Self, if_false: Self) -> Self {
        if condition == 0.0 { if_false } else { if_true }
    }
}

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

/// The rest of the division with the quotient rounded down, of the sign of the divisor.
fn modulo(dividend: f64, divisor: f64) -> f64 {
    let rest = dividend % divisor;
    match rest == 0.0 {
        true => 0.0_f64.copysign(divisor),
        false if (rest < 0.0) != (divisor < 0.0) => rest + divisor,
        false => rest,
    }
}

/// The sign, 0 for both zeros.
pub(super) fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// A power; by repeated multiplication if the exponent is one of 0 to 8.
pub(super) fn power(base: f64, exponent: f64) -> f64 {
    // The conversion saturates and makes 0 of what is not a number; the comparison then rejects both.
    let count = exponent as u8;
    if count <= 8 && f64::from(count) == exponent {
        (0..count).fold(1.0, |product, _| product * base)
    } else {
        libm::pow(base, exponent)
    }
}

/// sign(base) * |base|^exponent; 0 at 0 even where the power is not finite.
pub(super) fn signed_power(base: f64, exponent: f64) -> f64 {
    if base == 0.0 { 0.0 } else { sign(base) * power(base.abs(), exponent) }
}

/// Whether `min` or `max` takes the right operand: it is beyond the left one, or it is not a number and must not be
/// hidden.
pub(super) fn takes_right(operation: Binary, left: f64, right: f64) -> bool {
    let beyond = if operation == Binary::Minimum { right < left } else { right > left };
    beyond || right.is_nan()
}
