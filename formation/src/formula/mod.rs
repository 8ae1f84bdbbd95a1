//! Formulas of scenario files: text to postfix code, evaluated on numbers or on truncated Taylor series.
//!
//! A scenario writes references, disturbances and derived parameters as text, `"3*cos(0.08*t + (i-1)*pi/3)"`.
//! [`Expression::parse`] reads it, [`Expression::compile`] binds its names to constants, slots of an input array or
//! other formulas, and the [`Formula`] that results is evaluated inside an integration stage without allocating:
//! [`Formula::evaluate`] on numbers, [`Formula::evaluate_jet`] on [`Jet`]s, which carry three exact time derivatives.
//!
//! # Language
//!
//! | what            | how                                                                                          |
//! |-----------------|----------------------------------------------------------------------------------------------|
//! | numbers         | `1`, `0.5`, `1e-3`, and `pi`                                                                 |
//! | names           | letters, digits and `_`, not starting with a digit                                           |
//! | operators       | `+ -`, then `* /`, then unary `-`, then `^`, which associates to the right: `-x^2 = -(x^2)`  |
//! | one argument    | `sin cos tan asin acos atan sinh cosh tanh exp ln sqrt abs sign`; `sign(0) = 0`              |
//! | two arguments   | `atan2(y,x)`, `sig(x,p) = sign(x)*abs(x)^p` with `sig(0,p) = 0`                              |
//! | `min`, `max`    | of one or more arguments                                                                     |
//! | other names     | in backticks: `` `b_ξ` ``                                                                    |
//!
//! A [`Condition`] compares formulas: `<`, `<=`, `>`, `>=`, also in a row (`1 <= x <= 2`), `not_finite(x)`, joined by `and`, then
//! `or`, with parentheses. A caller may add [`Operands`] of its own to either.
//!
//! Time derivatives are those to the right: at a switch of `abs`, `sign`, `min`, `max` or `sig`, those of the branch that
//! holds just after the instant.
//!
//! # Reproducibility
//!
//! A formula gives the same bits on every machine: operations run in the order in which they are written, products
//! are not fused into sums, and every transcendental function comes from the `libm` crate. A power whose exponent has
//! one of the values 0 to 8 is a repeated multiplication, whether that exponent was written as a number or came from a
//! slot, so that folding constants never changes a result.

mod compile;
mod condition;
mod error;
mod evaluate;
mod expression;
mod extract;
mod function;
mod jet;
mod one_sided;
mod operand;
mod parse;
mod real;
mod token;
mod tree;

#[cfg(test)]
mod tests;

pub use compile::Operand;
pub use condition::{Compared, Comparison, Condition};
pub use error::FormulaError;
pub use evaluate::Formula;
pub use expression::Expression;
pub use jet::Jet;
pub use operand::{Cursor, Operands};
pub(crate) use tree::Relation;
