//! The insides of lists, tables and enums for serde.

use std::cell::RefCell;

use serde::de::value::StrDeserializer;
use serde::de::{DeserializeSeed, EnumAccess, Error, IntoDeserializer, MapAccess, SeqAccess, VariantAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::overlay::KIND;
use super::path::join;
use super::read::{Failure, State, descend};
use super::reader::Reader;
use super::{Entry, Node, Origin, Table};

/// The elements of a list.
pub(super) struct Elements<'a> {
    elements: std::iter::Enumerate<std::slice::Iter<'a, Node>>,
    path: String,
    state: &'a RefCell<State>,
}

impl<'a> Elements<'a> {
    pub(super) fn new(list: &Reader<'a>, elements: &'a [Node]) -> Self {
        Self { elements: elements.iter().enumerate(), path: list.path.clone(), state: list.state }
    }
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Failure;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Failure> {
        let Some((index, node)) = self.elements.next() else { return Ok(None) };
        descend(seed, Some(node), &node.origin, join(&self.path, &(index + 1).to_string()), self.state).map(Some)
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.elements.len())
    }
}

/// The entries of a table. If the fields are known, others are recorded and passed over, and missing fields that have
/// been recorded already are delivered as stand-ins.
pub(super) struct Fields<'a> {
    entries: std::slice::Iter<'a, Entry>,
    expected: Option<&'static [&'static str]>,
    missing: Vec<&'static str>,
    kind_is_read: bool,
    origin: &'a Origin,
    path: String,
    state: &'a RefCell<State>,
    /// The value whose key has been delivered: its path, the node if it exists, and where to report it.
    pending: Option<(String, Option<&'a Node>, &'a Origin)>,
}

impl<'a> Fields<'a> {
    pub(super) fn new(place: &Reader<'a>, table: &'a Table, expected: Option<&'static [&'static str]>) -> Self {
        let state = place.state.borrow();
        let absent = |field: &&str| table.get(field).is_none() && state.stands_in(&join(&place.path, field));
        Self {
            entries: table.entries().iter(),
            expected,
            missing: expected.unwrap_or(&[]).iter().copied().filter(absent).collect(),
            kind_is_read: place.kind_is_read,
            origin: &place.node.origin,
            path: place.path.clone(),
            state: place.state,
            pending: None,
        }
    }
}

impl<'de> MapAccess<'de> for Fields<'_> {
    type Error = Failure;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Failure> {
        for Entry { key, key_origin, node } in self.entries.by_ref() {
            if self.kind_is_read && key == KIND {
                continue;
            }
            let path = join(&self.path, key);
            if let Some(expected) = self.expected.filter(|expected| !expected.contains(&key.as_str())) {
                self.state.borrow_mut().unknown(key_origin, path, expected, key);
                continue;
            }
            self.pending = Some((path, Some(node), &node.origin));
            let key: StrDeserializer<Failure> = key.as_str().into_deserializer();
            return seed.deserialize(key).map(Some);
        }
        let Some(field) = self.missing.pop() else { return Ok(None) };
        self.pending = Some((join(&self.path, field), None, self.origin));
        let key: StrDeserializer<Failure> = field.into_deserializer();
        seed.deserialize(key).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Failure> {
        let (path, node, origin) = self.pending.take().ok_or_else(|| Failure::custom("a value without a key"))?;
        descend(seed, node, origin, path, self.state)
    }
}

/// An enum: the name of the variant and its data.
pub(super) struct Choice<'a> {
    pub(super) name: &'a str,
    pub(super) contents: Contents<'a>,
}

/// The data of a variant.
pub(super) enum Contents<'a> {
    /// None: the value is just the name.
    Name(&'a Node),
    /// The other entries of the table with the `kind`.
    Kind(Reader<'a>),
    /// The value of the only key of a table.
    Keyed(Reader<'a>),
}

impl<'de, 'a> EnumAccess<'de> for Choice<'a> {
    type Error = Failure;
    type Variant = Choice<'a>;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Choice<'a>), Failure> {
        let name: StrDeserializer<Failure> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'a> Choice<'a> {
    /// The reader of the data, and where its mistakes belong.
    fn contents(self) -> Result<Reader<'a>, Failure> {
        match self.contents {
            Contents::Kind(reader) | Contents::Keyed(reader) => Ok(reader),
            Contents::Name(node) => Err(Failure::Mistake {
                message: format!("{} needs parameters, found only its name", self.name),
                help: Some(format!("write {{ {KIND} = {:?}, ... }} instead of {}", self.name, node.describe())),
            }),
        }
    }
}

impl<'de> VariantAccess<'de> for Choice<'_> {
    type Error = Failure;

    fn unit_variant(self) -> Result<(), Failure> {
        match self.contents {
            Contents::Name(_) => Ok(()),
            Contents::Kind(reader) => Deserialize::deserialize(reader),
            Contents::Keyed(Reader { node, path, state, .. }) => {
                descend(std::marker::PhantomData::<()>, Some(node), &node.origin, path, state)
            }
        }
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Failure> {
        let reader = self.contents()?;
        if reader.kind_is_read {
            return seed.deserialize(reader);
        }
        descend(seed, Some(reader.node), &reader.node.origin, reader.path, reader.state)
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Failure> {
        self.contents()?.deserialize_tuple(length, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(self, fields: &'static [&'static str], visitor: V) -> Result<V::Value, Failure> {
        self.contents()?.deserialize_struct("", fields, visitor)
    }
}
