//! What ROS 2 asks of a channel beside its messages: the hash of its type, and the quality of service that it was offered with.
//!
//! The hash is RIHS01 (REP-2016): the SHA-256 of a description of the type and of all that it refers to, as JSON. Two programs
//! mean the same type if its hash is the same.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::digest::hex;

/// How long a message of a channel is of use to a reader that comes late.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// Not at all: the next one replaces it. `/tf`, samples.
    Volatile,
    /// Until the next one, however long that takes: a late reader gets it. Bodies, obstacles, the journal.
    TransientLocal,
}

impl Durability {
    /// The quality of service of a reliable publisher, as `rosbag2` writes it into the channels of a file.
    ///
    /// The policies are numbers, which every version reads from a file with a metadata record [`BAG`].
    fn profile(self) -> String {
        let (depth, durability) = match self {
            Self::Volatile => (10, 2),
            Self::TransientLocal => (1, 1),
        };
        let forever = "\n    sec: 9223372036\n    nsec: 854775807";
        format!(
            "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n  deadline:{forever}\n  \
             lifespan:{forever}\n  liveliness: 1\n  liveliness_lease_duration:{forever}\n  \
             avoid_ros_namespace_conventions: false\n"
        )
    }
}

/// Name of the metadata record from which `rosbag2` takes that policies are numbers: it is there and says no version.
pub(super) const BAG: &str = "rosbag2";

/// What the profile `ros2` of MCAP asks of the metadata of a channel whose type has this hash.
pub(super) fn channel_metadata(hash: Option<&str>, durability: Durability) -> BTreeMap<String, String> {
    let mut metadata = BTreeMap::from([("offered_qos_profiles".to_string(), durability.profile())]);
    metadata.extend(hash.map(|hash| ("topic_type_hash".to_string(), hash.to_string())));
    metadata
}

/// The hash of the type `name`, which `text` defines with all that it refers to; `None` if the text is no such definition.
pub(super) fn type_hash(name: &str, text: &str) -> Option<String> {
    let separator = format!("{}\n", "=".repeat(80));
    let mut types = BTreeMap::new();
    let mut sections = text.split(separator.as_str());
    types.insert(name.to_string(), fields(sections.next()?)?);
    for section in sections {
        let (head, body) = section.split_once('\n')?;
        types.insert(full_name(head.strip_prefix("MSG: ")?.trim()), fields(body)?);
    }
    let mut used = vec![name.to_string()];
    let mut next = 0;
    while let Some(one) = used.get(next) {
        for field in types.get(one)? {
            if !field.nested.is_empty() && !used.contains(&field.nested) {
                used.push(field.nested.clone());
            }
        }
        next += 1;
    }
    let own = describe(name, types.get(name)?);
    used.retain(|one| one != name);
    used.sort_unstable();
    let others: Option<Vec<String>> = used.iter().map(|one| Some(describe(one, types.get(one)?))).collect();
    let others = others?.join(", ");
    let json = format!("{{\"type_description\": {own}, \"referenced_type_descriptions\": [{others}]}}");
    Some(format!("RIHS01_{}", hex(json.as_bytes())))
}

/// A field of a message.
struct Field {
    name: String,
    /// `type_description_interfaces/msg/FieldType`.
    kind: u8,
    capacity: u64,
    string_capacity: u64,
    /// The type of a message within; empty for others.
    nested: String,
}

/// `geometry_msgs/msg/Pose`, which a definition calls `geometry_msgs/Pose`.
fn full_name(name: &str) -> String {
    match name.split_once('/') {
        Some((package, rest)) if !rest.contains('/') => format!("{package}/msg/{rest}"),
        _ => name.into(),
    }
}

/// The fields of one definition, without constants and comments.
fn fields(text: &str) -> Option<Vec<Field>> {
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let fields: Option<Vec<Field>> = lines
        .filter(|line| !line.is_empty())
        .filter_map(|line| {
            let Some((kind, rest)) = line.split_once(char::is_whitespace) else { return Some(None) };
            let name = rest.split_whitespace().next()?;
            // `int32 ARROW=0` and `int32 ARROW = 0` are constants; a default value stands behind a space.
            let is_constant = name.contains('=') || rest[name.len()..].trim_start().starts_with('=');
            (!is_constant).then(|| field(kind, name))
        })
        .collect();
    fields.filter(|fields| !fields.is_empty()).or_else(|| {
        // A message without fields has one in CDR.
        text.trim()
            .is_empty()
            .then(|| field("uint8", "structure_needs_at_least_one_member"))
            .flatten()
            .map(|one| vec![one])
    })
}

fn field(kind: &str, name: &str) -> Option<Field> {
    /// The first of arrays, of sequences with a bound, and of those without one.
    const COLLECTIONS: [u8; 3] = [48, 96, 144];
    let (base, collection, capacity) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
        None => (kind, 0, 0),
        Some((base, "")) => (base, COLLECTIONS[2], 0),
        Some((base, length)) => match length.strip_prefix("<=") {
            Some(bound) => (base, COLLECTIONS[1], bound.parse().ok()?),
            None => (base, COLLECTIONS[0], length.parse().ok()?),
        },
    };
    let (base, string_capacity) = match base.split_once("<=") {
        Some((base, bound)) => (base, bound.parse().ok()?),
        None => (base, 0),
    };
    let bounded = string_capacity > 0;
    let kind = match base {
        "int8" => 2,
        "uint8" => 3,
        "int16" => 4,
        "uint16" => 5,
        "int32" => 6,
        "uint32" => 7,
        "int64" => 8,
        "uint64" => 9,
        "float32" => 10,
        "float64" => 11,
        "char" => 13,
        "bool" => 15,
        "byte" => 16,
        "string" if bounded => 21,
        "string" => 17,
        "wstring" if bounded => 22,
        "wstring" => 18,
        _ if base.contains('/') => 1,
        _ => return None,
    };
    let nested = if kind == 1 { full_name(base) } else { String::new() };
    Some(Field { name: name.into(), kind: kind + collection, capacity, string_capacity, nested })
}

/// A type as the JSON that is hashed has it.
fn describe(name: &str, fields: &[Field]) -> String {
    let mut text = format!("{{\"type_name\": \"{name}\", \"fields\": [");
    for (index, field) in fields.iter().enumerate() {
        let Field { name, kind, capacity, string_capacity, nested } = field;
        let between = if index == 0 { "" } else { ", " };
        // Writing to a text cannot fail.
        let _ = write!(
            text,
            "{between}{{\"name\": \"{name}\", \"type\": {{\"type_id\": {kind}, \"capacity\": {capacity}, \
             \"string_capacity\": {string_capacity}, \"nested_type_name\": \"{nested}\"}}}}"
        );
    }
    text + "]}"
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `ros2 interface show --all-comments` and `rosbags` have them.
    #[test]
    fn hashes_are_those_of_ros() {
        let known = [
            (
                "std_msgs/msg/String",
                "string data\n",
                "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
            ),
            (
                "builtin_interfaces/msg/Time",
                "int32 sec\nuint32 nanosec\n",
                "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
            ),
        ];
        for (name, text, expected) in known {
            assert_eq!(type_hash(name, text).as_deref(), Some(format!("RIHS01_{expected}").as_str()), "{name}");
        }
    }

    #[test]
    fn a_hash_needs_every_type_that_is_used() {
        assert!(type_hash("x/msg/X", "geometry_msgs/Pose pose\n").is_none());
        assert!(type_hash("x/msg/X", "float64[x] y\n").is_none());
        assert!(type_hash("x/msg/X", "garbage\n").is_none());
        let constants = "int32 A=1\nint32 B = 2 # two\n\n# nothing\nfloat64 x 0.5\n";
        assert_eq!(type_hash("x/msg/X", constants), type_hash("x/msg/X", "float64 x\n"));
    }
}
