//! What is wrong with a formula, and where.

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
    pub(super) fn new(offset: usize, message: impl Into<String>) -> Self {
        Self { offset, message: message.into() }
    }
}
