//! Values of any type, made from nothing, in places where the file has a mistake.

use serde::de::value::StrDeserializer;
use serde::de::{DeserializeSeed, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, VariantAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::DEPTH_LIMIT;
use super::read::Failure;

/// Delivers something of the type that is wanted. The value is never used, but it may have to satisfy conditions, so
/// there are several to try.
#[derive(Clone, Copy)]
pub(super) struct StandIn {
    attempt: usize,
    depth: usize,
}

impl StandIn {
    /// Number of different stand-ins.
    pub(super) const ATTEMPTS: usize = 3;

    pub(super) fn new(attempt: usize) -> Self {
        Self { attempt, depth: 0 }
    }

    /// The stand-in for a part of this one; types may contain themselves.
    fn inner(self) -> Result<Self, Failure> {
        let depth = self.depth + 1;
        if depth > DEPTH_LIMIT { Err(Failure::Hopeless) } else { Ok(Self { depth, ..self }) }
    }

    fn real(self) -> f64 {
        [0.5, 0.0, 2.0][self.attempt % Self::ATTEMPTS]
    }

    fn integer(self) -> u8 {
        [1, 0, 2][self.attempt % Self::ATTEMPTS]
    }

    fn text(self) -> &'static str {
        ["x", "", "1"][self.attempt % Self::ATTEMPTS]
    }

    fn parts(self, count: usize) -> Parts {
        Parts { stand_in: self, left: count }
    }
}

/// A list of stand-ins.
struct Parts {
    stand_in: StandIn,
    left: usize,
}

/// More fields than any struct has.
const FIELD_LIMIT: usize = 256;

impl<'de> SeqAccess<'de> for Parts {
    type Error = Failure;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Failure> {
        let Some(left) = self.left.checked_sub(1) else { return Ok(None) };
        self.left = left;
        seed.deserialize(self.stand_in.inner()?).map(Some)
    }
}

/// An empty table.
impl<'de> MapAccess<'de> for Parts {
    type Error = Failure;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, _: S) -> Result<Option<S::Value>, Failure> {
        Ok(None)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, _: S) -> Result<S::Value, Failure> {
        Err(Failure::Hopeless)
    }
}

/// A variant of an enum.
struct Choice {
    stand_in: StandIn,
    name: &'static str,
}

impl<'de> EnumAccess<'de> for Choice {
    type Error = Failure;
    type Variant = StandIn;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, StandIn), Failure> {
        let name: StrDeserializer<Failure> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self.stand_in.inner()?))
    }
}

impl<'de> VariantAccess<'de> for StandIn {
    type Error = Failure;

    fn unit_variant(self) -> Result<(), Failure> {
        <()>::deserialize(self)
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Failure> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_seq(self.parts(length))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_seq(self.parts(FIELD_LIMIT))
    }
}

macro_rules! stand_ins {
    ($($method:ident($($argument:ident: $type:ty),*) $this:ident => $visit:ident($($value:expr)?);)*) => {$(
        fn $method<V: Visitor<'de>>($this, $($argument: $type,)* visitor: V) -> Result<V::Value, Failure> {
            visitor.$visit($($value)?)
        }
    )*};
}

impl<'de> Deserializer<'de> for StandIn {
    type Error = Failure;

    // Visitors of integers and of floats take the smallest and the largest of their kind.
    stand_ins! {
        deserialize_bool() self => visit_bool(self.attempt == 1);
        deserialize_i8() self => visit_u8(self.integer());
        deserialize_i16() self => visit_u8(self.integer());
        deserialize_i32() self => visit_u8(self.integer());
        deserialize_i64() self => visit_u8(self.integer());
        deserialize_u8() self => visit_u8(self.integer());
        deserialize_u16() self => visit_u8(self.integer());
        deserialize_u32() self => visit_u8(self.integer());
        deserialize_u64() self => visit_u8(self.integer());
        deserialize_f32() self => visit_f64(self.real());
        deserialize_f64() self => visit_f64(self.real());
        deserialize_char() self => visit_char('x');
        deserialize_str() self => visit_str(self.text());
        deserialize_string() self => visit_str(self.text());
        deserialize_option() self => visit_none();
        deserialize_unit() self => visit_unit();
        deserialize_unit_struct(_name: &'static str) self => visit_unit();
        deserialize_newtype_struct(_name: &'static str) self => visit_newtype_struct(self.inner()?);
        deserialize_seq() self => visit_seq(self.parts(self.integer().into()));
        deserialize_tuple(length: usize) self => visit_seq(self.parts(length));
        deserialize_tuple_struct(_name: &'static str, length: usize) self => visit_seq(self.parts(length));
        deserialize_map() self => visit_map(self.parts(0));
        deserialize_struct(_name: &'static str, _fields: &'static [&'static str]) self
            => visit_seq(self.parts(FIELD_LIMIT));
        deserialize_ignored_any() self => visit_unit();
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        match self.attempt {
            0 => visitor.visit_f64(self.real()),
            1 => visitor.visit_str("x"),
            _ => visitor.visit_map(self.parts(0)),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let name = *variants.get(self.attempt).or(variants.first()).ok_or(Failure::Hopeless)?;
        visitor.visit_enum(Choice { stand_in: self, name })
    }

    serde::forward_to_deserialize_any! { bytes byte_buf identifier }
}
