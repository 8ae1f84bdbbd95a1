//! A formula as text that has been read, its names not yet bound.

use super::compile::{bind, compile};
use super::parse::{Parsed, parse};
use super::{Formula, FormulaError, Operand, Operands};

/// A parsed formula. [`Expression::compile`] makes it one that can be evaluated.
///
/// ```
/// use formation::formula::{Expression, Jet, Operand};
/// let expression = Expression::parse("radius*cos(0.5*t)")?;
/// assert_eq!(expression.names(), ["radius", "t"]);
///
/// let formula = expression.compile(|name| match name {
///     "radius" => Some(Operand::Constant(3.0)),
///     "t" => Some(Operand::Slot(0)),
///     _ => None,
/// })?;
/// assert_eq!(formula.evaluate(&[0.0]), 3.0);
///
/// let at_start = formula.evaluate_jet(&[Jet::time(0.0)]);
/// assert_eq!((at_start.value, at_start.rate, at_start.acceleration), (3.0, 0.0, -0.75));
/// # Ok::<(), formation::formula::FormulaError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Expression {
    text: String,
    parsed: Parsed,
}

impl Expression {
    /// Reads a formula of at most 4096 bytes and 64 levels of nesting.
    ///
    /// # Errors
    /// [`FormulaError`] says at which byte the text stops being a formula, what stands there and what was expected.
    pub fn parse(text: &str) -> Result<Expression, FormulaError> {
        Self::parse_with(text, &mut ())
    }

    /// The same with operands of the caller.
    ///
    /// # Errors
    /// Also those of [`Operands::read`].
    pub fn parse_with(text: &str, operands: &mut dyn Operands) -> Result<Expression, FormulaError> {
        let parsed = parse(text, operands)?;
        parsed.value.number(0)?;
        Ok(Self { text: text.into(), parsed })
    }

    /// The text as it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The free names in order of first appearance, each once. `pi` and functions are not free.
    pub fn names(&self) -> Vec<&str> {
        self.parsed.names.iter().map(|name| name.text.as_str()).collect()
    }

    /// Binds every free name to what `resolve` makes of it, which is asked once for each, and folds constants.
    ///
    /// # Errors
    /// [`FormulaError`] at the first appearance of a name for which `resolve` returns `None`, and for a formula that,
    /// with its named parts put in, has more than 4096 operations or more than 32 intermediate results at a time.
    pub fn compile(&self, resolve: impl FnMut(&str) -> Option<Operand>) -> Result<Formula, FormulaError> {
        compile(&self.parsed.terms, &self.parsed.curves, &bind(&self.parsed.names, resolve)?)
    }

    /// The value of a formula without free names. It may be infinite or not a number, as that of `1/0`.
    ///
    /// # Errors
    /// [`FormulaError`] at the first free name.
    pub fn constant(&self) -> Result<f64, FormulaError> {
        if let Some(name) = self.parsed.names.first() {
            let message = format!("expected a constant, found the name '{}'", name.text);
            return Err(FormulaError::new(name.offset, message));
        }
        Ok(self.compile(|_| None)?.evaluate(&[]))
    }
}
