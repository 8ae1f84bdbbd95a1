//! A claim as a tree, and its evaluation.

/// A metric of a variant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    /// The variant.
    pub variant: String,
    /// The metric.
    pub metric: String,
}

/// One side of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// As it is written in the claim.
    pub text: String,
    /// What it comes to.
    pub value: f64,
}

/// A comparison that a claim consists of.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What is compared.
    pub left: Side,
    /// `<`, `<=`, `>`, `>=` or `is not finite`.
    pub relation: &'static str,
    /// With what; nothing in the last case.
    pub right: Option<Side>,
    /// Whether it holds.
    pub holds: bool,
}

/// A number that depends on metrics, which it knows by their index.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Number {
    Constant(f64),
    Metric(usize),
    Negate(Box<Number>),
    Absolute(Box<Number>),
    Binary(char, Box<Number>, Box<Number>),
    Extreme(Extreme, Vec<Number>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extreme {
    Least,
    Largest,
}

/// A number and its text in the claim.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Term {
    pub(super) text: String,
    pub(super) number: Number,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// Something that is true or not.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Condition {
    Compare(Term, Relation, Term),
    NotFinite(Term),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
}

impl Relation {
    pub(super) fn symbol(self) -> &'static str {
        match self {
            Relation::Less => "<",
            Relation::LessOrEqual => "<=",
            Relation::Greater => ">",
            Relation::GreaterOrEqual => ">=",
        }
    }

    fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Relation::Less => left < right,
            Relation::LessOrEqual => left <= right,
            Relation::Greater => left > right,
            Relation::GreaterOrEqual => left >= right,
        }
    }
}

impl Number {
    fn value(&self, metrics: &[f64]) -> f64 {
        match self {
            Number::Constant(value) => *value,
            Number::Metric(index) => metrics[*index],
            Number::Negate(number) => -number.value(metrics),
            Number::Absolute(number) => number.value(metrics).abs(),
            Number::Binary(operator, left, right) => {
                let (left, right) = (left.value(metrics), right.value(metrics));
                match operator {
                    '+' => left + right,
                    '-' => left - right,
                    '*' => left * right,
                    _ => left / right,
                }
            }
            Number::Extreme(extreme, numbers) => {
                let values = numbers.iter().map(|number| number.value(metrics));
                values.reduce(|a, b| extreme.of(a, b)).unwrap_or(f64::NAN)
            }
        }
    }
}

impl Extreme {
    /// Not a number if one of the two is none, other than those of the standard library.
    fn of(self, a: f64, b: f64) -> f64 {
        if a.is_nan() || b.is_nan() {
            return f64::NAN;
        }
        match self {
            Extreme::Least => a.min(b),
            Extreme::Largest => a.max(b),
        }
    }
}

impl Term {
    fn side(&self, metrics: &[f64]) -> Side {
        Side { text: self.text.clone(), value: self.number.value(metrics) }
    }
}

impl Condition {
    /// Whether it is true; notes every comparison, also those that no longer matter.
    pub(super) fn evaluate(&self, metrics: &[f64], notes: &mut Vec<Comparison>) -> bool {
        match self {
            Condition::Compare(left, relation, right) => {
                let (left, right) = (left.side(metrics), right.side(metrics));
                let holds = relation.holds(left.value, right.value);
                notes.push(Comparison { left, relation: relation.symbol(), right: Some(right), holds });
                holds
            }
            Condition::NotFinite(term) => {
                let left = term.side(metrics);
                let holds = !left.value.is_finite();
                notes.push(Comparison { left, relation: "is not finite", right: None, holds });
                holds
            }
            Condition::And(first, second) => first.evaluate(metrics, notes) & second.evaluate(metrics, notes),
            Condition::Or(first, second) => first.evaluate(metrics, notes) | second.evaluate(metrics, notes),
        }
    }
}
