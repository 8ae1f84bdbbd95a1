//! The section `[ranges]`: within which limits the values of a field have to stay.

use serde::Deserialize;

use crate::config::{Node, Problems, read};

/// The range of a field of all agents.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldRange {
    /// Last part of the topic, `command`.
    pub topic: String,
    /// The field, `input`.
    pub field: String,
    /// Least value; minus infinity if there is none.
    pub min: f64,
    /// Largest value; infinity if there is none.
    pub max: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Limits {
    min: Option<f64>,
    max: Option<f64>,
}

/// Reads `"command.input" = { min = -1, max = 1 }`; what is wrong goes to `problems`.
pub(super) fn read_ranges(root: &Node, problems: &mut Problems) -> Vec<FieldRange> {
    let Some(section) = root.at("ranges") else { return Vec::new() };
    let Some(table) = section.as_table() else {
        problems.at(root, "ranges", "expected a table such as { \"command.input\" = { min = -1, max = 1 } }");
        return Vec::new();
    };
    let mut ranges = Vec::new();
    for (name, node) in table.iter() {
        let path = format!("ranges.{name}");
        let Some((topic, field)) = name.split_once('.') else {
            problems.at(
                root,
                "ranges",
                format!("{name}: expected \"TOPIC.FIELD\" in quotes, such as \"command.input\""),
            );
            continue;
        };
        let Some(Limits { min, max }) = read::<Limits>(node, &path, problems) else { continue };
        let (low, high) = (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY));
        if min.is_none() && max.is_none() || low.is_nan() || high.is_nan() || low > high {
            problems.at(root, "ranges", format!("{name}: expected `min`, `max` or both, and min <= max"));
            continue;
        }
        ranges.push(FieldRange { topic: topic.into(), field: field.into(), min: low, max: high });
    }
    ranges
}
