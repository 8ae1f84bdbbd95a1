//! Gains that are diagonal matrices.

use std::fmt;

use nalgebra::SVector;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// The diagonal of a gain matrix: one number for all channels, or a list with one number per channel.
///
/// ```
/// use formation::config::Diagonal;
/// use formation::nalgebra::Vector3;
/// assert_eq!(Diagonal::from(0.5).vector::<3>(), Ok(Vector3::repeat(0.5)));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Diagonal(Entries);

#[derive(Clone, Debug, PartialEq)]
enum Entries {
    Same(f64),
    Each(Vec<f64>),
}

impl Diagonal {
    /// The entries for `D` channels.
    ///
    /// # Errors
    /// A list of another length, or an entry that is negative or not finite.
    pub fn vector<const D: usize>(&self) -> Result<SVector<f64, D>, String> {
        let vector: SVector<f64, D> = match &self.0 {
            Entries::Same(value) => SVector::repeat(*value),
            Entries::Each(values) if values.len() == D => SVector::from_column_slice(values),
            Entries::Each(values) => return Err(format!("expected one gain or {D}, found {}", values.len())),
        };
        match vector.iter().find(|gain| !(gain.is_finite() && **gain >= 0.0)) {
            Some(gain) => Err(format!("expected gains >= 0, found {gain}")),
            None => Ok(vector),
        }
    }

    /// What is wrong with the diagonal for that many channels, if anything.
    ///
    /// Vehicles have 3 or 6 coordinates; any other number is an error too.
    pub fn problem(&self, channels: usize) -> Option<String> {
        match channels {
            3 => self.vector::<3>().err(),
            6 => self.vector::<6>().err(),
            _ => Some(format!("there are no vehicles of {channels} coordinates")),
        }
    }
}

impl From<f64> for Diagonal {
    fn from(value: f64) -> Self {
        Self(Entries::Same(value))
    }
}

impl<const D: usize> From<[f64; D]> for Diagonal {
    fn from(values: [f64; D]) -> Self {
        Self(Entries::Each(values.into()))
    }
}

impl<'de> Deserialize<'de> for Diagonal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(EntriesVisitor).map(Diagonal)
    }
}

struct EntriesVisitor;

impl<'de> Visitor<'de> for EntriesVisitor {
    type Value = Entries;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number or a list of numbers, one per channel")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Entries, E> {
        Ok(Entries::Same(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Entries, E> {
        Ok(Entries::Same(value as f64))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Entries, E> {
        Ok(Entries::Same(value))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Entries, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = elements.next_element()? {
            values.push(value);
        }
        Ok(Entries::Each(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn one_number_or_one_per_channel() {
        assert_eq!(Diagonal::from([15.0, 15.0, 6.0]).vector(), Ok(Vector3::new(15.0, 15.0, 6.0)));
        assert_eq!(Diagonal::from(2.0).vector(), Ok(Vector3::repeat(2.0)));
        assert_eq!(Diagonal::from([1.0, 2.0]).problem(3).unwrap(), "expected one gain or 3, found 2");
        assert_eq!(Diagonal::from(-1.0).problem(6).unwrap(), "expected gains >= 0, found -1");
        assert_eq!(Diagonal::from(1.0).problem(6), None);
    }
}
