//! Between layouts and ROS 2 message definitions: names for types, and the way back from a text to a layout.

use std::collections::BTreeMap;

use lockstep::{Field, Layout, Shape};

use super::LogError;
use super::digest::hex;
use super::ros::type_hash;

/// Package of the types that stand for layouts.
const PACKAGE: &str = "phalanx_msgs/msg/";
/// Words of the largest layout taken from a file; a larger one is a mistake or an attack.
pub(super) const WORDS_MAX: usize = 1 << 20;
/// Fields of the sample header, which precede those of the layout.
const HEADER_FIELDS: [&str; 4] = ["stamp", "step", "agent", "status"];

/// The definitions of a file by type name: a name means one text.
#[derive(Debug, Default)]
pub(super) struct Schemas {
    by_name: BTreeMap<String, Known>,
}

/// A definition that a file has.
#[derive(Debug)]
struct Known {
    id: u16,
    text: String,
    /// The hash that ROS 2 knows the type by.
    hash: Option<String>,
}

impl Schemas {
    /// Number and name for the layout of `topic`, and whether both are new.
    ///
    /// # Errors
    /// [`LogError::Layout`] if no ROS 2 message means this layout, [`LogError::TooManyChannels`].
    pub(super) fn of_layout(&mut self, topic: &str, layout: &Layout) -> Result<(u16, String, bool), LogError> {
        let text = layout.ros2msg();
        if layout_of(text.as_bytes()).as_ref() != Some(layout) {
            return Err(LogError::Layout { topic: topic.into() });
        }
        let name = own_type(&type_name(topic), &text);
        let (id, new) = self.of_name(&name, &text)?;
        Ok((id, name, new))
    }

    /// Number for a definition, and whether it is new.
    ///
    /// # Errors
    /// [`LogError::SchemaConflict`] if the name has another text, [`LogError::TooManyChannels`].
    pub(super) fn of_name(&mut self, name: &str, text: &str) -> Result<(u16, bool), LogError> {
        if let Some(Known { id, text: taken, .. }) = self.by_name.get(name) {
            return if taken == text { Ok((*id, false)) } else { Err(LogError::SchemaConflict { name: name.into() }) };
        }
        // Number 0 means "no schema" in MCAP.
        let id = u16::try_from(self.by_name.len() + 1).map_err(|_| LogError::TooManyChannels)?;
        self.by_name.insert(name.into(), Known { id, text: text.into(), hash: type_hash(name, text) });
        Ok((id, true))
    }

    /// The hash of the type `name`; `None` if it is not defined, or has none.
    pub(super) fn hash(&self, name: &str) -> Option<&str> {
        self.by_name.get(name)?.hash.as_deref()
    }
}

/// The name of a type of this program: what it is, and eight digits of the digest of its definition. One name has one
/// definition in all logs of all versions, so that a reader of several logs cannot confuse two.
pub fn own_type(what: &str, text: &str) -> String {
    format!("{PACKAGE}{what}{}", &hex(text.as_bytes())[..8])
}

/// `/agent_3/planner_output` gives `PlannerOutput`.
fn type_name(topic: &str) -> String {
    let segment = topic.rsplit('/').find(|segment| !segment.is_empty()).unwrap_or("");
    let mut name = String::new();
    for word in segment.split(|c: char| !c.is_ascii_alphanumeric()) {
        let mut letters = word.chars();
        name.extend(letters.next().map(|first| first.to_ascii_uppercase()));
        name.push_str(letters.as_str());
    }
    // A ROS type name starts with a letter.
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("Sample{name}") }
}

/// The layout whose definition is `text`; `None` if no layout gives exactly this text.
pub(super) fn layout_of(text: &[u8]) -> Option<Layout> {
    let text = std::str::from_utf8(text).ok()?;
    let mut fields: Vec<Field> = Vec::new();
    let mut words = 0_usize;
    for line in text.lines().skip(HEADER_FIELDS.len()).take_while(|line| !line.starts_with('=')) {
        let (declaration, unit) = line.split_once("  # ").unwrap_or((line, ""));
        let (kind, name) = declaration.split_once(' ')?;
        let shape = match kind.strip_prefix("float64")? {
            "" => Shape::Scalar,
            length => Shape::Vector(length.strip_prefix('[')?.strip_suffix(']')?.parse().ok()?),
        };
        words = words.checked_add(shape.words())?;
        let known = HEADER_FIELDS.contains(&name) || fields.iter().any(|field| field.name == name);
        if shape.words() == 0 || words > WORDS_MAX || known || !is_field_name(name) {
            return None;
        }
        fields.push(Field { name: name.into(), shape, unit: unit.into() });
    }
    let layout = Layout::new(fields);
    // Header, comments and the definition of the time type are compared here in one go.
    (layout.ros2msg() == text).then_some(layout)
}

/// The rule of ROS 2 for field names.
fn is_field_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_')
        && !name.contains("__")
        && !name.ends_with('_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_type_name_means_one_layout_in_all_logs() {
        let (small, large) = (Layout::new([Field::scalar("x", "m")]), Layout::new([Field::vector("x", 2, "m")]));
        // A log each.
        let name = |topic: &str, layout: &Layout| Schemas::default().of_layout(topic, layout).unwrap().1;
        let state = name("/agent_1/state", &small);
        assert_eq!(state.strip_prefix("phalanx_msgs/msg/State").map(str::len), Some(8), "{state}");
        assert_eq!(name("/agent_4/state", &small), state);
        assert_ne!(name("/agent_3/state", &large), state);
        assert!(name("/planner_output", &small).starts_with("phalanx_msgs/msg/PlannerOutput"));
        assert!(name("/3d", &small).starts_with("phalanx_msgs/msg/Sample3d"));
        assert_eq!(name("/", &small).len(), "phalanx_msgs/msg/Sample".len() + 8);
        let mut schemas = Schemas::default();
        let (_, name, new) = schemas.of_layout("/agent_1/state", &small).unwrap();
        assert!(new && !schemas.of_layout("/agent_2/state", &small).unwrap().2);
        assert!(schemas.of_name(&name, "other").is_err());
        assert!(schemas.hash(&name).is_some_and(|hash| hash.starts_with("RIHS01_")));
    }

    #[test]
    fn the_text_gives_the_layout_back() {
        let layout =
            Layout::new([Field::vector("position", 3, "m"), Field::scalar("flag", ""), Field::scalar("q1", "#")]);
        assert_eq!(layout_of(layout.ros2msg().as_bytes()), Some(layout));
        assert_eq!(layout_of(Layout::default().ros2msg().as_bytes()), Some(Layout::default()));
    }

    #[test]
    fn what_is_no_message_is_refused() {
        for field in [
            Field::scalar("Position", "m"),
            Field::scalar("", "m"),
            Field::scalar("step", "m"),
            Field::scalar("x", "m\nfloat64 y"),
            Field::vector("x", 0, "m"),
            Field::vector("x", WORDS_MAX + 1, "m"),
        ] {
            let layout = Layout::new([field]);
            assert!(Schemas::default().of_layout("/x", &layout).is_err(), "{layout:?}");
        }
        let twice = Layout::new([Field::scalar("x", "m"), Field::scalar("x", "m")]);
        assert_eq!(layout_of(twice.ros2msg().as_bytes()), None);
        assert_eq!(layout_of(b"float64 x\n"), None);
        assert_eq!(layout_of(b"a\nb\nc\nd\nfloat64[18446744073709551615] x\nfloat64[2] y\n"), None);
    }
}
