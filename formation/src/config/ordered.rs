//! Tables whose order matters, and formulas as they are written.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// A table of names in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Ordered<T>(pub Vec<(String, T)>);

impl<T> Default for Ordered<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Ordered<T> {
    /// All names with their values, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &T)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// The value of `name`.
    pub fn get(&self, name: &str) -> Option<&T> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Ordered<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OrderedVisitor(PhantomData))
    }
}

struct OrderedVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for OrderedVisitor<T> {
    type Value = Ordered<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Ordered<T>, A::Error> {
        let mut all = Vec::new();
        while let Some(entry) = entries.next_entry()? {
            all.push(entry);
        }
        Ok(Ordered(all))
    }
}

impl<T: JsonSchema> JsonSchema for Ordered<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("Ordered_{}", T::schema_name()).into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object", "additionalProperties": generator.subschema_for::<T>() })
    }
}

/// A formula as it is written: a text, or a number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormulaText(pub String);

impl<'de> Deserialize<'de> for FormulaText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FormulaVisitor)
    }
}

struct FormulaVisitor;

impl Visitor<'_> for FormulaVisitor {
    type Value = FormulaText;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a formula, such as \"0.3*sin(t)\"")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<FormulaText, E> {
        Ok(FormulaText(value.to_string()))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<FormulaText, E> {
        Ok(FormulaText(value.to_string()))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<FormulaText, E> {
        Ok(FormulaText(format!("{value:?}")))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<FormulaText, E> {
        Ok(FormulaText(text.into()))
    }
}

impl JsonSchema for FormulaText {
    fn schema_name() -> Cow<'static, str> {
        "Formula".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": ["string", "number"] })
    }
}

/// One formula, or a list of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FormulaTexts {
    /// A number.
    One(FormulaText),
    /// A vector.
    Several(Vec<FormulaText>),
}

impl<'de> Deserialize<'de> for FormulaTexts {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FormulasVisitor)
    }
}

struct FormulasVisitor;

impl<'de> Visitor<'de> for FormulasVisitor {
    type Value = FormulaTexts;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a formula, or a list of formulas")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<FormulaTexts, E> {
        FormulaVisitor.visit_i64(value).map(FormulaTexts::One)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<FormulaTexts, E> {
        FormulaVisitor.visit_u64(value).map(FormulaTexts::One)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<FormulaTexts, E> {
        FormulaVisitor.visit_f64(value).map(FormulaTexts::One)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<FormulaTexts, E> {
        FormulaVisitor.visit_str(text).map(FormulaTexts::One)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<FormulaTexts, A::Error> {
        let mut all = Vec::new();
        while let Some(element) = elements.next_element()? {
            all.push(element);
        }
        Ok(FormulaTexts::Several(all))
    }
}

impl JsonSchema for FormulaTexts {
    fn schema_name() -> Cow<'static, str> {
        "Formulas".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<FormulaText>();
        json_schema!({ "anyOf": [one, { "type": "array", "items": one, "minItems": 1 }] })
    }
}
