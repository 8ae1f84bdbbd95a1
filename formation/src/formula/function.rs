//! The operations of the language and the names of those that are written as calls.

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
}

/// An operation on two values.
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
}

/// What a call in a formula stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Unary(Unary),
    Binary(Binary),
}

const FUNCTIONS: [(&str, Function); 18] = [
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
    ("abs", Function::Unary(Unary::Absolute)),
    ("sign", Function::Unary(Unary::Sign)),
    ("min", Function::Binary(Binary::Minimum)),
    ("max", Function::Binary(Binary::Maximum)),
    ("sig", Function::Binary(Binary::SignedPower)),
];

impl Function {
    /// The function of this name.
    pub(super) fn named(name: &str) -> Option<Self> {
        FUNCTIONS.iter().find(|(known, _)| *known == name).map(|&(_, function)| function)
    }

    /// The names of all functions, for a message.
    pub(super) fn names() -> String {
        FUNCTIONS.map(|(name, _)| name).join(", ")
    }

    /// Number of arguments, `None` for one or more.
    pub(super) fn arguments(self) -> Option<usize> {
        match self {
            Function::Unary(_) => Some(1),
            Function::Binary(Binary::Minimum | Binary::Maximum) => None,
            Function::Binary(_) => Some(2),
        }
    }
}
