//! What is wrong with a formula, and where.

use crate::text::{around, did_you_mean};

/// A formula that cannot be read or compiled.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct FormulaError {
    /// Where in the text, in bytes from its start.
    pub offset: usize,
    /// What was found and what was expected, for the person who wrote the formula.
    pub message: String,
}

impl FormulaError {
    /// A mistake at this byte of the text.
    pub fn new(offset: usize, message: impl Into<String>) -> Self {
        Self { offset, message: message.into() }
    }

    /// Adds that of `names` which is close to the word at the mistake, if there is one.
    #[must_use]
    pub fn with_hint<'n>(mut self, text: &str, names: impl IntoIterator<Item = &'n str>) -> Self {
        let word = |c: &char| c.is_alphanumeric() || *c == '_';
        let found: String = text.get(self.offset..).unwrap_or_default().chars().take_while(word).collect();
        let names: Vec<&str> = names.into_iter().collect();
        // A name that is known is not what is wrong.
        if !names.contains(&found.as_str()) {
            self.message.push_str(&did_you_mean(&found, names));
        }
        self
    }

    /// The message with the place in the formula `text`.
    ///
    /// ```
    /// use formation::formula::Expression;
    /// let text = "2*sin(t";
    /// let error = Expression::parse(text).unwrap_err().within(text);
    /// assert!(error.ends_with("found the end of the formula (column 8 of \"2*sin(t\")"), "{error}");
    /// ```
    pub fn within(&self, text: &str) -> String {
        let column = column(text, self.offset);
        format!("{} (column {column} of \"{}\")", self.message, around(text, self.offset))
    }
}

/// The column of a byte of the text, as editors count it.
pub(super) fn column(text: &str, offset: usize) -> usize {
    text.get(..offset).map_or(1, |before| before.chars().count() + 1)
}
