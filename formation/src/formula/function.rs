//! The operations of the language and the names of those that are written as calls.

use super::tree::Relation;

/// Most operations of a formula. Text alone stays below it; formulas put into formulas may multiply without bound.
pub(super) const MOST_OPERATIONS: usize = 4096;

/// An operand, or an operation on the operands before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Term {
    Number(f64),
    /// Index into the names of the text.
    Name(usize),
    /// The slot of an operand that the caller has read.
    Slot(usize),
    Unary(Unary),
    Binary(Binary),
    /// The curve of this index into those of the text, at the place that the operand before it gives.
    Curve(usize),
    /// Of the three operands before it, the second if the first is the truth, 1, else the third.
    Select,
}

/// An operation on one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unary {
    Negate,
    Sine,
    Cosine,
    Tangent,
    Arcsine,
    Arccosine,
    Arctangent,
    HyperbolicSine,
    HyperbolicCosine,
    HyperbolicTangent,
    Exponential,
    Logarithm,
    SquareRoot,
    Absolute,
    Sign,
    Floor,
    Ceiling,
    /// The angle in (-pi, pi] that differs by whole turns.
    Wrap,
    /// 0 below 0, else 1.
    Step,
    /// 1 if the value is finite, else 0.
    Finite,
    /// 0 if the value is finite, else 1.
    NotFinite,
}

/// An operation on two values. Those on truth take and give 1 for true and 0 for false.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    /// The angle of the point (right, left): the first argument is the ordinate, as in C.
    Arctangent2,
    Minimum,
    Maximum,
    /// sign(left) * |left|^right, and 0 at 0 whatever the exponent.
    SignedPower,
    /// What the division with the quotient rounded down leaves; it has the sign of the divisor.
    Modulo,
    Hypotenuse,
    /// 1 from time 0 until the length, the right operand, has passed, else 0.
    Pulse,
    /// The random number with this key, the left operand, and this index.
    Noise,
    Compare(Relation),
    And,
    Or,
}

impl Unary {
    /// Whether the value may jump where its argument does not.
    pub(super) fn can_jump(self) -> bool {
        matches!(self, Unary::Sign | Unary::Floor | Unary::Ceiling | Unary::Wrap | Unary::Step)
    }
}

impl Binary {
    /// Whether the value may jump where its arguments do not.
    pub(super) fn can_jump(self) -> bool {
        matches!(self, Binary::Modulo | Binary::Pulse | Binary::Compare(_))
    }
}

/// What a call in a formula stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Function {
    Unary(Unary),
    Binary(Binary),
    /// Of one or more arguments.
    Fold(Binary),
    /// `clip(x, low, high)`.
    Clip,
    /// `pulse(t, start, length)`.
    Pulse,
    /// `noise(key, t, period)`.
    Noise,
}

const FUNCTIONS: [(&str, Function); 28] = [
    ("sin", Function::Unary(Unary::Sine)),
    ("cos", Function::Unary(Unary::Cosine)),
    ("tan", Function::Unary(Unary::Tangent)),
    ("asin", Function::Unary(Unary::Arcsine)),
    ("acos", Function::Unary(Unary::Arccosine)),
    ("atan", Function::Unary(Unary::Arctangent)),
    ("atan2", Function::Binary(Binary::Arctangent2)),
    ("sinh", Function::Unary(Unary::HyperbolicSine)),
    ("cosh", Function::Unary(Unary::HyperbolicCosine)),
    ("tanh", Function::Unary(Unary::HyperbolicTangent)),
    ("exp", Function::Unary(Unary::Exponential)),
    ("ln", Function::Unary(Unary::Logarithm)),
    ("sqrt", Function::Unary(Unary::SquareRoot)),
    ("hypot", Function::Binary(Binary::Hypotenuse)),
    ("abs", Function::Unary(Unary::Absolute)),
    ("sign", Function::Unary(Unary::Sign)),
    ("floor", Function::Unary(Unary::Floor)),
    ("ceil", Function::Unary(Unary::Ceiling)),
    ("mod", Function::Binary(Binary::Modulo)),
    ("wrap", Function::Unary(Unary::Wrap)),
    ("step", Function::Unary(Unary::Step)),
    ("pulse", Function::Pulse),
    ("min", Function::Fold(Binary::Minimum)),
    ("max", Function::Fold(Binary::Maximum)),
    ("clip", Function::Clip),
    ("clamp", Function::Clip),
    ("sig", Function::Binary(Binary::SignedPower)),
    ("noise", Function::Noise),
];

/// By how much an instant may lie in front of an interval of `noise` and belongs to it, relative to the length of the interval: the
/// quotient of two rounded numbers, such as 0.3/0.1, may lie below the whole number that is meant.
const EARLY: f64 = 1e-9;

impl Function {
    /// The function of this name.
    pub(super) fn named(name: &str) -> Option<Self> {
        FUNCTIONS.iter().find(|(known, _)| *known == name).map(|&(_, function)| function)
    }

    /// The names of all functions.
    pub(super) fn names() -> impl Iterator<Item = &'static str> {
        FUNCTIONS.iter().map(|(name, _)| *name).chain(["if", "table", "trajectory"])
    }

    /// Number of arguments, `None` for one or more.
    pub(super) fn arguments(self) -> Option<usize> {
        match self {
            Function::Unary(_) => Some(1),
            Function::Binary(_) => Some(2),
            Function::Fold(_) => None,
            Function::Clip | Function::Pulse | Function::Noise => Some(3),
        }
    }

    /// What is computed as soon as this argument (from 1) is known, in postfix order.
    pub(super) fn behind(self, argument: usize) -> Vec<Term> {
        match (self, argument) {
            (Function::Unary(unary), 1) => vec![Term::Unary(unary)],
            (Function::Binary(binary), 2) => vec![Term::Binary(binary)],
            (Function::Fold(binary), 2..) => vec![Term::Binary(binary)],
            (Function::Clip, 2) => vec![Term::Binary(Binary::Maximum)],
            (Function::Clip, 3) => vec![Term::Binary(Binary::Minimum)],
            (Function::Pulse, 2) => vec![Term::Binary(Binary::Subtract)],
            (Function::Pulse, 3) => vec![Term::Binary(Binary::Pulse)],
            (Function::Noise, 3) => vec![
                Term::Binary(Binary::Divide),
                Term::Number(EARLY),
                Term::Binary(Binary::Add),
                Term::Unary(Unary::Floor),
                Term::Binary(Binary::Noise),
            ],
            _ => Vec::new(),
        }
    }
}
