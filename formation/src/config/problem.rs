//! Mistakes in scenario files, and how they are shown.

use std::fmt;

use super::source::floor_char_boundary;
use super::{Node, Origin, brief};
use crate::text::readable_problem;

/// One mistake.
///
/// ```text
/// scenarios/uav.toml:14:1: controller.c_q: unknown field
///     |
///  14 | c_q = 2
///     | ^^^
///     = expected one of lam_p, c_p, k_p; did you mean `c_p`?
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Problem {
    /// Where it is, if that is known.
    pub origin: Option<Origin>,
    /// The field, `controller.c_q`; empty for the file as a whole.
    pub path: String,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub help: Option<String>,
    /// What sort of mistake it is, as far as that decides anything.
    pub sort: Sort,
}

/// What sort of mistake a problem is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sort {
    /// There is no field of this name, or no element of this number.
    Unknown,
    /// A table lacks a field that it needs.
    Missing,
    /// Anything else.
    #[default]
    Other,
}

impl Problem {
    /// A problem of the field at `path`, without a hint.
    pub fn new(origin: Option<Origin>, path: impl Into<String>, message: impl Into<String>) -> Self {
        Self { origin, path: path.into(), message: message.into(), help: None, sort: Sort::Other }
    }

    /// A problem of a place that is known.
    pub(super) fn of(origin: &Origin, path: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Some(origin.clone()), path, message)
    }

    /// The same problem with a hint.
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// The same problem as one of this sort.
    pub(crate) fn sorted(self, sort: Sort) -> Self {
        Self { sort, ..self }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut excerpt = None;
        match &self.origin {
            None => {}
            Some(Origin::Override { text }) => write!(f, "{}: ", printable(&brief(text)))?,
            Some(Origin::File { source, span }) if *span == (0..source.text.len()) => write!(f, "{}: ", source.name)?,
            Some(Origin::File { source, span }) => {
                let (number, line, start) = source.line(span.start);
                // An end of file may lie behind the last character.
                let first = floor_char_boundary(line, span.start - start);
                let end = floor_char_boundary(line, span.end.saturating_sub(start)).max(first);
                write!(f, "{}:{number}:{}: ", source.name, line[..first].chars().count() + 1)?;
                excerpt = Some((number.to_string(), line, first, line[first..end].chars().count().max(1)));
            }
        }
        if !self.path.is_empty() {
            write!(f, "{}: ", brief(&self.path))?;
        }
        f.write_str(&readable_problem(&self.message))?;
        let gutter = " ".repeat(excerpt.as_ref().map_or(1, |(number, ..)| number.len() + 2));
        if let Some((number, line, first, marks)) = excerpt.filter(|(_, line, ..)| line.len() <= LONGEST_EXCERPT) {
            // Tabs stay tabs below the line, or the marks would not be below their text.
            let indent: String =
                line[..first].chars().map(|character| if character == '\t' { '\t' } else { ' ' }).collect();
            write!(f, "\n{gutter}|\n {number} | {}\n{gutter}| {indent}{}", printable(line), "^".repeat(marks))?;
        }
        self.help.as_ref().map_or(Ok(()), |help| write!(f, "\n{gutter}= {}", readable_problem(help)))
    }
}

/// Lines with more bytes were not written by hand and are not shown.
const LONGEST_EXCERPT: usize = 240;

/// The text without characters that would play tricks on a terminal.
fn printable(text: &str) -> String {
    let harmless = |character: char| character == '\t' || !character.is_control();
    text.chars().map(|character| if harmless(character) { character } else { '\u{FFFD}' }).collect()
}

/// All mistakes found so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems {
    list: Vec<Problem>,
}

impl Problems {
    /// Adds a problem.
    pub fn push(&mut self, problem: Problem) {
        self.list.push(problem);
    }

    /// Adds a problem of the field at `path` below `root`, with the origin of that field or, if it does not exist, of
    /// the closest table around it. The problem is returned so that a hint can be added.
    pub fn at(&mut self, root: &Node, path: &str, message: impl Into<String>) -> &mut Problem {
        self.list.push(Problem::of(&root.closest(path).0.origin, path, message));
        let last = self.list.len() - 1;
        &mut self.list[last]
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// The problems in the order in which they were found.
    pub fn iter(&self) -> std::slice::Iter<'_, Problem> {
        self.list.iter()
    }

    /// The problems in the order in which they were found.
    pub fn into_vec(self) -> Vec<Problem> {
        self.list
    }
}

impl Extend<Problem> for Problems {
    fn extend<I: IntoIterator<Item = Problem>>(&mut self, problems: I) {
        self.list.extend(problems);
    }
}

/// All of them, with an empty line in between.
impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (index, problem) in self.list.iter().enumerate() {
            let gap = if index == 0 { "" } else { "\n\n" };
            write!(f, "{gap}{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}
