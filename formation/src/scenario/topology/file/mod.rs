//! Files with the links of a graph.

mod graphml;
mod list;
mod nodes;
mod table;

use std::ops::Range;
use std::path::Path;

/// A link in a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FileLink {
    /// Number of the sender, from 1.
    pub(super) from: u64,
    /// Number of the receiver.
    pub(super) to: u64,
    /// Its weight, if the file gives one.
    pub(super) weight: Option<f64>,
    /// Where it stands in the file.
    pub(super) span: Range<usize>,
}

/// What a file says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GraphFile {
    /// The links in their order.
    pub(super) links: Vec<FileLink>,
    /// Whether links go one way, if the file says so.
    pub(super) directed: Option<bool>,
    /// Number of nodes, if the file lists all of them.
    pub(super) nodes: Option<usize>,
}

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    /// Where.
    pub(super) span: Range<usize>,
    /// What.
    pub(super) message: String,
    /// What would be right.
    pub(super) help: Option<String>,
}

impl Wrong {
    fn new(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { span, message: message.into(), help: None }
    }

    fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}

/// Reads the file of this name: GraphML, CSV, or else a list of links.
pub(super) fn parse(path: &Path, text: &str) -> Result<GraphFile, Wrong> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("graphml" | "xml") => graphml::parse(text),
        Some("csv") => table::parse(text),
        _ => list::parse(text),
    }
}

/// The weight that a word of a file is.
fn weight(word: &str, span: Range<usize>) -> Result<f64, Wrong> {
    let found = word.parse::<f64>().ok().filter(|weight| weight.is_finite() && *weight >= 0.0);
    found.ok_or_else(|| Wrong::new(span, format!("expected a weight >= 0, found `{}`", crate::config::brief(word))))
}
