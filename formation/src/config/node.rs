//! The tree a scenario is parsed into.

use std::collections::BTreeSet;

use super::path::{join, split};
use super::{Origin, Table};

/// A value and where it was written.
///
/// Two nodes are equal if their values are, wherever they come from.
#[derive(Clone, Debug)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// Where it was written; for a table with a header, the header.
    pub origin: Origin,
}

/// What TOML can express, except dates.
#[derive(Clone, Debug)]
pub enum Value {
    /// `true` or `false`.
    Bool(bool),
    /// A number without fraction or exponent.
    Integer(i64),
    /// Any other number. All not-a-numbers are equal, and the two zeros differ.
    Float(f64),
    /// Text.
    String(String),
    /// A list.
    Array(Vec<Node>),
    /// A table.
    Table(Table),
}

impl Node {
    /// The value at a dotted path below this one, `agents.2.position` (elements are counted from 1). The empty path is
    /// the node itself.
    pub fn at(&self, path: &str) -> Option<&Node> {
        let (node, complete) = self.closest(path);
        complete.then_some(node)
    }

    /// The value at a dotted path below this one, to be changed.
    pub fn at_mut(&mut self, path: &str) -> Option<&mut Node> {
        let mut node = self;
        for segment in segments(path) {
            node = match &mut node.value {
                Value::Table(table) => table.get_mut(&segment)?,
                Value::Array(elements) => elements.get_mut(element_index(&segment)?)?,
                _ => return None,
            };
        }
        Some(node)
    }

    /// The last value along a dotted path that exists, and whether that is the end of the path.
    pub(super) fn closest(&self, path: &str) -> (&Node, bool) {
        let mut node = self;
        for segment in segments(path) {
            let next = match &node.value {
                Value::Table(table) => table.get(&segment),
                Value::Array(elements) => element_index(&segment).and_then(|index| elements.get(index)),
                _ => None,
            };
            match next {
                Some(next) => node = next,
                None => return (node, false),
            }
        }
        (node, true)
    }

    /// A value that the command line gives; `text` is what messages call it, `--set controller.c_p=3`.
    pub fn from_override(value: Value, text: &str) -> Node {
        Node { value, origin: Origin::argument(text) }
    }

    /// The integer, if it is one.
    pub fn as_i64(&self) -> Option<i64> {
        match self.value {
            Value::Integer(value) => Some(value),
            _ => None,
        }
    }

    /// The number, if it is one, integer or not.
    pub fn as_f64(&self) -> Option<f64> {
        match self.value {
            Value::Integer(value) => Some(value as f64),
            Value::Float(value) => Some(value),
            _ => None,
        }
    }

    /// The table, if it is one.
    pub fn as_table(&self) -> Option<&Table> {
        match &self.value {
            Value::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The table, to be changed, if it is one.
    pub fn as_table_mut(&mut self) -> Option<&mut Table> {
        match &mut self.value {
            Value::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The elements of the list, if it is one.
    pub fn as_array(&self) -> Option<&[Node]> {
        match &self.value {
            Value::Array(elements) => Some(elements),
            _ => None,
        }
    }

    /// The elements of the list, to be changed, if it is one.
    pub fn as_array_mut(&mut self) -> Option<&mut Vec<Node>> {
        match &mut self.value {
            Value::Array(elements) => Some(elements),
            _ => None,
        }
    }

    /// The text, if it is a string.
    pub fn as_str(&self) -> Option<&str> {
        match &self.value {
            Value::String(text) => Some(text),
            _ => None,
        }
    }

    /// What it is, for a message: `the string "two"`, `a list of 3 values`.
    pub fn describe(&self) -> String {
        const SHOWN: usize = 40;
        match &self.value {
            Value::Bool(value) => format!("the boolean {value}"),
            Value::Integer(value) => format!("the integer {value}"),
            Value::Float(value) => format!("the number {value:?}"),
            Value::String(text) if text.chars().count() <= SHOWN => format!("the string {text:?}"),
            Value::String(text) => format!("the string {:?}...", text.chars().take(SHOWN).collect::<String>()),
            Value::Array(elements) if elements.len() == 1 => "a list of 1 value".into(),
            Value::Array(elements) => format!("a list of {} values", elements.len()),
            Value::Table(_) => "a table".into(),
        }
    }

    /// Dotted paths of all keys called `name` whose values are no tables, so that `--set phase=1` can be taken as
    /// `parameters.phase`.
    ///
    /// Lists are not searched, except the list `agents`: a field that any agent has is reported once, as
    /// `agents.*.name`, which [`Node::set`] understands.
    pub fn find_leaf(&self, name: &str) -> Vec<String> {
        let mut found = Vec::new();
        self.visit_leaves("", &mut |key, path| {
            if key == name && !found.contains(&path) {
                found.push(path);
            }
        });
        found
    }

    /// The names that [`Node::find_leaf`] finds, each once, in alphabetical order.
    pub fn leaf_names(&self) -> Vec<String> {
        let mut names = BTreeSet::new();
        self.visit_leaves("", &mut |key, _| _ = names.insert(key.to_string()));
        names.into_iter().collect()
    }

    /// All texts in it, in order.
    pub(crate) fn texts(&self) -> Vec<&str> {
        match &self.value {
            Value::String(text) => vec![text],
            Value::Array(items) => items.iter().flat_map(Self::texts).collect(),
            Value::Table(table) => table.iter().flat_map(|(_, node)| node.texts()).collect(),
            _ => Vec::new(),
        }
    }

    fn visit_leaves(&self, path: &str, visit: &mut dyn FnMut(&str, String)) {
        for (key, node) in self.as_table().into_iter().flat_map(Table::iter) {
            let here = join(path, key);
            match &node.value {
                Value::Table(_) => node.visit_leaves(&here, visit),
                Value::Array(agents) if here == "agents" => {
                    visit(key, here);
                    agents.iter().for_each(|agent| agent.visit_leaves("agents.*", visit));
                }
                _ => visit(key, here),
            }
        }
    }
}

/// The segments of a path; what cannot be split is taken for the name of one field, which will not be found.
fn segments(path: &str) -> Vec<String> {
    if path.is_empty() { Vec::new() } else { split(path).unwrap_or_else(|_| vec![path.into()]) }
}

/// The index of the element that a path calls `segment`: paths count from 1.
pub(super) fn element_index(segment: &str) -> Option<usize> {
    segment.bytes().all(|byte| byte.is_ascii_digit()).then(|| segment.parse::<usize>().ok()?.checked_sub(1)).flatten()
}

impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl Eq for Node {}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Value::Bool(a), Value::Bool(b)) => a == b,
            (Value::Integer(a), Value::Integer(b)) => a == b,
            (Value::Float(a), Value::Float(b)) => a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(),
            (Value::String(a), Value::String(b)) => a == b,
            (Value::Array(a), Value::Array(b)) => a == b,
            (Value::Table(a), Value::Table(b)) => a == b,
            _ => false,
        }
    }
}

impl Eq for Value {}
