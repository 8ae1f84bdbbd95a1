//! Where a value comes from.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A scenario file in memory.
#[derive(Clone, PartialEq, Eq)]
pub struct Source {
    /// What messages call it, usually the path as the user typed it.
    pub name: String,
    /// The whole text.
    pub text: String,
}

/// Without the text, which every value of a tree refers to.
impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Source").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Source {
    /// The number of the line around byte `offset`, from 1, the line itself, and where it begins in the text.
    pub(super) fn line(&self, offset: usize) -> (usize, &str, usize) {
        let offset = floor_char_boundary(&self.text, offset);
        let start = self.text[..offset].rfind('\n').map_or(0, |newline| newline + 1);
        let line = self.text[start..].split('\n').next().unwrap_or("");
        let number = self.text[..start].matches('\n').count() + 1;
        (number, line.strip_suffix('\r').unwrap_or(line), start)
    }
}

/// Where a key or a value was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// In a file.
    File {
        /// The file.
        source: Arc<Source>,
        /// Its bytes there. The whole text stands for the file as such: messages then name no line.
        span: Range<usize>,
    },
    /// On the command line.
    Override {
        /// The argument as messages show it, `--set controller.c_p=3`; every value of the argument refers to this one text.
        text: Arc<str>,
    },
}

impl Origin {
    /// An argument of the command line, as messages show it.
    pub fn argument(text: &str) -> Self {
        Self::Override { text: text.into() }
    }

    /// Sorts messages by file and place; those about the command line come last.
    pub(super) fn order(&self) -> (bool, &str, usize) {
        match self {
            Origin::File { source, span } => (false, &source.name, span.start),
            Origin::Override { text } => (true, text, 0),
        }
    }
}

/// The last place at or before byte `offset` where no character is cut.
pub(super) fn floor_char_boundary(text: &str, offset: usize) -> usize {
    let clamped = offset.min(text.len());
    (0..=clamped).rev().find(|&place| text.is_char_boundary(place)).unwrap_or(0)
}
