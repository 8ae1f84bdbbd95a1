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
//! | one argument    | `sin cos tan asin acos atan sinh cosh tanh exp ln sqrt abs sign floor ceil`; `sign(0) = 0`   |
//! | two arguments   | `atan2(y,x)`, `hypot(x,y)`, `sig(x,p) = sign(x)*abs(x)^p` with `sig(0,p) = 0`                |
//! | `min`, `max`    | of one or more arguments                                                                     |
//! | `mod(a,b)`      | `a - b*floor(a/b)`, without rounding: it has the sign of b                                   |
//! | `wrap(x)`       | the angle in (-pi, pi] that differs from x by whole turns; its slope is that of x            |
//! | `clip(x,a,b)`   | `min(max(x,a),b)`; also called `clamp`                                                       |
//! | `step(x)`       | 0 below 0, and 1 from 0 on                                                                   |
//! | `pulse(t,a,b)`  | 1 for `0 <= t-a < b`, else 0: it starts at a and lasts b                                     |
//! | `if(c,x,y)`     | x if the condition c holds, else y                                                           |
//! | `noise(k,t,p)`  | standard normal numbers, each held for the period p; k numbers independent sequences         |
//! | `table(...)`, `trajectory(...)` | a curve through a data file: `table("wind.csv","vx",t)` ([`data`](crate::data))     |
//! | other names     | in backticks: `` `b_ξ` ``                                                                    |
//!
//! A [`Condition`] compares formulas: `<`, `<=`, `>`, `>=`, also in a row (`1 <= x <= 2`), `not_finite(x)`, with `not` in front,
//! joined by `and`, then `or`, with parentheses. A comparison with NaN does not hold, and `not` does not change that: it turns the
//! relations around. A caller may add [`Operands`] of its own to either.
//!
//! Time derivatives are those to the right: where a function switches or jumps, those of the branch that holds just after the
//! instant. The value follows the definition, as `sign(0)` is 0. Of `if`, the branch that does not hold has no influence; it
//! may be infinite or NaN.
//!
//! The number that `noise` gives depends on k and on the interval `floor(t/p)` only (an instant that lies less than `1e-9*p` in front of
//! an interval belongs to it), so all processes find the same one, in any order. Its derivatives are 0.
//!
//! # Reproducibility
//!
//! A formula gives the same bits on every machine: operations run in the order in which they are written, products
//! are not fused into sums, and every transcendental function comes from the `libm` crate. A power whose exponent has
//! one of the values 0 to 8 is a repeated multiplication, whether that exponent was written as a number or came from a
//! slot, so that folding constants never changes a result.

/// Names that mean something in the formulas of vehicles and laws: no state, parameter or definition can be called so.
pub const FORMULA_NAMES: [&str; 15] = [
    "t",
    "i",
    "j",
    "N",
    "dt",
    "pi",
    "seed",
    "a_ij",
    "b_i",
    "state",
    "reference",
    "estimate",
    "command",
    "position",
    "velocity",
];

mod compile;
mod condition;
mod curve;
mod data_call;
mod error;
mod evaluate;
mod expression;
mod extract;
mod function;
mod jet;
mod noise;
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
pub use curve::Curve;
pub(crate) use data_call::files_named;
pub use data_call::{DataCall, DataError, DataFunction, Interpolation};
pub use error::FormulaError;
pub use evaluate::Formula;
pub use expression::Expression;
pub use jet::Jet;
pub use operand::{Cursor, Operands};
pub(crate) use tree::Relation;
