//! What the grammar makes of a condition.

/// How two numbers compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// A condition on numbers that it knows by their index.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    Compare(usize, Relation, usize),
    NotFinite(usize),
    And(Box<Tree>, Box<Tree>),
    Or(Box<Tree>, Box<Tree>),
}
