//! Definitions of the ROS 2 messages that viewers draw by themselves, each with all that it is made of.

/// A message type: its name, and what it looks like.
pub type Definition = (&'static str, &'static str);

/// Frames and how they lie in each other.
pub const TRANSFORMS: &[Definition] = &[
    ("tf2_msgs/msg/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    ("geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"),
    HEADER,
    TIME,
    VECTOR,
    QUATERNION,
];

/// Poses in one frame.
pub const POSES: &[Definition] = &[
    ("geometry_msgs/msg/PoseArray", "std_msgs/Header header\ngeometry_msgs/Pose[] poses\n"),
    POSE,
    POINT,
    QUATERNION,
    HEADER,
    TIME,
];

/// Things to draw.
pub const MARKERS: &[Definition] = &[
    ("visualization_msgs/msg/MarkerArray", "visualization_msgs/Marker[] markers\n"),
    ("visualization_msgs/Marker", MARKER),
    ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
    ("visualization_msgs/MeshFile", "string filename\nuint8[] data\n"),
    ("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    ("std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"),
    POSE,
    POINT,
    VECTOR,
    QUATERNION,
    HEADER,
    TIME,
];

/// A line of a journal.
pub const JOURNAL: &[Definition] = &[("rcl_interfaces/msg/Log", LOG), TIME];

const HEADER: Definition = ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n");
const TIME: Definition = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
const VECTOR: Definition = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n");
const POINT: Definition = ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n");
const QUATERNION: Definition = ("geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n");
const POSE: Definition = ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n");

const MARKER: &str = "\
int32 ARROW=0
int32 CUBE=1
int32 SPHERE=2
int32 CYLINDER=3
int32 LINE_STRIP=4
int32 LINE_LIST=5
int32 CUBE_LIST=6
int32 SPHERE_LIST=7
int32 POINTS=8
int32 TEXT_VIEW_FACING=9
int32 MESH_RESOURCE=10
int32 TRIANGLE_LIST=11
int32 ADD=0
int32 MODIFY=0
int32 DELETE=2
int32 DELETEALL=3
std_msgs/Header header
string ns
int32 id
int32 type
int32 action
geometry_msgs/Pose pose
geometry_msgs/Vector3 scale
std_msgs/ColorRGBA color
builtin_interfaces/Duration lifetime
bool frame_locked
geometry_msgs/Point[] points
std_msgs/ColorRGBA[] colors
string texture_resource
sensor_msgs/CompressedImage texture
visualization_msgs/UVCoordinate[] uv_coordinates
string text
string mesh_resource
visualization_msgs/MeshFile mesh_file
bool mesh_use_embedded_materials
";

const LOG: &str = "\
byte DEBUG=10
byte INFO=20
byte WARN=30
byte ERROR=40
byte FATAL=50
builtin_interfaces/Time stamp
uint8 level
string name
string msg
string file
string function
uint32 line
";

/// The text of a schema: the first type, then all others behind separators.
pub fn text(definitions: &[Definition]) -> String {
    let mut text = definitions[0].1.to_string();
    for (name, definition) in &definitions[1..] {
        text += &format!("{}\nMSG: {name}\n{definition}", "=".repeat(80));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_that_is_used_is_defined_once() {
        for definitions in [TRANSFORMS, POSES, MARKERS, JOURNAL] {
            let known: Vec<&str> = definitions.iter().map(|definition| definition.0).collect();
            let used = definitions.iter().flat_map(|(_, text)| text.lines());
            let used = used.filter_map(|line| line.split([' ', '[']).next()).filter(|kind| kind.contains('/'));
            for kind in used {
                assert_eq!(known.iter().filter(|name| **name == kind).count(), 1, "{kind} in {}", known[0]);
            }
        }
    }

    #[test]
    fn types_are_set_apart() {
        let expected = format!("{}{}\nMSG: {}\n{}", JOURNAL[0].1, "=".repeat(80), TIME.0, TIME.1);
        assert_eq!(text(JOURNAL), expected);
    }
}
