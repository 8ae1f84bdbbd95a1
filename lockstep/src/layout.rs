//! What a sample of a channel consists of: named fields of 64-bit floats behind the common header.

use serde::{Deserialize, Serialize};

use crate::HEADER_BYTES;

/// One number or a fixed number of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A single number.
    Scalar,
    /// A vector of fixed length.
    Vector(usize),
}

impl Shape {
    /// How many 64-bit words a value of this shape takes.
    pub fn words(self) -> usize {
        match self {
            Shape::Scalar => 1,
            Shape::Vector(length) => length,
        }
    }
}

/// A named signal inside a sample.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Field {
    /// The name in the log and in the wiring, `snake_case`.
    pub name: String,
    /// Number of values.
    pub shape: Shape,
    /// The unit, written as a comment into the log's schema. Empty for a pure number.
    pub unit: String,
}

impl Field {
    /// A field of one number.
    pub fn scalar(name: &str, unit: &str) -> Self {
        Self { name: name.into(), shape: Shape::Scalar, unit: unit.into() }
    }

    /// A field of `length` numbers.
    pub fn vector(name: &str, length: usize, unit: &str) -> Self {
        Self { name: name.into(), shape: Shape::Vector(length), unit: unit.into() }
    }
}

/// The ordered fields of a sample.
///
/// A sample is the [`Header`](crate::Header) followed by the fields, each a little-endian `float64`, without padding.
/// That is also the CDR encoding of the ROS 2 message [`Layout::ros2msg`] describes, so a recorder copies the bytes.
///
/// ```
/// use lockstep::{Field, Layout};
/// let layout = Layout::new([Field::vector("position", 3, "m"), Field::scalar("flag", "")]);
/// assert_eq!(layout.words(), 4);
/// assert_eq!(layout.find("flag"), Some((3, 1)));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Layout {
    fields: Vec<Field>,
}

impl Layout {
    /// A layout of these fields, in this order.
    pub fn new(fields: impl IntoIterator<Item = Field>) -> Self {
        Self { fields: fields.into_iter().collect() }
    }

    /// The fields in order.
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// Number of 64-bit words behind the header.
    pub fn words(&self) -> usize {
        self.fields.iter().map(|field| field.shape.words()).sum()
    }

    /// Number of bytes of a sample, header included.
    pub fn bytes(&self) -> usize {
        HEADER_BYTES + 8 * self.words()
    }

    /// Offset and length, in words behind the header, of the field called `name`.
    pub fn find(&self, name: &str) -> Option<(usize, usize)> {
        let mut offset = 0;
        for field in &self.fields {
            if field.name == name {
                return Some((offset, field.shape.words()));
            }
            offset += field.shape.words();
        }
        None
    }

    /// What to call the number at `offset` words: `flag`, or `position[2]` within a vector.
    pub fn label(&self, offset: usize) -> String {
        let mut start = 0;
        for field in &self.fields {
            let words = field.shape.words();
            if offset < start + words {
                return match field.shape {
                    Shape::Scalar => field.name.clone(),
                    Shape::Vector(_) => format!("{}[{}]", field.name, offset - start),
                };
            }
            start += words;
        }
        format!("word {offset}")
    }

    /// The ROS 2 message definition whose CDR encoding a sample of this layout is.
    pub fn ros2msg(&self) -> String {
        let mut text = String::from("builtin_interfaces/Time stamp\nuint64 step\nuint32 agent\nuint32 status\n");
        for field in &self.fields {
            let kind = match field.shape {
                Shape::Scalar => "float64".to_string(),
                Shape::Vector(length) => format!("float64[{length}]"),
            };
            text.push_str(&format!("{kind} {}", field.name));
            if !field.unit.is_empty() {
                text.push_str(&format!("  # {}", field.unit));
            }
            text.push('\n');
        }
        text.push_str(&"=".repeat(80));
        text.push_str("\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n");
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_follow_the_order_of_the_fields() {
        let layout = Layout::new([
            Field::vector("position", 3, "m"),
            Field::scalar("flag", ""),
            Field::vector("velocity", 2, "m/s"),
        ]);
        assert_eq!(layout.find("position"), Some((0, 3)));
        assert_eq!(layout.find("velocity"), Some((4, 2)));
        assert_eq!(layout.find("speed"), None);
        assert_eq!(layout.bytes(), 24 + 6 * 8);
        assert_eq!([layout.label(2), layout.label(3), layout.label(5)], ["position[2]", "flag", "velocity[1]"]);
    }

    #[test]
    fn schema_names_every_field_with_its_size() {
        let text = Layout::new([Field::vector("position", 3, "m"), Field::scalar("flag", "")]).ros2msg();
        assert!(text.contains("\nfloat64[3] position  # m\n"));
        assert!(text.contains("\nfloat64 flag\n"));
    }
}
