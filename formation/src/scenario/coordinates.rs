//! Coordinates of an agent as a scenario file gives them.

use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::formula::Expression;

/// A list of values, or one value for all coordinates. A value is a number or a formula of numbers, such as `"7*pi/12"`.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Coordinates {
    /// The same for all.
    All(f64),
    /// One each.
    Each(Vec<f64>),
}

impl Default for Coordinates {
    fn default() -> Self {
        Self::Each(Vec::new())
    }
}

impl Coordinates {
    /// The values of `length` coordinates; a list is returned as it is, whatever its length.
    pub(super) fn values(&self, length: usize) -> Vec<f64> {
        match self {
            Coordinates::All(value) => vec![*value; length],
            Coordinates::Each(values) => values.clone(),
        }
    }
}

impl<'de> Deserialize<'de> for Coordinates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CoordinatesVisitor)
    }
}

/// One value of a list.
struct Coordinate(f64);

impl<'de> Deserialize<'de> for Coordinate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CoordinateVisitor).map(Coordinate)
    }
}

fn constant<E: Error>(text: &str) -> Result<f64, E> {
    let value = Expression::parse(text).and_then(|expression| expression.constant());
    value.map_err(|error| E::custom(format!("not a formula of numbers: {}", error.within(text))))
}

struct CoordinateVisitor;

impl Visitor<'_> for CoordinateVisitor {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, or a formula of numbers such as \"pi/3\"")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
        Ok(value)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<f64, E> {
        constant(text)
    }
}

struct CoordinatesVisitor;

impl<'de> Visitor<'de> for CoordinatesVisitor {
    type Value = Coordinates;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of numbers, or one number for all coordinates")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Coordinates, E> {
        Ok(Coordinates::All(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Coordinates, E> {
        Ok(Coordinates::All(value as f64))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Coordinates, E> {
        Ok(Coordinates::All(value))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Coordinates, E> {
        constant(text).map(Coordinates::All)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Coordinates, A::Error> {
        let mut values = Vec::new();
        while let Some(Coordinate(value)) = elements.next_element()? {
            values.push(value);
        }
        Ok(Coordinates::Each(values))
    }
}
