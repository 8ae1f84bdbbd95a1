//! Automatic differentiation in time: values that carry their first three derivatives along.

use std::f64::consts::PI;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Curve;
use super::function::{Binary, Unary};
use super::real::{Real, power, sign, signed_power, takes_right};
use super::tree::Relation;

/// A function of time at one instant: its value and its first three time derivatives.
///
/// These are plain derivatives, not Taylor coefficients. Units are those of the value over s, s^2 and s^3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// The value.
    pub value: f64,
    /// The first derivative.
    pub rate: f64,
    /// The second derivative.
    pub acceleration: f64,
    /// The third derivative.
    pub jerk: f64,
}

impl Jet {
    /// A value that does not change.
    pub fn constant(value: f64) -> Jet {
        Self { value, ..Self::default() }
    }

    /// Time itself, at `t` seconds.
    pub fn time(t: f64) -> Jet {
        Self { value: t, rate: 1.0, ..Self::default() }
    }

    fn is_constant(self) -> bool {
        self.rate == 0.0 && self.acceleration == 0.0 && self.jerk == 0.0
    }

    /// The jet of g(self), given g and its first three derivatives at the value (formula of Faà di Bruno).
    fn chain(self, [value, first, second, third]: [f64; 4]) -> Jet {
        let rate = self.rate;
        Jet {
            value,
            rate: first * rate,
            acceleration: second * rate * rate + first * self.acceleration,
            jerk: third * rate * rate * rate + 3.0 * second * rate * self.acceleration + first * self.jerk,
        }
    }

    /// The sign that the function has just right of the instant: that of its first derivative that is not 0, the value being
    /// the one of order 0; 0 if all that are known are 0, and not a number if that decides.
    fn sign_to_the_right(self) -> f64 {
        let known = [self.value, self.rate, self.acceleration, self.jerk];
        known.into_iter().find(|derivative| *derivative != 0.0).map_or(0.0, sign)
    }

    /// Whether it rises just right of the instant, 1, or falls, -1.
    fn direction(self) -> f64 {
        Jet { value: 0.0, ..self }.sign_to_the_right()
    }

    /// Whether the relation to another one holds just right of the instant.
    fn compares(self, relation: Relation, right: Jet) -> bool {
        if self.value == right.value {
            relation.holds(0.0, (right - self).direction())
        } else {
            relation.holds(self.value, right.value)
        }
    }

    /// The absolute value. In a corner it has the derivatives to the right.
    fn absolute(self) -> Jet {
        let sign = self.sign_to_the_right();
        Jet { value: self.value.abs(), ..if sign < 0.0 { -self } else { self } }
    }

    /// The one of two that is smaller just right of the instant, or larger; this one if they do not differ in anything known.
    fn extreme(self, operation: Binary, right: Jet) -> Jet {
        if self.value != right.value {
            return if takes_right(operation, self.value, right.value) { right } else { self };
        }
        let lead = (right - Jet { value: right.value, ..self }).sign_to_the_right();
        let takes_right = if operation == Binary::Minimum { lead < 0.0 } else { lead > 0.0 };
        if takes_right { Jet { value: self.value, ..right } } else { self }
    }

    fn arctangent2(self, abscissa: Jet) -> Jet {
        let (y, x) = (self, abscissa);
        // The rate of the angle is the quotient of these two; its derivatives follow from theirs.
        let numerator = [
            x.value * y.rate - y.value * x.rate,
            x.value * y.acceleration - y.value * x.acceleration,
            x.rate * y.acceleration + x.value * y.jerk - y.rate * x.acceleration - y.value * x.jerk,
        ];
        let denominator = x * x + y * y;
        let quotient =
            Jet { value: numerator[0], rate: numerator[1], acceleration: numerator[2], jerk: 0.0 } / denominator;
        Jet {
            value: y.value.binary(Binary::Arctangent2, x.value),
            rate: quotient.value,
            acceleration: quotient.rate,
            jerk: quotient.acceleration,
        }
    }

    /// The rest of the division by `right` with the quotient rounded down.
    fn modulo(self, right: Jet) -> Jet {
        let value = self.value.binary(Binary::Modulo, right.value);
        let quotient = ((self.value - value) / right.value).round();
        let rest = Jet { value, ..self - right * Jet::constant(quotient) };
        // It leaves 0 for values of the other sign, and goes on at the divisor.
        let leaves = value == 0.0 && rest.direction() * sign(right.value) < 0.0;
        if leaves { rest + right } else { rest }
    }

    fn hypotenuse(self, right: Jet) -> Jet {
        let (x, y) = (self, right);
        let value = x.value.binary(Binary::Hypotenuse, y.value);
        if value == 0.0 {
            // Just after it, the point is this one times the time that has passed.
            let divided =
                |z: Jet| Jet { value: z.rate, rate: z.acceleration / 2.0, acceleration: z.jerk / 3.0, jerk: 0.0 };
            let rate = divided(x).binary(Binary::Hypotenuse, divided(y));
            return Jet { value, rate: rate.value, acceleration: 2.0 * rate.rate, jerk: 3.0 * rate.acceleration };
        }
        // The derivatives of half the square.
        let half = [
            x.value * x.rate + y.value * y.rate,
            x.rate * x.rate + x.value * x.acceleration + y.rate * y.rate + y.value * y.acceleration,
            3.0 * x.rate * x.acceleration + x.value * x.jerk + 3.0 * y.rate * y.acceleration + y.value * y.jerk,
        ];
        let rate = half[0] / value;
        let acceleration = (half[1] - rate * rate) / value;
        Jet { value, rate, acceleration, jerk: (half[2] - 3.0 * rate * acceleration) / value }
    }

    /// A power, or, if `signed`, sign(self) * |self|^exponent.
    fn power(self, exponent: Jet, signed: bool) -> Jet {
        let derivative = |order: u8, base: f64, exponent: f64| match (signed, order % 2) {
            (false, _) => power(base, exponent),
            // The sign is that to the right, which matters where the power alone does not vanish.
            (true, 0) if order > 0 && exponent == 0.0 => self.sign_to_the_right(),
            (true, 0) => signed_power(base, exponent),
            // The derivative of an odd function is even.
            (true, _) => power(base.abs(), exponent),
        };
        let value = derivative(0, self.value, exponent.value);
        if !exponent.is_constant() {
            if self.is_constant() && self.value == 0.0 {
                // 0 to any power; the general rule would multiply 0 by the infinite logarithm.
                return Jet::constant(value);
            }
            let base = if signed { self.absolute() } else { self };
            return (exponent * base.unary(Unary::Logarithm)).chain([value; 4]);
        }
        let mut factor = 1.0;
        let mut derivatives = [value; 4];
        for order in 1..=3 {
            factor *= exponent.value - f64::from(order - 1);
            if factor == 0.0 {
                // So is the derivative, even where the lowered power is infinite.
                derivatives[usize::from(order)] = 0.0;
            } else {
                let lowered = exponent.value - f64::from(order);
                derivatives[usize::from(order)] = factor * derivative(order, self.value, lowered);
            }
        }
        self.chain(derivatives)
    }
}

impl Real for Jet {
    fn constant(value: f64) -> Self {
        Jet::constant(value)
    }

    fn unary(self, operation: Unary) -> Self {
        let x = self.value;
        if self.is_constant() {
            // An infinite derivative, as that of the square root at 0, must not spoil a constant.
            return Jet::constant(x.unary(operation));
        }
        // Sine and cosine need each other, and together they have the bits that each has alone.
        let (value, partner) = match operation {
            Unary::Sine => libm::sincos(x),
            Unary::Cosine => {
                let (sine, cosine) = libm::sincos(x);
                (cosine, sine)
            }
            _ => (x.unary(operation), 0.0),
        };
        match operation {
            Unary::Negate => -self,
            Unary::Sine => self.chain([value, partner, -value, -partner]),
            Unary::Cosine => self.chain([value, -partner, -value, partner]),
            Unary::Tangent => {
                let slope = 1.0 + value * value;
                self.chain([value, slope, 2.0 * value * slope, slope * (2.0 + 6.0 * value * value)])
            }
            Unary::Arcsine | Unary::Arccosine => {
                let square = (1.0 - x) * (1.0 + x);
                let slope = if operation == Unary::Arcsine { 1.0 } else { -1.0 } / square.sqrt();
                self.chain([value, slope, slope * x / square, slope * (1.0 + 2.0 * x * x) / (square * square)])
            }
            Unary::Arctangent => {
                let slope = 1.0 / (1.0 + x * x);
                let second = -2.0 * x * slope * slope;
                self.chain([value, slope, second, (6.0 * x * x - 2.0) * slope * slope * slope])
            }
            Unary::HyperbolicSine => {
                let cosine = libm::cosh(x);
                self.chain([value, cosine, value, cosine])
            }
            Unary::HyperbolicCosine => {
                let sine = libm::sinh(x);
                self.chain([value, sine, value, sine])
            }
            Unary::HyperbolicTangent => {
                let slope = (1.0 - value) * (1.0 + value);
                self.chain([value, slope, -2.0 * value * slope, slope * (6.0 * value * value - 2.0)])
            }
            Unary::Exponential => self.chain([value; 4]),
            Unary::Logarithm => self.chain([value, 1.0 / x, -1.0 / (x * x), 2.0 / (x * x * x)]),
            Unary::SquareRoot => {
                let slope = 0.5 / value;
                self.chain([value, slope, -0.5 * slope / x, 0.75 * slope / (x * x)])
            }
            Unary::Absolute => self.absolute(),
            Unary::Sign => Jet::constant(self.sign_to_the_right()),
            Unary::Floor if value == x && self.direction() < 0.0 => Jet::constant(value - 1.0),
            Unary::Ceiling if value == x && self.direction() > 0.0 => Jet::constant(value + 1.0),
            Unary::Wrap if value == PI && self.direction() > 0.0 => Jet { value: -PI, ..self },
            Unary::Wrap => Jet { value, ..self },
            Unary::Step if x == 0.0 => Jet::constant(if self.direction() < 0.0 { 0.0 } else { 1.0 }),
            Unary::Floor | Unary::Ceiling | Unary::Step | Unary::Finite | Unary::NotFinite => Jet::constant(value),
        }
    }

    fn binary(self, operation: Binary, right: Self) -> Self {
        if self.is_constant() && right.is_constant() {
            return Jet::constant(self.value.binary(operation, right.value));
        }
        match operation {
            Binary::Add => self + right,
            Binary::Subtract => self - right,
            Binary::Multiply => self * right,
            Binary::Divide => self / right,
            Binary::Power => self.power(right, false),
            Binary::SignedPower => self.power(right, true),
            Binary::Arctangent2 => self.arctangent2(right),
            Binary::Minimum | Binary::Maximum => self.extreme(operation, right),
            Binary::Modulo => self.modulo(right),
            Binary::Hypotenuse => self.hypotenuse(right),
            Binary::Pulse if self.value.is_nan() || right.value.is_nan() => Jet::constant(f64::NAN),
            Binary::Pulse => {
                let holds = self.compares(Relation::GreaterOrEqual, Jet::default());
                Jet::constant(f64::from(u8::from(holds && self.compares(Relation::Less, right))))
            }
            Binary::Compare(relation) => Jet::constant(f64::from(u8::from(self.compares(relation, right)))),
            Binary::Noise | Binary::And | Binary::Or => Jet::constant(self.value.binary(operation, right.value)),
        }
    }

    fn follow(self, curve: &Curve) -> Self {
        if self.is_constant() {
            return Jet::constant(curve.value(self.value));
        }
        self.chain(curve.derivatives(self.value, self.direction() < 0.0))
    }

    fn select(condition: Self, if_true: Self, if_false: Self) -> Self {
        if condition.value == 0.0 { if_false } else { if_true }
    }
}

impl Neg for Jet {
    type Output = Jet;

    fn neg(self) -> Jet {
        Jet { value: -self.value, rate: -self.rate, acceleration: -self.acceleration, jerk: -self.jerk }
    }
}

impl Add for Jet {
    type Output = Jet;

    fn add(self, right: Jet) -> Jet {
        Jet {
            value: self.value + right.value,
            rate: self.rate + right.rate,
            acceleration: self.acceleration + right.acceleration,
            jerk: self.jerk + right.jerk,
        }
    }
}

impl Sub for Jet {
    type Output = Jet;

    fn sub(self, right: Jet) -> Jet {
        Jet {
            value: self.value - right.value,
            rate: self.rate - right.rate,
            acceleration: self.acceleration - right.acceleration,
            jerk: self.jerk - right.jerk,
        }
    }
}

impl Mul for Jet {
    type Output = Jet;

    fn mul(self, right: Jet) -> Jet {
        let (a, b) = (self, right);
        Jet {
            value: a.value * b.value,
            rate: a.rate * b.value + a.value * b.rate,
            acceleration: a.acceleration * b.value + 2.0 * a.rate * b.rate + a.value * b.acceleration,
            jerk: a.jerk * b.value + 3.0 * a.acceleration * b.rate + 3.0 * a.rate * b.acceleration + a.value * b.jerk,
        }
    }
}

impl Div for Jet {
    type Output = Jet;

    // Each derivative of quotient * right = self, solved for the highest derivative of the quotient.
    fn div(self, right: Jet) -> Jet {
        let (a, b) = (self, right);
        let value = a.value / b.value;
        let rate = (a.rate - value * b.rate) / b.value;
        let acceleration = (a.acceleration - 2.0 * rate * b.rate - value * b.acceleration) / b.value;
        let jerk = (a.jerk - 3.0 * acceleration * b.rate - 3.0 * rate * b.acceleration - value * b.jerk) / b.value;
        Jet { value, rate, acceleration, jerk }
    }
}
