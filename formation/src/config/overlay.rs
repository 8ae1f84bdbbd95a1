//! Variants and `--set`.

use super::node::element_index;
use super::path::{join, split};
use super::{DEPTH_LIMIT, Node, Origin, Problem, Sort, Table, Value};

/// The key that says which component a table describes.
pub(super) const KIND: &str = "kind";

impl Node {
    /// Lays `other` over this tree, which should be its root.
    ///
    /// Tables merge, any other value replaces the old one, with two exceptions:
    /// - a table whose `kind` differs replaces the old table, because another component has other parameters;
    /// - a table with the keys `1`, `2`, ... over a list changes those elements, so that a variant may say
    ///   `[variants.TOC.agents.2]`.
    ///
    /// # Errors
    /// The first such element that does not exist.
    pub fn overlay(&mut self, other: Node) -> Result<(), Problem> {
        merge(self, other, "")
    }

    /// Sets the value at a dotted path, as `--set controller.c_p=3` demands.
    ///
    /// Elements of lists are counted from 1 (`agents.2.position` or `agents[2].position`), and `agents.*.position` means
    /// all of them. Tables that do not exist are created: if the path was misspelt, [`read`](super::read) will say so.
    /// The text is taken as [`Node::parse_value`] takes it. If another `kind` is set,
    /// the values that the file gave the old kind are forgotten. `origin` is the argument that messages name.
    ///
    /// # Errors
    /// A malformed path, an element that does not exist, or a field of something that has none.
    pub fn set(&mut self, path: &str, value_text: &str, origin: &Origin) -> Result<(), Problem> {
        let segments = split(path).map_err(|message| Problem::of(origin, "", message))?;
        if segments.len() > DEPTH_LIMIT {
            return Err(Problem::of(origin, "", format!("a path of more than {DEPTH_LIMIT} levels")));
        }
        let value = Node::parse_value_at(value_text, origin, segments.len());
        assign(self, &segments, "", &value)
    }
}

fn merge(base: &mut Node, other: Node, path: &str) -> Result<(), Problem> {
    let Node { value, origin } = other;
    match (&mut base.value, value) {
        (Value::Table(old), Value::Table(new)) if !another_kind(old, new.get(KIND)) => {
            for entry in new {
                match old.entry_mut(&entry.key) {
                    Some(present) => {
                        let path = join(path, &entry.key);
                        present.key_origin = entry.key_origin;
                        merge(&mut present.node, entry.node, &path)?;
                    }
                    None => _ = old.insert_entry(entry),
                }
            }
        }
        (Value::Array(elements), Value::Table(new)) if numbers_elements(&new) => {
            for entry in new {
                let path = join(path, &entry.key);
                let element = element(elements, &entry.key);
                let element = element.map_err(|message| Problem::of(&entry.key_origin, &path, message))?;
                merge(element, entry.node, &path)?;
            }
        }
        (_, value) => *base = Node { value, origin },
    }
    Ok(())
}

/// Whether `kind` says that a table now describes another component than `old`.
fn another_kind(old: &Table, kind: Option<&Node>) -> bool {
    matches!((old.get(KIND), kind), (Some(old), Some(new)) if old != new)
}

fn numbers_elements(table: &Table) -> bool {
    let is_number = |key: &str| !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_digit());
    !table.is_empty() && table.entries().iter().all(|entry| is_number(&entry.key))
}

/// The element that a path calls `number`.
fn element<'a>(elements: &'a mut [Node], number: &str) -> Result<&'a mut Node, String> {
    let count = elements.len();
    let found = element_index(number).and_then(|index| elements.get_mut(index));
    found.ok_or_else(|| match count {
        0 => format!("there is no element {number}: the list is empty"),
        1 => format!("there is no element {number}: the list has 1 element"),
        _ => format!("there is no element {number}: the list has {count} elements, counted from 1"),
    })
}

fn assign(target: &mut Node, segments: &[String], path: &str, value: &Node) -> Result<(), Problem> {
    let Some((segment, rest)) = segments.split_first() else {
        *target = value.clone();
        return Ok(());
    };
    let described = target.describe();
    let here = join(path, segment);
    match &mut target.value {
        Value::Array(elements) if segment == "*" => {
            elements.iter_mut().zip(1..).try_for_each(|(element, number): (_, usize)| {
                assign(element, rest, &join(path, &number.to_string()), value)
            })
        }
        Value::Array(elements) => {
            let element = element(elements, segment)
                .map_err(|message| Problem::of(&value.origin, &here, message).sorted(Sort::Unknown))?;
            assign(element, rest, &here, value)
        }
        Value::Table(table) => {
            if rest.is_empty() && segment == KIND && another_kind(table, Some(value)) {
                // What the command line said is meant for the new kind, in whatever order.
                table.retain(|entry| entry.key == KIND || matches!(entry.key_origin, Origin::Override { .. }));
            }
            if rest.is_empty() {
                table.insert(segment, value.clone());
                return Ok(());
            }
            if table.get(segment).is_none() {
                table.insert(segment, Node { value: Value::Table(Table::default()), origin: value.origin.clone() });
            }
            table.get_mut(segment).map_or(Ok(()), |next| assign(next, rest, &here, value))
        }
        _ => {
            let message = format!("{path} is {described}, which has no fields");
            Err(Problem::of(&value.origin, here, message).sorted(Sort::Unknown))
        }
    }
}
