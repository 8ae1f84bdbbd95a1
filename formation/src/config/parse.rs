//! TOML text to a tree.

use std::ops::Range;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::path::join;
use super::{DEPTH_LIMIT, Entry, Node, Origin, Problem, Source, Value};

/// Scenarios have a few kilobytes.
pub(super) const SIZE_LIMIT: usize = 4 << 20;

impl Node {
    /// Parses a file.
    ///
    /// # Errors
    /// The first violation of TOML, with line and column; files over 4 MB, nesting deeper than 32 levels, dates, and
    /// numbers that do not fit into 64 bits.
    pub fn parse(source: Arc<Source>) -> Result<Node, Problem> {
        let length = source.text.len();
        let whole = Origin::File { source: source.clone(), span: 0..length };
        if length > SIZE_LIMIT {
            let megabytes = length as f64 / f64::from(1 << 20);
            return Err(Problem::of(&whole, "", format!("a scenario of {megabytes:.1} MB; at most 4 MB are read")));
        }
        let origin = |span: Range<usize>| Origin::File { source: source.clone(), span };
        on_large_stack(&whole, || {
            let table = DeTable::parse(&source.text).map_err(|error| {
                let origin = error.span().map_or_else(|| whole.clone(), origin);
                Problem::of(&origin, "", format!("not valid TOML: {}", error.message()))
            })?;
            let mut root = convert(DeValue::Table(table.into_inner()), 0..length, "", 0, &origin)?;
            root.origin = whole.clone();
            Ok(root)
        })
    }

    /// The value of an override: what [`Node::parse`] would not accept as a value is text without quotes, like the `TOC`
    /// in `variant=TOC`. `origin` is the argument that messages name.
    pub fn parse_value(text: &str, origin: &Origin) -> Node {
        Self::parse_value_at(text, origin, 0)
    }

    /// The value of an override that will stand `depth` levels deep.
    pub(super) fn parse_value_at(text: &str, origin: &Origin, depth: usize) -> Node {
        let plain = || Node { value: Value::String(text.into()), origin: origin.clone() };
        if text.len() > SIZE_LIMIT {
            return plain();
        }
        let parsed = on_large_stack(origin, || {
            let value = DeValue::parse(text.trim()).map_err(|error| Problem::of(origin, "", error.message()))?;
            convert(value.into_inner(), 0..0, "", depth, &|_| origin.clone())
        });
        parsed.unwrap_or_else(|_| plain())
    }
}

/// Runs `parse` in a thread of its own.
///
/// The parser admits dotted keys of 80 segments in inline tables nested 80 deep. It drops those 6400 levels recursively,
/// which takes more stack than the caller may have.
fn on_large_stack(origin: &Origin, parse: impl FnOnce() -> Result<Node, Problem> + Send) -> Result<Node, Problem> {
    const STACK: usize = 64 << 20;
    let failed = |what: &str| Problem::of(origin, "", format!("cannot parse: {what}"));
    std::thread::scope(|scope| match std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, parse) {
        Ok(thread) => thread.join().unwrap_or_else(|_| Err(failed("the parser broke down"))),
        Err(error) => Err(failed(&format!(
            "the system starts no thread for it: {error}; `ulimit -u` limits threads, `ulimit -v` memory"
        ))),
    })
}

fn convert(
    value: DeValue,
    span: Range<usize>,
    path: &str,
    depth: usize,
    origin: &impl Fn(Range<usize>) -> Origin,
) -> Result<Node, Problem> {
    let refuse = |message: String| Err(Problem::of(&origin(span.clone()), path, message));
    if depth > DEPTH_LIMIT {
        return refuse(format!("nested more than {DEPTH_LIMIT} levels deep"));
    }
    let converted = match value {
        DeValue::Boolean(value) => Value::Bool(value),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(value) => Value::Integer(value),
            Err(_) => return refuse(format!("the integer {integer} does not fit into 64 bits")),
        },
        DeValue::Float(float) => match float.as_str().parse::<f64>() {
            Ok(value) if value.is_finite() || !float.as_str().contains(|c: char| c.is_ascii_digit()) => {
                Value::Float(value)
            }
            _ => return refuse(format!("the number {float} is out of range")),
        },
        DeValue::String(text) => Value::String(text.into_owned()),
        DeValue::Datetime(_) => {
            return refuse("dates and times have no use in a scenario; put text in quotes".into());
        }
        DeValue::Array(elements) => {
            let convert_element = |(index, element): (usize, Spanned<DeValue>)| {
                let span = element.span();
                convert(element.into_inner(), span, &join(path, &(index + 1).to_string()), depth + 1, origin)
            };
            Value::Array(elements.into_iter().enumerate().map(convert_element).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => {
            let mut entries: Vec<_> = table.into_iter().collect();
            // The parser sorts by name; readers expect the order of the file.
            entries.sort_by_key(|(key, _)| key.span().start);
            let convert_entry = |(key, value): (Spanned<std::borrow::Cow<str>>, Spanned<DeValue>)| {
                let (key_span, span) = (key.span(), value.span());
                let key = key.into_inner().into_owned();
                let node = convert(value.into_inner(), span, &join(path, &key), depth + 1, origin)?;
                Ok(Entry { key, key_origin: origin(key_span), node })
            };
            Value::Table(entries.into_iter().map(convert_entry).collect::<Result<_, _>>()?)
        }
    };
    Ok(Node { value: converted, origin: origin(span) })
}
