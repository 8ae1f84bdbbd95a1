//! A scenario file as it is written: every section that there may be, once.
//!
//! The reader of a scenario, the names that `--set` accepts, the schema for editors and the page of all fields take the sections from
//! [`RawScenario`]. A section whose content needs more than its own text (formulas, other sections, the components of a catalog) is
//! [`Elsewhere`] here and read from the tree; its schema is still the one of its type.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error, Visitor};

use super::agents::Row;
use super::elsewhere::Elsewhere;
use super::model::{NamedVehicles, vehicle_schema};
use super::realtime::RealtimeSection;
use super::run_sections::PlacementSection;
use super::topology::TopologySection;
use super::{Expectation, Obstacles, Timing, instruments, links, schema};

/// All sections of a scenario file, in the order of its documentation. Each may be missing here; what a run needs is required
/// where it is read.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "sections that are read elsewhere are named here for the schema and for unknown fields")]
pub(super) struct RawScenario {
    /// Name of the scenario; its logs are called so.
    #[schemars(regex(pattern = r"^[A-Za-z0-9_-]+$"))]
    pub(super) name: Option<String>,
    /// What the scenario is about, in one line.
    pub(super) title: Option<String>,
    /// Section of the thesis.
    pub(super) thesis: Option<String>,
    /// The variant that the file itself is.
    pub(super) variant: Option<String>,
    #[schemars(with = "bool")]
    variants: Option<Elsewhere>,
    /// Seed of all random numbers.
    #[serde(default)]
    pub(super) seed: u64,
    /// The agents, numbered from 1 in this order.
    #[schemars(schema_with = "rows")]
    agents: Option<Elsewhere>,
    #[schemars(with = "Timing")]
    timing: Option<Elsewhere>,
    /// Named numbers that formulas may use.
    #[schemars(with = "BTreeMap<String, f64>")]
    parameters: Option<Elsewhere>,
    #[schemars(schema_with = "vehicle_schema")]
    vehicle: Option<Elsewhere>,
    #[schemars(with = "NamedVehicles")]
    vehicles: Option<Elsewhere>,
    #[schemars(with = "TopologySection")]
    topology: Option<Elsewhere>,
    #[schemars(schema_with = "links::schema")]
    links: Option<Elsewhere>,
    #[schemars(schema_with = "instruments::sensors_schema")]
    sensors: Option<Elsewhere>,
    #[schemars(schema_with = "instruments::actuators_schema")]
    actuators: Option<Elsewhere>,
    #[schemars(schema_with = "schema::reference")]
    reference: Option<Elsewhere>,
    #[schemars(schema_with = "schema::disturbance")]
    disturbance: Option<Elsewhere>,
    #[schemars(schema_with = "schema::data")]
    data: Option<Elsewhere>,
    #[schemars(with = "Obstacles")]
    obstacles: Option<Elsewhere>,
    #[schemars(schema_with = "schema::edges")]
    edges: Option<Elsewhere>,
    #[schemars(with = "PlacementSection")]
    placement: Option<Elsewhere>,
    #[schemars(schema_with = "schema::on_failure")]
    on_failure: Option<Elsewhere>,
    #[schemars(with = "RealtimeSection")]
    realtime: Option<Elsewhere>,
    #[schemars(schema_with = "schema::swap")]
    swap: Option<Elsewhere>,
    // Those of components: their schemas come from the catalog.
    #[schemars(with = "bool")]
    plant: Option<Elsewhere>,
    #[schemars(with = "bool")]
    planner: Option<Elsewhere>,
    #[schemars(with = "bool")]
    observer: Option<Elsewhere>,
    #[schemars(with = "bool")]
    controller: Option<Elsewhere>,
    // The set of metrics, or metrics of one's own; the judge has the schema.
    #[schemars(with = "bool")]
    metrics: Option<Elsewhere>,
    /// What should come out, by metric.
    #[serde(default)]
    pub(super) expect: BTreeMap<String, Expectation>,
    // Those of the judge, which has their schemas.
    #[schemars(with = "bool")]
    claims: Option<Elsewhere>,
    #[schemars(with = "bool")]
    assert: Option<Elsewhere>,
    #[schemars(schema_with = "schema::ranges")]
    ranges: Option<Elsewhere>,
}

/// The rows of the agents. Those of vehicles by equations have states and parameters by their names instead of a position.
fn rows(generator: &mut SchemaGenerator) -> Schema {
    let mut row = Row::json_schema(generator);
    row.insert("additionalProperties".into(), json_schema!({ "type": ["number", "string"] }).into());
    row.remove("required");
    json_schema!({ "type": "array", "minItems": 1, "items": row })
}

/// The names of all sections that a scenario file may have, in order.
pub static SECTIONS: LazyLock<&'static [&'static str]> =
    LazyLock::new(|| RawScenario::deserialize(Names).err().map_or(&[], |Found(names)| names));

/// The schema of every section, by its name. Those of components, claims and assertions are placeholders: their types are known
/// elsewhere.
pub fn sections(generator: &mut SchemaGenerator) -> BTreeMap<String, Schema> {
    let schema = RawScenario::json_schema(generator);
    let properties =
        schema.get("properties").and_then(|properties| properties.as_object().cloned()).unwrap_or_default();
    properties.into_iter().filter_map(|(name, schema)| Some((name, Schema::try_from(schema).ok()?))).collect()
}

/// Gives away the names of the fields of a struct instead of reading any.
struct Names;

/// The names that were found.
#[derive(Debug, thiserror::Error)]
#[error("the fields {0:?}")]
struct Found(&'static [&'static str]);

impl Error for Found {
    fn custom<T: std::fmt::Display>(_: T) -> Self {
        Self(&[])
    }
}

impl<'de> Deserializer<'de> for Names {
    type Error = Found;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Found> {
        Err(Found(&[]))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Found> {
        Err(Found(fields))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq
        tuple tuple_struct map enum identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sections_are_the_fields_of_the_type() {
        assert_eq!(SECTIONS.len(), 33);
        assert_eq!((SECTIONS[0], SECTIONS[32]), ("name", "ranges"));
        let described = sections(&mut SchemaGenerator::default());
        assert!(SECTIONS.iter().all(|name| described.contains_key(*name)));
    }
}
