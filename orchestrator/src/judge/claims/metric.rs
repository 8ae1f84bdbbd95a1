//! The operands of a claim: metrics of variants.

use formation::config::did_you_mean;
use formation::formula::{Cursor, FormulaError, Operands};

/// A metric of a variant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    /// The variant.
    pub variant: String,
    /// The metric.
    pub metric: String,
}

/// The metrics that a claim is about: `dx(HFC)` is a slot.
pub(super) struct Metrics<'a> {
    pub(super) variants: &'a [String],
    /// What fills the slots, each once.
    pub(super) needs: Vec<Need>,
}

impl Operands for Metrics<'_> {
    fn read(&mut self, metric: &str, _: usize, text: &mut Cursor) -> Result<Option<usize>, FormulaError> {
        text.skip_space();
        if !text.take('(') {
            let expected = format!("the variant behind the metric '{metric}', as in {metric}(VARIANT)");
            return Err(text.unexpected(&expected));
        }
        let variant = self.variant(text)?;
        text.skip_space();
        if !text.take(')') {
            return Err(text.unexpected("')' behind the variant"));
        }
        let need = Need { variant: variant.into(), metric: metric.into() };
        let known = self.needs.iter().position(|other| *other == need);
        Ok(Some(known.unwrap_or_else(|| {
            self.needs.push(need);
            self.needs.len() - 1
        })))
    }
}

impl Metrics<'_> {
    /// The name of a variant, which may have hyphens and points; with other characters in backticks.
    fn variant<'t>(&self, text: &mut Cursor<'t>) -> Result<&'t str, FormulaError> {
        text.skip_space();
        let start = text.offset();
        let variant = match text.peek() {
            Some('`') => text.take_quoted()?,
            _ => text.take_while(|c| !matches!(c, '(' | ')' | '`' | ',' | '<' | '>')).trim_end(),
        };
        if variant.is_empty() {
            return Err(FormulaError::new(start, "expected the name of a variant, as in dx(HFC)"));
        }
        if !self.variants.iter().any(|known| known == variant) {
            let hint = did_you_mean(variant, self.variants.iter().map(String::as_str));
            let known = if self.variants.is_empty() { "none".into() } else { self.variants.join(", ") };
            let message = format!("no variant is called `{variant}`, expected one of: {known}{hint}");
            return Err(FormulaError::new(start, message));
        }
        Ok(variant)
    }
}
