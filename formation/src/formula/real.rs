//! What a formula can be evaluated on, and the operations on plain numbers.

use super::function::{Binary, Unary};

/// A number as the evaluator sees it: a plain one, or one that carries its derivatives along.
pub(super) trait Real: Copy {
    /// A number that does not change in time.
    fn constant(value: f64) -> Self;

    /// The result of an operation on this value.
    fn unary(self, operation: Unary) -> Self;

    /// The result of an operation on this value, the left operand, and `right`.
    fn binary(self, operation: Binary, right: Self) -> Self;
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
        }
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
