//! Tests of the module as a whole.

mod conditions;
mod derivatives;
mod language;
mod values;

use super::{Expression, Formula, Jet, Operand};

/// Compiles `text` with each of `names` bound to the slot of its index.
fn formula(text: &str, names: &[&str]) -> Formula {
    let resolve = |name: &str| names.iter().position(|known| *known == name).map(Operand::Slot);
    let expression = Expression::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    expression.compile(resolve).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn jet(value: f64, rate: f64, acceleration: f64, jerk: f64) -> Jet {
    Jet { value, rate, acceleration, jerk }
}

fn components(jet: Jet) -> [f64; 4] {
    [jet.value, jet.rate, jet.acceleration, jet.jerk]
}

/// Equality of bits, except that one result that is not a number is as good as another.
fn same_bits(first: f64, second: f64) -> bool {
    first.to_bits() == second.to_bits() || first.is_nan() && second.is_nan()
}
