//! Fields that are named in a type for its schema and for unknown fields, and read from the tree.

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny};

/// A section that is read where it is used, with the places of its values in the file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Elsewhere;

impl<'de> Deserialize<'de> for Elsewhere {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        IgnoredAny::deserialize(deserializer).map(|_| Self)
    }
}
