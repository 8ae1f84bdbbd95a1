//! The path of a field in a message.

use std::fmt;

use serde_json::Value;

use crate::formula::DataError;
use crate::text::{brief, did_you_mean};

/// A step of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Name(String),
    Index(usize),
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Part::Name(name) => write!(f, ".{name}"),
            Part::Index(index) => write!(f, "[{index}]"),
        }
    }
}

/// What stands at a place of a message.
pub(super) enum Found<'a> {
    Number,
    Text,
    Null,
    /// With these fields.
    Message(Vec<&'a str>),
    /// Of so many elements, as far as they are known.
    Array(Option<usize>),
}

/// The parts of `a.b[0].c`.
///
/// # Errors
/// Says what is wrong.
pub(super) fn parse(text: &str) -> Result<Vec<Part>, String> {
    let mut parts = Vec::new();
    for piece in text.split('.') {
        let (name, indices) = piece.find('[').map_or((piece, ""), |place| piece.split_at(place));
        let wrong = || {
            format!("expected a field such as `position[0]` or `linear.x` behind the topic, found `{}`", brief(text))
        };
        if name.is_empty() || name.contains(']') {
            return Err(wrong());
        }
        parts.push(Part::Name(name.into()));
        let mut rest = indices;
        while !rest.is_empty() {
            let (digits, behind) = rest.strip_prefix('[').and_then(|rest| rest.split_once(']')).ok_or_else(wrong)?;
            let is_number = digits.bytes().all(|digit| digit.is_ascii_digit());
            let index = digits.parse().ok().filter(|_| is_number).ok_or_else(wrong)?;
            parts.push(Part::Index(index));
            rest = behind;
        }
    }
    Ok(parts)
}

/// A place as a formula names it.
pub(super) fn place(topic: &str, parts: &[Part]) -> String {
    parts.iter().fold(topic.to_string(), |text, part| text + &part.to_string())
}

/// Why the path does not go on, or ends, at `place`.
pub(super) fn mismatch(place: &str, found: &Found, wanted: Option<&Part>) -> String {
    let place = brief(place);
    let what = match found {
        Found::Number => "a number".into(),
        Found::Text => "a text".into(),
        Found::Null => "null".into(),
        Found::Message(fields) if fields.is_empty() => "a message without fields".into(),
        Found::Message(fields) => format!("a message with the fields {}", brief(&fields.join(", "))),
        Found::Array(None) => "an array".into(),
        Found::Array(Some(count)) => format!("an array of {count}"),
    };
    match (found, wanted) {
        (Found::Message(fields), Some(Part::Name(name))) if !fields.is_empty() => {
            let hint = did_you_mean(name, fields.iter().copied());
            let all = brief(&fields.join(", "));
            format!("no field of `{place}` is called `{}`, expected one of {all}{hint}", brief(name))
        }
        (Found::Array(Some(count)), Some(Part::Index(index))) => {
            format!("`{place}` is {what}, expected an index below {count}, found {index}")
        }
        (Found::Array(_), _) => format!("`{place}` is {what}, expected an index such as `{place}[0]`"),
        (_, Some(Part::Name(name))) => format!("`{place}` is {what}, it has no field `{}`", brief(name)),
        (_, Some(Part::Index(_))) => format!("`{place}` is {what}, expected an array before an index"),
        (_, None) => format!("`{place}` is {what}, expected a number"),
    }
}

/// The number at a place of a message in JSON.
///
/// # Errors
/// Says what is wrong with the message, or what stands there.
pub(super) fn json_number(data: &[u8], topic: &str, parts: &[Part]) -> Result<f64, DataError> {
    let root: Value = serde_json::from_slice(data).map_err(|error| DataError::File(error.to_string()))?;
    let mut at = &root;
    for (depth, part) in parts.iter().enumerate() {
        let next = match part {
            Part::Name(name) => at.as_object().and_then(|object| object.get(name)),
            Part::Index(index) => at.as_array().and_then(|array| array.get(*index)),
        };
        let error = || DataError::Column(mismatch(&place(topic, &parts[..depth]), &found(at), Some(part)));
        at = next.ok_or_else(error)?;
    }
    match at {
        Value::Number(number) if number.as_f64().is_some() => Ok(number.as_f64().unwrap_or(f64::NAN)),
        Value::Bool(bit) => Ok(f64::from(u8::from(*bit))),
        _ => Err(DataError::Column(mismatch(&place(topic, parts), &found(at), None))),
    }
}

fn found(value: &Value) -> Found<'_> {
    match value {
        Value::Null => Found::Null,
        Value::Bool(_) | Value::Number(_) => Found::Number,
        Value::String(_) => Found::Text,
        Value::Array(array) => Found::Array(Some(array.len())),
        Value::Object(object) => Found::Message(object.keys().map(String::as_str).collect()),
    }
}
