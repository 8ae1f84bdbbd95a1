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
    Finite(usize),
    NotFinite(usize),
    And(Box<Tree>, Box<Tree>),
    Or(Box<Tree>, Box<Tree>),
}

impl Relation {
    /// The relation that holds where this one does not; with NaN, neither does.
    fn negated(self) -> Self {
        match self {
            Relation::Less => Relation::GreaterOrEqual,
            Relation::LessOrEqual => Relation::Greater,
            Relation::Greater => Relation::LessOrEqual,
            Relation::GreaterOrEqual => Relation::Less,
        }
    }
}

impl Tree {
    /// The condition that holds where this one does not. A comparison with NaN holds in neither.
    pub(super) fn negated(self) -> Self {
        let boxed = |tree: Box<Tree>| Box::new(tree.negated());
        match self {
            Tree::Compare(left, relation, right) => Tree::Compare(left, relation.negated(), right),
            Tree::Finite(side) => Tree::NotFinite(side),
            Tree::NotFinite(side) => Tree::Finite(side),
            Tree::And(first, second) => Tree::Or(boxed(first), boxed(second)),
            Tree::Or(first, second) => Tree::And(boxed(first), boxed(second)),
        }
    }
}
