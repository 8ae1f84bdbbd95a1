//! Messages of ROS 2: definitions in the form `ros2msg`, and the numbers in messages as CDR.
//!
//! A path becomes a plan, once: what to skip, and what to enter.

use std::collections::BTreeMap;

use super::path::{Found, Part, mismatch, place};
use crate::formula::DataError;
use crate::text::brief;

/// Most levels of messages in messages.
const DEEPEST: usize = 64;

/// How to get from the start of a message to a number in it.
#[derive(Debug)]
pub(super) struct Plan {
    steps: Vec<Step>,
    number: Number,
    types: Vec<Type>,
}

#[derive(Debug)]
enum Step {
    /// Past a field.
    Skip(Kind, Shape),
    /// To an element of an array, which stands at this place of the message.
    Enter(Kind, Shape, usize, String),
}

/// A message type.
#[derive(Debug)]
struct Type {
    fields: Vec<Field>,
    /// Levels of messages from here on.
    levels: usize,
}

#[derive(Debug)]
struct Field {
    name: String,
    kind: Kind,
    shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Number(Number),
    Text,
    /// Implementations differ in how they encode it.
    WideText,
    /// The type at this place.
    Message(usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    One,
    Array(usize),
    Sequence,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Plan {
    /// The plan for a field of the messages on `topic`, whose type is called `name` and defined by `text`.
    ///
    /// # Errors
    /// Says what is wrong with the definition, or that it has no such number.
    pub(super) fn new(topic: &str, name: &str, text: &str, path: &[Part]) -> Result<Self, DataError> {
        let mut definitions = Definitions::new(name, text);
        let root = definitions.resolve(&short(name), 1).map_err(DataError::File)?;
        let types = definitions.types;
        let mut steps = Vec::new();
        // What stands at the place that the path has come to.
        let mut at = (Kind::Message(root), Shape::One);
        for (depth, part) in path.iter().enumerate() {
            let here = || place(topic, &path[..depth]);
            let next = match (at, part) {
                ((Kind::Message(index), Shape::One), Part::Name(name)) => {
                    let fields = &types[index].fields;
                    fields.iter().position(|field| field.name == *name).map(|position| {
                        steps.extend(fields[..position].iter().map(|field| Step::Skip(field.kind, field.shape)));
                        (fields[position].kind, fields[position].shape)
                    })
                }
                ((kind, shape), Part::Index(index)) if shape.may_have(*index) => {
                    steps.push(Step::Enter(kind, shape, *index, here()));
                    Some((kind, Shape::One))
                }
                _ => None,
            };
            at = next.ok_or_else(|| DataError::Column(mismatch(&here(), &found(at, &types), Some(part))))?;
        }
        match at {
            (Kind::Number(number), Shape::One) => Ok(Self { steps, number, types }),
            at => Err(DataError::Column(mismatch(&place(topic, path), &found(at, &types), None))),
        }
    }

    /// The number in a message.
    ///
    /// # Errors
    /// Says what is wrong with the message, or that an array is too short.
    pub(super) fn number(&self, message: &[u8]) -> Result<f64, DataError> {
        let mut reader = Cdr::new(message).map_err(DataError::File)?;
        for step in &self.steps {
            match step {
                Step::Skip(kind, shape) => {
                    let count = reader.count(*shape).map_err(DataError::File)?;
                    self.skip(&mut reader, *kind, count).map_err(DataError::File)?;
                }
                Step::Enter(kind, shape, index, place) => {
                    let count = reader.count(*shape).map_err(DataError::File)?;
                    if *index >= count {
                        let wanted = Part::Index(*index);
                        return Err(DataError::Column(mismatch(place, &Found::Array(Some(count)), Some(&wanted))));
                    }
                    self.skip(&mut reader, *kind, *index).map_err(DataError::File)?;
                }
            }
        }
        reader.number(self.number).map_err(DataError::File)
    }

    /// Skips `count` values. Each has a byte at least, so that this ends with the message.
    fn skip(&self, reader: &mut Cdr, kind: Kind, count: usize) -> Result<(), String> {
        match kind {
            Kind::Number(number) if count > 0 => {
                reader.align(number.size());
                reader.take(number.size().saturating_mul(count))?;
            }
            Kind::Number(_) => {}
            Kind::Text => {
                for _ in 0..count {
                    let length = reader.length()?;
                    reader.take(length)?;
                }
            }
            Kind::WideText => {
                for _ in 0..count {
                    if reader.length()? > 0 {
                        return Err("a wstring stands before the field, and its encoding is not defined".into());
                    }
                }
            }
            Kind::Message(index) => {
                for _ in 0..count {
                    for field in &self.types[index].fields {
                        let count = reader.count(field.shape)?;
                        self.skip(reader, field.kind, count)?;
                    }
                }
            }
        }
        Ok(())
    }
}

impl Shape {
    /// Whether it is an array that may have an element of this index.
    fn may_have(self, index: usize) -> bool {
        match self {
            Shape::One => false,
            Shape::Array(count) => index < count,
            Shape::Sequence => true,
        }
    }
}

fn found((kind, shape): (Kind, Shape), types: &[Type]) -> Found<'_> {
    match (shape, kind) {
        (Shape::Array(count), _) => Found::Array(Some(count)),
        (Shape::Sequence, _) => Found::Array(None),
        (Shape::One, Kind::Number(_)) => Found::Number,
        (Shape::One, Kind::Text | Kind::WideText) => Found::Text,
        (Shape::One, Kind::Message(index)) => {
            Found::Message(types[index].fields.iter().map(|field| field.name.as_str()).collect())
        }
    }
}

impl Number {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "bool" => Self::Bool,
            "int8" => Self::I8,
            "uint8" | "byte" | "char" => Self::U8,
            "int16" => Self::I16,
            "uint16" => Self::U16,
            "int32" => Self::I32,
            "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float32" => Self::F32,
            "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// A message while it is read.
struct Cdr<'a> {
    /// Behind the encapsulation.
    bytes: &'a [u8],
    at: usize,
    is_big_endian: bool,
}

impl<'a> Cdr<'a> {
    fn new(message: &'a [u8]) -> Result<Self, String> {
        let (encapsulation, bytes) = message.split_first_chunk::<4>().ok_or("it has no encapsulation header")?;
        match u16::from_be_bytes([encapsulation[0], encapsulation[1]]) {
            kind @ (0 | 1) => Ok(Self { bytes, at: 0, is_big_endian: kind == 0 }),
            kind => {
                let name = if (0x0006..=0x000b).contains(&kind) { " (XCDR2)" } else { "" };
                Err(format!("expected plain CDR, with the encapsulation 0x0000 or 0x0001, found 0x{kind:04x}{name}"))
            }
        }
    }

    fn align(&mut self, size: usize) {
        self.at = self.at.next_multiple_of(size);
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let taken = self.bytes.get(self.at..).and_then(|rest| rest.get(..count)).ok_or_else(|| {
            let (at, length) = (self.at, self.bytes.len());
            format!("expected {count} bytes at byte {at} of its data, which has {length}")
        })?;
        self.at += count;
        Ok(taken)
    }

    fn take_number<const SIZE: usize>(&mut self) -> Result<[u8; SIZE], String> {
        self.align(SIZE);
        let mut bytes = [0; SIZE];
        bytes.copy_from_slice(self.take(SIZE)?);
        if self.is_big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn length(&mut self) -> Result<usize, String> {
        Ok(u32::from_le_bytes(self.take_number()?) as usize)
    }

    /// The number of values of this shape.
    fn count(&mut self, shape: Shape) -> Result<usize, String> {
        match shape {
            Shape::One => Ok(1),
            Shape::Array(count) => Ok(count),
            Shape::Sequence => self.length(),
        }
    }

    fn number(&mut self, number: Number) -> Result<f64, String> {
        Ok(match number {
            Number::Bool => f64::from(u8::from(self.take_number::<1>()? != [0])),
            Number::I8 => i8::from_le_bytes(self.take_number()?).into(),
            Number::U8 => u8::from_le_bytes(self.take_number()?).into(),
            Number::I16 => i16::from_le_bytes(self.take_number()?).into(),
            Number::U16 => u16::from_le_bytes(self.take_number()?).into(),
            Number::I32 => i32::from_le_bytes(self.take_number()?).into(),
            Number::U32 => u32::from_le_bytes(self.take_number()?).into(),
            Number::I64 => i64::from_le_bytes(self.take_number()?) as f64,
            Number::U64 => u64::from_le_bytes(self.take_number()?) as f64,
            Number::F32 => f32::from_le_bytes(self.take_number()?).into(),
            Number::F64 => f64::from_le_bytes(self.take_number()?),
        })
    }
}

/// The types of a definition.
struct Definitions<'a> {
    /// The texts, by names such as `geometry_msgs/Twist`.
    texts: BTreeMap<String, &'a str>,
    /// Their places among the types; `None` for those that are being resolved.
    places: BTreeMap<String, Option<usize>>,
    types: Vec<Type>,
}

impl<'a> Definitions<'a> {
    /// Splits the definition of the type `name` at its lines of `=`.
    fn new(name: &str, text: &'a str) -> Self {
        let mut texts = BTreeMap::new();
        let mut name = short(name);
        let mut rest = text;
        loop {
            let is_ruler = |line: &str| line.starts_with("===") && line.trim_end().bytes().all(|byte| byte == b'=');
            let mut end = 0;
            let ruler = rest.split_inclusive('\n').find(|line| {
                end += line.len();
                is_ruler(line)
            });
            texts.entry(name).or_insert(&rest[..end - ruler.map_or(0, str::len)]);
            if ruler.is_none() {
                return Self { texts, places: BTreeMap::new(), types: Vec::new() };
            }
            let section = rest[end..].trim_start();
            let (head, body) = section.split_once('\n').unwrap_or((section, ""));
            name = short(head.trim().trim_start_matches("MSG:").trim());
            rest = body;
        }
    }

    /// The place of the type of this name, on this level of messages.
    fn resolve(&mut self, name: &str, level: usize) -> Result<usize, String> {
        let wrong = |what: &str| format!("the definition of `{}` {what}", brief(name));
        match self.places.get(name) {
            Some(Some(place)) => return Ok(*place),
            Some(None) => return Err(wrong("contains itself")),
            None if level > DEEPEST => return Err(wrong("is too deep in others")),
            None => {}
        }
        self.places.insert(name.into(), None);
        let text = match self.texts.get(name) {
            Some(text) => *text,
            None if is_time(name) => "int32 sec\nuint32 nanosec",
            None => return Err(wrong("is missing in the file")),
        };
        let package = name.split('/').next().unwrap_or_default();
        let mut fields = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let unreadable = || wrong(&format!("has a line that is no field: \"{}\"", brief(line)));
            let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(unreadable)?;
            let rest = rest.trim_start();
            let end = rest.find(|c: char| c.is_whitespace() || c == '=').unwrap_or(rest.len());
            let (field, behind) = rest.split_at(end);
            // A constant, which messages do not contain. A default value has no `=` before it.
            if behind.trim_start().starts_with('=') {
                continue;
            }
            let (base, shape) = shape(kind).ok_or_else(unreadable)?;
            fields.push(Field { name: field.into(), kind: self.kind(base, package, level)?, shape });
        }
        if fields.is_empty() {
            // IDL knows no empty message.
            let name = "structure_needs_at_least_one_member".into();
            fields.push(Field { name, kind: Kind::Number(Number::U8), shape: Shape::One });
        }
        let below = fields.iter().map(|field| match field.kind {
            Kind::Message(place) => self.types[place].levels,
            _ => 0,
        });
        let levels = 1 + below.max().unwrap_or(0);
        if levels > DEEPEST {
            return Err(wrong("has too many levels of others"));
        }
        let place = self.types.len();
        self.types.push(Type { fields, levels });
        self.places.insert(name.into(), Some(place));
        Ok(place)
    }

    /// The kind of a field, without `[]`, in a message of this package.
    fn kind(&mut self, name: &str, package: &str, level: usize) -> Result<Kind, String> {
        if let Some(number) = Number::of(name) {
            return Ok(Kind::Number(number));
        }
        let nested = match name.split_once("<=").map_or(name, |(name, _)| name) {
            "string" => return Ok(Kind::Text),
            "wstring" => return Ok(Kind::WideText),
            _ if name.contains('/') => short(name),
            _ => format!("{package}/{name}"),
        };
        let is_header = name == "Header" && !self.texts.contains_key(&nested);
        let nested = if is_header { "std_msgs/Header".into() } else { nested };
        Ok(Kind::Message(self.resolve(&nested, level + 1)?))
    }
}

/// Whether this type, or one that a definition calls `time` or `duration`, is known without its definition.
fn is_time(name: &str) -> bool {
    matches!(name, "builtin_interfaces/Time" | "builtin_interfaces/Duration")
        || name.ends_with("/time")
        || name.ends_with("/duration")
}

/// `geometry_msgs/Twist` for `geometry_msgs/msg/Twist`.
fn short(name: &str) -> String {
    match (name.split_once('/'), name.rsplit_once('/')) {
        (Some((package, _)), Some((_, name))) => format!("{package}/{name}"),
        _ => name.into(),
    }
}

/// Splits `float64[3]`.
fn shape(kind: &str) -> Option<(&str, Shape)> {
    let Some(inner) = kind.strip_suffix(']') else { return Some((kind, Shape::One)) };
    let (base, length) = inner.split_once('[')?;
    let shape = match length.strip_prefix("<=") {
        None if length.is_empty() => Shape::Sequence,
        Some(bound) => bound.parse::<usize>().ok().map(|_| Shape::Sequence)?,
        None => Shape::Array(length.parse().ok().filter(|length| *length > 0)?),
    };
    Some((base, shape))
}
