//! A tree back to TOML text.

use super::path::{join, key_text, quote};
use super::{Entry, Node, Value};

/// Lists and nested tables stay on one line up to this many bytes.
const LINE: usize = 100;

impl Node {
    /// TOML text that parses to an equal tree: plain values first, then the tables as `[sections]`. Lists stay on one
    /// line if they are short; lists of tables have a line for each table. A node that is no table becomes a value.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        match self.as_table() {
            Some(_) => write_section(self, "", &mut text),
            None => write_inline(self, &mut text),
        }
        text
    }
}

/// Writes the entries of the table `node` whose header, if it has one, has been written already.
fn write_section(node: &Node, path: &str, text: &mut String) {
    let entries = || node.as_table().into_iter().flat_map(|table| table.entries());
    for Entry { key, node, .. } in entries().filter(|entry| !is_section(entry, path)) {
        text.push_str(&key_text(key));
        text.push_str(" = ");
        write_value(node, text);
        text.push('\n');
    }
    for entry in entries().filter(|entry| is_section(entry, path)) {
        if !text.is_empty() {
            text.push('\n');
        }
        let path = join(path, &entry.key);
        text.push_str(&format!("[{path}]\n"));
        write_section(&entry.node, &path, text);
    }
}

/// Top-level tables are sections, deeper ones only if they are too long for a line.
fn is_section(entry: &Entry, path: &str) -> bool {
    entry.node.as_table().is_some() && (path.is_empty() || inline(&entry.node).len() > LINE)
}

/// Writes the value of an entry of a section.
fn write_value(node: &Node, text: &mut String) {
    let Some(elements) = node.as_array() else { return write_inline(node, text) };
    let tables = elements.iter().any(|element| element.as_table().is_some());
    let short = inline(node);
    if !tables && short.len() <= LINE {
        return text.push_str(&short);
    }
    text.push_str("[\n");
    for element in elements {
        text.push_str(&format!("    {},\n", inline(element)));
    }
    text.push(']');
}

fn inline(node: &Node) -> String {
    let mut text = String::new();
    write_inline(node, &mut text);
    text
}

fn write_inline(node: &Node, text: &mut String) {
    match &node.value {
        Value::Bool(value) => text.push_str(&value.to_string()),
        Value::Integer(value) => text.push_str(&value.to_string()),
        Value::Float(value) if value.is_nan() => text.push_str("nan"),
        // The shortest digits that give the same bits, always with a point or an exponent.
        Value::Float(value) => text.push_str(&format!("{value:?}")),
        Value::String(value) => text.push_str(&quote(value)),
        Value::Array(elements) => {
            text.push('[');
            for (index, element) in elements.iter().enumerate() {
                text.push_str(if index == 0 { "" } else { ", " });
                write_inline(element, text);
            }
            text.push(']');
        }
        Value::Table(table) if table.is_empty() => text.push_str("{}"),
        Value::Table(table) => {
            for (index, entry) in table.entries().iter().enumerate() {
                text.push_str(if index == 0 { "{ " } else { ", " });
                text.push_str(&format!("{} = ", key_text(&entry.key)));
                write_inline(&entry.node, text);
            }
            text.push_str(" }");
        }
    }
}
