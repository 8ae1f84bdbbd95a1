//! The serde deserializer of a node.

use std::cell::RefCell;

use serde::Deserializer;
use serde::de::{IgnoredAny, MapAccess, Visitor};

use super::access::{Choice, Contents, Elements, Fields};
use super::overlay::KIND;
use super::path::join;
use super::read::{Failure, State, expectation, missing};
use super::{Entry, Node, Problem, Sort, Value, brief};
use crate::formula::Expression;

/// A node to be read, with its path.
pub(super) struct Reader<'a> {
    pub(super) node: &'a Node,
    pub(super) path: String,
    pub(super) state: &'a RefCell<State>,
    /// The `kind` of the table has been read already and is none of its fields.
    pub(super) kind_is_read: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(node: &'a Node, path: String, state: &'a RefCell<State>) -> Self {
        Self { node, path, state, kind_is_read: false }
    }

    fn unexpected(&self, expected: &str) -> Failure {
        serde::de::Error::custom(format!("expected {expected}, found {}", self.node.describe()))
    }

    fn number(&self) -> Result<f64, Failure> {
        match &self.node.value {
            Value::Integer(value) => Ok(*value as f64),
            Value::Float(value) => Ok(*value),
            Value::String(text) => constant(text).map_err(|reason| Failure::Mistake {
                message: format!("expected a number, found {}", self.node.describe()),
                help: Some(format!("as a formula: {reason}")),
            }),
            _ => Err(self.unexpected("a number")),
        }
    }

    /// An integer that its type can hold.
    fn integer<T: TryFrom<i64>>(&self, least: i128, most: i128) -> Result<T, Failure> {
        let Value::Integer(value) = self.node.value else { return Err(self.unexpected("an integer")) };
        let expected = || match (least, most >= i128::from(i64::MAX)) {
            (0, true) => "an integer that is not negative".to_string(),
            _ => format!("an integer from {least} to {most}"),
        };
        T::try_from(value).map_err(|_| self.unexpected(&expected()))
    }

    fn elements(&self, expected: &str) -> Result<&'a [Node], Failure> {
        self.node.as_array().ok_or_else(|| self.unexpected(expected))
    }

    fn fields(&self, expected: Option<&'static [&'static str]>) -> Result<Fields<'a>, Failure> {
        let table = self.node.as_table().ok_or_else(|| match expected {
            Some(fields @ [_, ..]) => self.unexpected(&format!("a table with {}", fields.join(", "))),
            _ => self.unexpected("a table"),
        })?;
        Ok(Fields::new(self, table, expected))
    }

    /// Enums: a string for a variant without data, else a table with a `kind` or with the variant as its only key.
    fn variant(&self, variants: &'static [&'static str]) -> Result<(&'a str, Contents<'a>), Failure> {
        let (name, place, contents) = match &self.node.value {
            Value::String(name) => (name, None, Contents::Name(self.node)),
            Value::Table(table) => match (table.entry(KIND), table.entries()) {
                (Some(Entry { node, .. }), _) => {
                    let Value::String(kind) = &node.value else {
                        let message = format!("expected a name, found {}", node.describe());
                        let problem = Problem::of(&node.origin, join(&self.path, KIND), message);
                        return Err(self.state.borrow_mut().refuse(problem, &self.path));
                    };
                    let contents = Reader { path: self.path.clone(), kind_is_read: true, ..*self };
                    (kind, Some((&node.origin, join(&self.path, KIND))), Contents::Kind(contents))
                }
                (None, [Entry { key, key_origin, node }]) => {
                    let path = join(&self.path, key);
                    let contents = Reader::new(node, path.clone(), self.state);
                    (key, Some((key_origin, path)), Contents::Keyed(contents))
                }
                _ => {
                    let problem = Problem::of(&self.node.origin, &self.path, missing(KIND))
                        .with_help(expectation(variants, ""))
                        .sorted(Sort::Missing);
                    return Err(self.state.borrow_mut().refuse(problem, &self.path));
                }
            },
            _ => return Err(self.unexpected("a name")),
        };
        if !variants.contains(&name.as_str()) {
            let (origin, path) = place.unwrap_or((&self.node.origin, self.path.clone()));
            // A name that is a key stands where a field of the variant might.
            let sort = if matches!(contents, Contents::Keyed(_)) { Sort::Unknown } else { Sort::Other };
            let problem = Problem::of(origin, path, format!("unknown name {:?}", brief(name)))
                .with_help(expectation(variants, name))
                .sorted(sort);
            return Err(self.state.borrow_mut().refuse(problem, &self.path));
        }
        Ok((name, contents))
    }
}

/// The value of a formula without names.
fn constant(text: &str) -> Result<f64, String> {
    let value =
        Expression::parse(text).and_then(|expression| expression.constant()).map_err(|error| error.to_string())?;
    if value.is_finite() { Ok(value) } else { Err(format!("its value is {value}")) }
}

macro_rules! integers {
    ($($method:ident $visit:ident $integer:ty,)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
            visitor.$visit(self.integer::<$integer>(<$integer>::MIN.into(), <$integer>::MAX.into())?)
        }
    )*};
}

impl<'de> Deserializer<'de> for Reader<'_> {
    type Error = Failure;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        match &self.node.value {
            Value::Bool(value) => visitor.visit_bool(*value),
            Value::Integer(value) => visitor.visit_i64(*value),
            Value::Float(value) => visitor.visit_f64(*value),
            Value::String(text) => visitor.visit_str(text),
            Value::Array(elements) => visitor.visit_seq(Elements::new(&self, elements)),
            Value::Table(_) => visitor.visit_map(self.fields(None)?),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        match self.node.value {
            Value::Bool(value) => visitor.visit_bool(value),
            _ => Err(self.unexpected("true or false")),
        }
    }

    integers! {
        deserialize_i8 visit_i8 i8,
        deserialize_i16 visit_i16 i16,
        deserialize_i32 visit_i32 i32,
        deserialize_i64 visit_i64 i64,
        deserialize_u8 visit_u8 u8,
        deserialize_u16 visit_u16 u16,
        deserialize_u32 visit_u32 u32,
        deserialize_u64 visit_u64 u64,
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_f32(self.number()? as f32)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_f64(self.number()?)
    }

    fn deserialize_char<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        match self.node.as_str().map(|text| (text.chars().next(), text.chars().nth(1))) {
            Some((Some(only), None)) => visitor.visit_char(only),
            _ => Err(self.unexpected("a string of one character")),
        }
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        match self.node.as_str() {
            Some(text) => visitor.visit_str(text),
            None => Err(self.unexpected("a string")),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        self.deserialize_str(visitor)
    }

    /// A field that is there is never none: TOML has no word for it.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        let elements = self.elements("a list")?;
        visitor.visit_seq(Elements::new(&self, elements))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Failure> {
        let values = if length == 1 { "value" } else { "values" };
        let elements = self.elements(&format!("a list of {length} {values}"))?;
        if elements.len() != length {
            let message = format!("expected {length} {values}, found {}", elements.len());
            return Err(serde::de::Error::custom(message));
        }
        visitor.visit_seq(Elements::new(&self, elements))
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_map(self.fields(None)?)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        match visitor.visit_map(self.fields(Some(fields))?) {
            Err(Failure::MissingField(field)) if fields.contains(&field) => {
                let place = join(&self.path, field);
                let mut state = self.state.borrow_mut();
                if state.stands_in(&place) {
                    return Err(Failure::MissingField(field));
                }
                let problem = Problem::of(&self.node.origin, &self.path, missing(field)).sorted(Sort::Missing);
                Err(state.refuse(problem, &place))
            }
            result => result,
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let (name, contents) = self.variant(variants)?;
        visitor.visit_enum(Choice { name, contents })
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_unit()
    }

    /// A table without any field, which is what a variant without data has beside its `kind`.
    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        // There is no key to come, but looking for it records those that are too many.
        self.fields(Some(&[]))?.next_key::<IgnoredAny>()?;
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Failure> {
        self.deserialize_unit(visitor)
    }

    serde::forward_to_deserialize_any! { bytes byte_buf identifier }
}
