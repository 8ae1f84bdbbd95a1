//! A bound as it is written: a number, or a formula of constants such as `"2*UM"`.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use std::fmt;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};

/// The text of a bound; a number is a formula, too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Bound(pub(super) String);

impl<'de> Deserialize<'de> for Bound {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(BoundVisitor)
    }
}

impl JsonSchema for Bound {
    fn schema_name() -> Cow<'static, str> {
        "Bound".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": ["number", "string", "array"] })
    }
}

struct BoundVisitor;

impl Visitor<'_> for BoundVisitor {
    type Value = Bound;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number or a formula of constants such as \"2*UM\"")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Bound, E> {
        Ok(Bound(value.to_string()))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Bound, E> {
        Ok(Bound(value.to_string()))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Bound, E> {
        if value.is_finite() { Ok(Bound(format!("{value:?}"))) } else { Err(E::custom("expected a finite number")) }
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Bound, E> {
        Ok(Bound(text.into()))
    }
}
