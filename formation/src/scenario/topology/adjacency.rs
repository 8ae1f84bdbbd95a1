//! `topology.A`: a matrix, or the name of a graph.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::config::brief;
use crate::math::Topology;

/// Name of the directed ring, which is also what is taken without `topology.A`.
pub(super) const RING: &str = "ring";
/// Name of the ring with links both ways.
pub(in crate::scenario) const TWO_WAY_RING: &str = "two_way_ring";

/// Which agents receive from which, as a scenario file says it. A name stands for a graph of any number of agents, and takes no N x N
/// numbers to write down.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Adjacency {
    /// The directed ring 1 -> 2 -> ... -> N -> 1.
    Ring,
    /// The ring 1 - 2 - ... - N - 1.
    TwoWayRing,
    /// Row i lists the weights of the links over which agent i receives.
    Matrix(Vec<Vec<f64>>),
}

impl Adjacency {
    /// The graph with these weights of the links to the reference, one per agent.
    ///
    /// # Errors
    /// See [`Topology::new`].
    pub(super) fn graph(&self, reference: Vec<f64>) -> Result<Topology, String> {
        match self {
            Self::Ring => Ok(Topology::ring(reference)),
            Self::TwoWayRing => Ok(Topology::two_way_ring(reference)),
            Self::Matrix(rows) => Topology::new(rows, reference),
        }
    }
}

impl<'de> Deserialize<'de> for Adjacency {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AdjacencyVisitor)
    }
}

struct AdjacencyVisitor;

impl<'de> Visitor<'de> for AdjacencyVisitor {
    type Value = Adjacency;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a matrix (a list of rows), \"{RING}\" or \"{TWO_WAY_RING}\"")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Adjacency, E> {
        match name {
            RING => Ok(Adjacency::Ring),
            TWO_WAY_RING => Ok(Adjacency::TwoWayRing),
            _ => Err(E::custom(format!(
                "expected a matrix (a list of rows), \"{RING}\" or \"{TWO_WAY_RING}\", found {:?}",
                brief(name)
            ))),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, rows: A) -> Result<Adjacency, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(rows)).map(Adjacency::Matrix)
    }
}

impl JsonSchema for Adjacency {
    fn schema_name() -> Cow<'static, str> {
        "Adjacency".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let row = json_schema!({ "type": "array", "items": crate::config::number() });
        json_schema!({ "anyOf": [
            { "type": "array", "items": row, "description": "The matrix, row by row." },
            { "enum": [RING, TWO_WAY_RING], "description": "A ring 1, 2, ..., N, 1 with unit weights: one way or both." },
        ] })
    }
}
