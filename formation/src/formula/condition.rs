//! Conditions: comparisons of formulas, joined by `and`, `or` and `not`.

use super::compile::{bind, compile};
use super::parse::{Parsed, parse};
use super::tree::{Relation, Tree};
use super::{Formula, FormulaError, Operand, Operands};

/// A condition on the slots of an input array, ready for evaluation.
///
/// ```
/// use formation::formula::{Condition, Operand};
/// let x = |name: &str| (name == "x").then_some(Operand::Slot(0));
/// let condition = Condition::parse("1 <= x^2 < 9 or not_finite(x)", &mut (), x)?;
/// assert!(condition.holds(&[-2.0]) && condition.holds(&[f64::NAN]) && !condition.holds(&[0.5]));
/// assert_eq!(condition.margin(&[2.0]), 3.0);
/// assert_eq!(condition.margin(&[4.0]), -7.0);
/// # Ok::<(), formation::formula::FormulaError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Condition {
    tree: Tree,
    sides: Vec<Side>,
}

/// One side of a comparison.
#[derive(Clone, Debug)]
struct Side {
    text: String,
    formula: Formula,
}

/// A comparison of a condition, with the values of its sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What is compared.
    pub left: Compared,
    /// `<`, `<=`, `>`, `>=`, `is finite` or `is not finite`. Where the condition says `not`, the opposite.
    pub relation: &'static str,
    /// With what; nothing in the last two cases.
    pub right: Option<Compared>,
    /// Whether it holds.
    pub holds: bool,
}

/// A number that is compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// As it is written in the condition.
    pub text: String,
    /// Its value.
    pub value: f64,
}

/// Whether something holds, and by how much.
struct Judgement {
    holds: bool,
    margin: f64,
}

impl Condition {
    /// Reads a condition of at most 4096 bytes and 64 levels of nesting, whose operands may be those of `operands`, and binds
    /// its names as [`Expression::compile`](super::Expression::compile) does.
    ///
    /// # Errors
    /// A [`FormulaError`] if the text is no condition, and as those of [`Expression::compile`](super::Expression::compile).
    pub fn parse(
        text: &str,
        operands: &mut dyn Operands,
        resolve: impl FnMut(&str) -> Option<Operand>,
    ) -> Result<Self, FormulaError> {
        let Parsed { terms, names, curves, sides, value } = parse(text, operands)?;
        let tree = value.condition(0)?;
        let operands = bind(&names, resolve)?;
        let sides = sides.into_iter().map(|side| {
            let formula = compile(&terms[side.terms], &curves, &operands)?;
            Ok(Side { text: text[side.text].into(), formula })
        });
        Ok(Self { tree: *tree, sides: sides.collect::<Result<_, FormulaError>>()? })
    }

    /// Whether it holds on these slots. A comparison with NaN does not. Does not allocate.
    ///
    /// # Panics
    /// If `slots` is shorter than the highest slot that the condition uses.
    pub fn holds(&self, slots: &[f64]) -> bool {
        self.judge(&self.tree, slots).holds
    }

    /// By how much it holds, or fails if below 0: the difference of the sides of a comparison, the smaller of the two of `and`,
    /// the larger of those of `or`. A comparison with NaN fails by infinity. Does not allocate.
    ///
    /// # Panics
    /// If `slots` is shorter than the highest slot that the condition uses.
    pub fn margin(&self, slots: &[f64]) -> f64 {
        self.judge(&self.tree, slots).margin
    }

    /// All comparisons in the order of the text, also those that do not decide.
    ///
    /// # Panics
    /// If `slots` is shorter than the highest slot that the condition uses.
    pub fn comparisons(&self, slots: &[f64]) -> Vec<Comparison> {
        let mut comparisons = Vec::new();
        self.collect(&self.tree, slots, &mut comparisons);
        comparisons
    }

    fn judge(&self, tree: &Tree, slots: &[f64]) -> Judgement {
        let value = |side: usize| self.sides[side].formula.evaluate(slots);
        match tree {
            Tree::Compare(left, relation, right) => relation.judge(value(*left), value(*right)),
            Tree::Finite(side) => Judgement::certain(value(*side).is_finite()),
            Tree::NotFinite(side) => Judgement::certain(!value(*side).is_finite()),
            Tree::And(first, second) => {
                let (first, second) = (self.judge(first, slots), self.judge(second, slots));
                Judgement { holds: first.holds && second.holds, margin: first.margin.min(second.margin) }
            }
            Tree::Or(first, second) => {
                let (first, second) = (self.judge(first, slots), self.judge(second, slots));
                Judgement { holds: first.holds || second.holds, margin: first.margin.max(second.margin) }
            }
        }
    }

    fn collect(&self, tree: &Tree, slots: &[f64], comparisons: &mut Vec<Comparison>) {
        let compared = |side: usize| {
            let Side { text, formula } = &self.sides[side];
            Compared { text: text.clone(), value: formula.evaluate(slots) }
        };
        let (left, relation, right) = match tree {
            Tree::Compare(left, relation, right) => (*left, relation.symbol(), Some(compared(*right))),
            Tree::Finite(side) => (*side, "is finite", None),
            Tree::NotFinite(side) => (*side, "is not finite", None),
            Tree::And(first, second) | Tree::Or(first, second) => {
                self.collect(first, slots, comparisons);
                return self.collect(second, slots, comparisons);
            }
        };
        let holds = self.judge(tree, slots).holds;
        comparisons.push(Comparison { left: compared(left), relation, right, holds });
    }
}

impl Relation {
    fn symbol(self) -> &'static str {
        match self {
            Relation::Less => "<",
            Relation::LessOrEqual => "<=",
            Relation::Greater => ">",
            Relation::GreaterOrEqual => ">=",
        }
    }

    /// The relation at the beginning of a text, and what follows it.
    pub(crate) fn strip(text: &str) -> Option<(Self, &str)> {
        // The longer signs first: `<=` begins with `<`.
        let all = [Self::LessOrEqual, Self::GreaterOrEqual, Self::Less, Self::Greater];
        all.into_iter().find_map(|relation| Some((relation, text.strip_prefix(relation.symbol())?)))
    }

    pub(crate) fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Relation::Less => left < right,
            Relation::LessOrEqual => left <= right,
            Relation::Greater => left > right,
            Relation::GreaterOrEqual => left >= right,
        }
    }

    fn judge(self, left: f64, right: f64) -> Judgement {
        let holds = self.holds(left, right);
        let margin = match self {
            Relation::Less | Relation::LessOrEqual => right - left,
            Relation::Greater | Relation::GreaterOrEqual => left - right,
        };
        match (margin.is_nan(), holds) {
            (false, _) => Judgement { holds, margin },
            // Two equal infinities have no difference.
            (true, true) => Judgement { holds, margin: 0.0 },
            (true, false) => Judgement::certain(false),
        }
    }
}

impl Judgement {
    /// It holds, or does not, whatever small changes there are.
    fn certain(holds: bool) -> Self {
        Self { holds, margin: if holds { f64::INFINITY } else { f64::NEG_INFINITY } }
    }
}
