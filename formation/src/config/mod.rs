//! Reading scenario files.
//!
//! A scenario is a TOML file. It is read in three steps:
//!
//! 1. [`Node::parse`] turns the text into a tree that remembers where every value comes from ([`Origin`]).
//! 2. [`Node::overlay`] lays a variant over it, and [`Node::set`] applies `--set controller.c_p=3`.
//! 3. [`read`] turns the tree, or a part of it, into any type that derives `Deserialize`. It does not stop at the first
//!    mistake, but collects [`Problems`] that name file, line and column, the field, what was expected and the nearest
//!    valid name.
//!
//! [`Node::to_toml`] writes the effective scenario back, [`PerAgent`] is a field that differs between agents, and
//! [`Diagonal`] one that differs between channels.

mod access;
mod diagonal;
mod file;
mod node;
mod ordered;
mod overlay;
mod parse;
mod path;
mod per_agent;
mod problem;
mod read;
mod reader;
mod schema;
mod source;
mod stand_in;
mod table;
mod write;

#[cfg(test)]
mod tests;

pub(crate) use crate::text::around;
pub use crate::text::{brief, did_you_mean, is_signal_name, nearest, readable};
pub use diagonal::Diagonal;
pub(crate) use file::read_bytes;
pub use file::{TextError, read_data, read_text};
pub use node::{Node, Value};
pub use ordered::{FormulaText, FormulaTexts, Ordered};
pub use per_agent::PerAgent;
pub use problem::{Problem, Problems, Sort};
pub use read::read;
pub use schema::number;
pub use source::{Origin, Source};
pub use table::{Entry, Table};

/// How deep a tree may be nested. Scenarios need six levels or so; everything that recurses relies on this limit.
const DEPTH_LIMIT: usize = 32;
