//! The messages of a scene, as bytes.

use recording::Cdr;

/// The frame in which everything lies.
pub(super) const WORLD: &str = "world";

/// Where something is: place in m, and orientation as a quaternion x, y, z, w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    pub(super) place: [f64; 3],
    pub(super) orientation: [f64; 4],
}

impl Pose {
    /// At rest in its frame.
    pub(super) const IDENTITY: Self = Self::at([0.0; 3]);

    /// At a place, not turned.
    pub(super) const fn at(place: [f64; 3]) -> Self {
        Self { place, orientation: [0.0, 0.0, 0.0, 1.0] }
    }

    /// Of coordinates `x, y, heading` (planar) or `x, y, z` with or without roll, pitch, yaw; missing ones count as 0.
    pub(super) fn of(coordinates: &[f64], planar: bool) -> Self {
        let at = |index: usize| coordinates.get(index).copied().unwrap_or(0.0);
        match planar {
            true => Self { place: [at(0), at(1), 0.0], orientation: quaternion(0.0, 0.0, at(2)) },
            false => Self { place: [at(0), at(1), at(2)], orientation: quaternion(at(3), at(4), at(5)) },
        }
    }
}

/// The rotation by yaw about z, then pitch about the new y, then roll about the new x, rad.
fn quaternion(roll: f64, pitch: f64, yaw: f64) -> [f64; 4] {
    let ([sr, cr], [sp, cp], [sy, cy]) = (half(roll), half(pitch), half(yaw));
    [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy]
}

/// Sine and cosine of half an angle.
fn half(angle: f64) -> [f64; 2] {
    [libm::sin(angle / 2.0), libm::cos(angle / 2.0)]
}

/// What a marker is; the numbers are those of `visualization_msgs/Marker`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Figure {
    /// From its first point to its second.
    Arrow = 0,
    Cylinder = 3,
    LineStrip = 4,
    /// A line between each pair of points.
    LineList = 5,
    /// The text faces the viewer.
    Text = 9,
}

/// One thing to draw. It stays until a marker of the same namespace and number replaces it.
#[derive(Clone, Debug)]
pub(super) struct Marker<'a> {
    /// The frame it is given in, and moves with.
    pub(super) frame: &'a str,
    pub(super) namespace: &'a str,
    pub(super) id: i32,
    pub(super) figure: Figure,
    /// Takes the marker away instead.
    pub(super) gone: bool,
    pub(super) pose: Pose,
    /// Size in m; of lines, the first one is their width; of text, the last one is its height.
    pub(super) scale: [f64; 3],
    /// Red, green, blue, opacity, 0 to 1.
    pub(super) colour: [f32; 4],
    /// For lines and arrows, in `frame`, m.
    pub(super) points: &'a [[f64; 3]],
    pub(super) text: &'a str,
}

impl Marker<'_> {
    /// A marker in the frame of the world, without size, points or text.
    pub(super) const fn new(namespace: &'static str, id: i32, figure: Figure) -> Self {
        Self {
            frame: WORLD,
            namespace,
            id,
            figure,
            gone: false,
            pose: Pose::IDENTITY,
            scale: [1.0; 3],
            colour: [1.0; 4],
            points: &[],
            text: "",
        }
    }
}

/// How much a line of the journal matters; the numbers are those of `rcl_interfaces/Log`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    Info = 20,
    Warn = 30,
    Error = 40,
    Fatal = 50,
}

fn header<'a>(cdr: &'a mut Cdr, time_ns: u64, frame: &str) -> &'a mut Cdr {
    cdr.stamp(time_ns).text(frame)
}

/// Where frames lie in the world: `tf2_msgs/TFMessage`.
pub(super) fn transforms<'a>(cdr: &mut Cdr, time_ns: u64, frames: impl ExactSizeIterator<Item = (&'a str, Pose)>) {
    cdr.restart().length(frames.len());
    for (name, pose) in frames {
        header(cdr, time_ns, WORLD).text(name).f64s(&pose.place).f64s(&pose.orientation);
    }
}

/// Poses in the world: `geometry_msgs/PoseArray`.
pub(super) fn poses(cdr: &mut Cdr, time_ns: u64, poses: impl ExactSizeIterator<Item = Pose>) {
    header(cdr.restart(), time_ns, WORLD).length(poses.len());
    for pose in poses {
        cdr.f64s(&pose.place).f64s(&pose.orientation);
    }
}

/// Starts a `visualization_msgs/MarkerArray` of `count` markers, which [`marker`] appends.
pub(super) fn markers(cdr: &mut Cdr, count: usize) {
    cdr.restart().length(count);
}

/// Appends a marker.
pub(super) fn marker(cdr: &mut Cdr, time_ns: u64, marker: &Marker<'_>) {
    /// `ADD` and `DELETE`.
    const ACTIONS: [i32; 2] = [0, 2];
    header(cdr, time_ns, marker.frame).text(marker.namespace).i32(marker.id).i32(marker.figure as i32);
    cdr.i32(ACTIONS[usize::from(marker.gone)]);
    cdr.f64s(&marker.pose.place).f64s(&marker.pose.orientation).f64s(&marker.scale);
    for part in marker.colour {
        cdr.f32(part);
    }
    // No end of its life; it moves with its frame.
    cdr.i32(0).u32(0).bool(true);
    cdr.length(marker.points.len());
    for point in marker.points {
        cdr.f64s(point);
    }
    // Neither colours of points nor a texture: its name, its image with header, format and data, its coordinates.
    cdr.length(0).text("").i32(0).u32(0).text("").text("").length(0).length(0);
    // Text; no mesh: its name, its file with name and data, whether to take its materials.
    cdr.text(marker.text).text("").text("").length(0).bool(false);
}

/// A line of the journal: `rcl_interfaces/Log`.
pub(super) fn journal(cdr: &mut Cdr, time_ns: u64, level: Level, name: &str, text: &str) {
    cdr.restart().stamp(time_ns).u8(level as u8).text(name).text(text).text("").text("").u32(0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_turns_about_z_and_angles_go_by_yaw_pitch_roll() {
        let half = 0.5_f64.sqrt();
        let close = |pose: Pose, expected: [f64; 4]| {
            for (value, expected) in pose.orientation.iter().zip(expected) {
                assert!((value - expected).abs() < 1e-15, "{pose:?}");
            }
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        close(Pose::of(&[1.0, 2.0, quarter], true), [0.0, 0.0, half, half]);
        close(Pose::of(&[1.0, 2.0, 3.0, quarter, 0.0, 0.0], false), [half, 0.0, 0.0, half]);
        close(Pose::of(&[1.0, 2.0, 3.0, 0.0, quarter, quarter], false), [-0.5, 0.5, 0.5, 0.5]);
        assert_eq!(Pose::of(&[1.0, 2.0, 3.0], false), Pose::at([1.0, 2.0, 3.0]));
        assert_eq!(Pose::of(&[1.0, 2.0], true), Pose::at([1.0, 2.0, 0.0]));
    }

    #[test]
    fn a_transform_has_its_numbers_where_a_reader_looks_for_them() {
        let mut cdr = Cdr::new();
        transforms(&mut cdr, 1_500_000_000, [("agent_1", Pose::at([1.0, 2.0, 3.0]))].into_iter());
        let body = &cdr.bytes()[4..];
        // Count, stamp, "world" of 6 bytes from 16 on, 2 bytes to align, "agent_1" of 8 bytes from 28 on.
        assert_eq!(body[..12], [1, 0, 0, 0, 1, 0, 0, 0, 0, 0x65, 0xcd, 0x1d]);
        assert_eq!((&body[16..22], &body[28..36]), (&b"world\0"[..], &b"agent_1\0"[..]));
        // The first multiple of 8 behind that.
        assert_eq!(body[40..48], 1.0_f64.to_le_bytes());
        assert_eq!(body.len(), 40 + 7 * 8);
    }
}
