//! Files that the crate `mcap` writes, whole, cut and damaged.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};

use super::{is_mcap, series};
use crate::formula::DataError;

const TWIST: &str = "# Velocity.\n\nVector3  linear\nVector3  angular\n\
    ================================================================================\n\
    MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";

/// What a file is made of.
struct File {
    writer: Writer<Cursor<Vec<u8>>>,
    sequence: u32,
}

impl File {
    fn new(options: WriteOptions) -> Self {
        Self { writer: options.create(Cursor::new(Vec::new())).unwrap(), sequence: 0 }
    }

    fn plain() -> Self {
        Self::new(WriteOptions::new().use_chunks(false))
    }

    fn topic(&mut self, topic: &str, [encoding, kind, text]: [&str; 3], messages: &str) -> u16 {
        let schema = match encoding {
            "" => 0,
            _ => self.writer.add_schema(kind, encoding, text.as_bytes()).unwrap(),
        };
        self.writer.add_channel(schema, topic, messages, &BTreeMap::new()).unwrap()
    }

    fn ros(&mut self, topic: &str, kind: &str, text: &str) -> u16 {
        self.topic(topic, ["ros2msg", kind, text], "cdr")
    }

    fn message(&mut self, channel_id: u16, log_time: u64, data: &[u8]) -> &mut Self {
        self.sequence += 1;
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, data).unwrap();
        self
    }

    fn end(mut self) -> Vec<u8> {
        self.writer.finish().unwrap();
        self.writer.into_inner().into_inner()
    }
}

/// Little-endian CDR of parts whose alignment the test has done.
fn cdr(parts: &[&[u8]]) -> Vec<u8> {
    [&[0, 1, 0, 0], parts.concat().as_slice()].concat()
}

fn f64s(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn column_error(bytes: &[u8], column: &str) -> String {
    match series(bytes, column) {
        Err(DataError::Column(text)) => text,
        other => panic!("{column}: {other:?}"),
    }
}

fn file_error(bytes: &[u8], column: &str) -> String {
    match series(bytes, column) {
        Err(DataError::File(text)) => text,
        other => panic!("{column}: {other:?}"),
    }
}

/// A topic `/x` whose message is these bytes, twice.
fn twice(text: &str, data: &[u8]) -> Vec<u8> {
    let mut file = File::plain();
    let x = file.ros("/x", "p/msg/T", text);
    file.message(x, 0, data).message(x, 1_000_000_000, data);
    file.end()
}

/// The value of a field of such a topic.
fn value(text: &str, data: &[u8], field: &str) -> f64 {
    let (times, values) =
        series(&twice(text, data), &format!("/x.{field}")).unwrap_or_else(|e| panic!("{field}: {e:?}"));
    assert_eq!(times, [0.0, 1.0]);
    assert_eq!(values[0].to_bits(), values[1].to_bits());
    values[0]
}

fn twists(count: u32, options: WriteOptions) -> Vec<u8> {
    let mut file = File::new(options);
    let other = file.topic("/other", ["", "", ""], "json");
    let twist = file.ros("/cmd_vel", "geometry_msgs/msg/Twist", TWIST);
    file.message(other, 1_000_000_000, b"{}");
    for k in 0..count {
        let data = cdr(&[&f64s(&[k.into(), 1.0, 2.0, 3.0, 4.0, f64::from(k) / 2.0])]);
        file.message(twist, 1_500_000_000 + u64::from(k) * 10_000_000, &data);
    }
    file.end()
}

#[test]
fn reads_every_compression() {
    let chunked = |compression| WriteOptions::new().compression(compression).chunk_size(Some(500));
    for options in [
        chunked(None),
        chunked(Some(Compression::Zstd)),
        chunked(Some(Compression::Lz4)),
        WriteOptions::new().use_chunks(false),
    ] {
        let bytes = twists(50, options);
        assert!(is_mcap(&bytes) && !is_mcap(b"t,x\n0,1\n"));
        let (times, values) = series(&bytes, "/cmd_vel.angular.z").unwrap();
        assert_eq!(times, (50..100_u32).map(|k| f64::from(k) / 100.0).collect::<Vec<_>>());
        assert_eq!(values, (0..50_u32).map(|k| f64::from(k) / 2.0).collect::<Vec<_>>());
    }
}

#[test]
fn reads_every_type_and_both_byte_orders() {
    let text = "bool a\nbyte b\nchar c\nint8 d\nuint8 e\nint16 f\nuint16 g\nint32 h\nuint32 i\nint64 j\nuint64 k\nfloat32 l\n\
        float64 m\n";
    let expected = [1.0, 200.0, 65.0, -3.0, 255.0, -300.0, 60000.0, -70000.0, 4e9, -5e9, 1e19, 0.5, -0.25];
    for is_big in [false, true] {
        let mut data = Vec::new();
        let mut put = |bytes: &[u8]| {
            data.resize(data.len().next_multiple_of(bytes.len()), 0);
            let mut bytes = bytes.to_vec();
            if is_big {
                bytes.reverse();
            }
            data.extend(bytes);
        };
        for byte in [1, 200, 65, -3_i8 as u8, 255] {
            put(&[byte]);
        }
        put(&(-300_i16).to_le_bytes());
        put(&60000_u16.to_le_bytes());
        put(&(-70000_i32).to_le_bytes());
        put(&4_000_000_000_u32.to_le_bytes());
        put(&(-5_000_000_000_i64).to_le_bytes());
        put(&10_000_000_000_000_000_000_u64.to_le_bytes());
        put(&0.5_f32.to_le_bytes());
        put(&(-0.25_f64).to_le_bytes());
        let message = [&[0, u8::from(!is_big), 0, 0], data.as_slice()].concat();
        for (name, expected) in ('a'..='m').zip(expected) {
            assert_eq!(value(text, &message, &name.to_string()), expected, "{name}");
        }
    }
}

#[test]
fn skips_what_stands_before_a_field() {
    let text = "# Comment\nuint8 KIND=3\nstring NAME = \"a # b\"\nstring<=5 name \"x=1\" # text\nstring[] names\n\
        wstring wide\nfloat64[] empty\nNothing nothing\nq/msg/Pair[<=4] pairs\nPair[2] fixed\nHeader header\ntime at\n\
        int32 last -5\n===\nMSG: p/Nothing\nint32 ONLY=1\n===\nMSG: q/Pair\nuint8 a\nfloat64 b\n\
        ===\nMSG: p/msg/Pair\nint16 u\n===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
    let data = cdr(&[
        &[3, 0, 0, 0, b'a', b'b', 0, 0],          // name
        &[1, 0, 0, 0, 2, 0, 0, 0, b'c', 0, 0, 0], // names
        &[0; 4],                                  // wide
        &[0; 4],                                  // empty
        &[0, 0, 0, 0, 2, 0, 0, 0],                // nothing, padding, pairs
        &[7, 0, 0, 0],
        &1.5_f64.to_le_bytes(),
        &[8, 0, 0, 0, 0, 0, 0, 0],
        &2.5_f64.to_le_bytes(),
        &[1, 0, 2, 0],                                      // fixed
        &[9, 0, 0, 0, 10, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0], // header
        &[11, 0, 0, 0, 12, 0, 0, 0],                        // at
        &(-6_i32).to_le_bytes(),
    ]);
    for (field, expected) in [
        ("pairs[0].a", 7.0),
        ("pairs[1].b", 2.5),
        ("fixed[1].u", 2.0),
        ("header.stamp.nanosec", 10.0),
        ("at.sec", 11.0),
        ("last", -6.0),
    ] {
        assert_eq!(value(text, &data, field), expected, "{field}");
    }
    let bytes = twice(text, &data);
    let too_few = column_error(&bytes, "/x.pairs[2].a");
    assert_eq!(too_few, "message 1 of `/x`, at 0 s: `/x.pairs` is an array of 2, expected an index below 2, found 2");
}

#[test]
fn says_what_stands_at_a_place() {
    let bytes = twists(2, WriteOptions::new());
    let fields = "`/cmd_vel` is a message with the fields linear, angular, expected a number";
    for (column, text) in [
        ("/cmd_vel", fields),
        (
            "/cmd_vel.linaer.x",
            "no field of `/cmd_vel` is called `linaer`, expected one of linear, angular; did you mean `linear`?",
        ),
        ("/cmd_vel.linear", "`/cmd_vel.linear` is a message with the fields x, y, z, expected a number"),
        (
            "/cmd_vel.linear[0]",
            "`/cmd_vel.linear` is a message with the fields x, y, z, expected an array before an index",
        ),
        ("/cmd_vel.linear.x.y", "`/cmd_vel.linear.x` is a number, it has no field `y`"),
        ("/cmd_vel.", "expected a field such as `position[0]` or `linear.x` behind the topic, found ``"),
        ("/cmd_vel.a[-1]", "expected a field such as `position[0]` or `linear.x` behind the topic, found `a[-1]`"),
        (
            "/cmd_vle.linear.x",
            "no topic stands before a `.` of `/cmd_vle.linear.x`, expected one of /cmd_vel, /other; did you mean `/cmd_vel`?",
        ),
    ] {
        assert_eq!(column_error(&bytes, column), text);
    }
    let bytes = twice("string s\nint32[3] v\n", &cdr(&[&[0; 32]]));
    assert_eq!(column_error(&bytes, "/x.s"), "`/x.s` is a text, expected a number");
    assert_eq!(column_error(&bytes, "/x.v"), "`/x.v` is an array of 3, expected an index such as `/x.v[0]`");
    assert_eq!(column_error(&bytes, "/x.v[3]"), "`/x.v` is an array of 3, expected an index below 3, found 3");
    assert!(column_error(&File::plain().end(), "/x.v").ends_with("the file has none"));
}

#[test]
fn reads_json() {
    let mut file = File::plain();
    let x = file.topic("/a.b", ["jsonschema", "T", "{}"], "json");
    let short = file.topic("/a", ["", "", ""], "json");
    file.message(short, 0, b"no json").message(x, 5, br#"{"p":[{"x":1},{"x":2.5}],"on":true,"n":null,"s":"t"}"#);
    file.message(x, 1_000_000_005, br#"{"p":[{"x":3},{"x":-4e2}],"on":false}"#);
    let bytes = file.end();
    assert_eq!(series(&bytes, "/a.b.p[1].x"), Ok((vec![5e-9, 1.000000005], vec![2.5, -400.0])));
    assert_eq!(series(&bytes, "/a.b.on").unwrap().1, [1.0, 0.0]);
    let at = "message 1 of `/a.b`, at 0.000000005 s: ";
    assert_eq!(column_error(&bytes, "/a.b.s"), format!("{at}`/a.b.s` is a text, expected a number"));
    assert_eq!(column_error(&bytes, "/a.b.n"), format!("{at}`/a.b.n` is null, expected a number"));
    assert_eq!(
        column_error(&bytes, "/a.b.p"),
        format!("{at}`/a.b.p` is an array of 2, expected an index such as `/a.b.p[0]`")
    );
    assert!(file_error(&bytes, "/a.c").starts_with("message 1 of `/a`, at 0 s: expected ident"));
}

#[test]
fn times_increase() {
    let mut file = File::plain();
    let x = file.topic("/x", ["", "", ""], "json");
    for (time, v) in
        [(3_000_000_000, 1), (2_000_000_000, 2), (3_000_000_000, 3), (4_000_000_000, 4), (2_000_000_000, 5)]
    {
        file.message(x, time, format!("{{\"v\":{v}}}").as_bytes());
    }
    assert_eq!(series(&file.end(), "/x.v"), Ok((vec![0.0, 1.0, 2.0], vec![5.0, 3.0, 4.0])));
    for (times, text) in [
        (&[][..], "expected at least 2 messages on `/x`, found 0"),
        (&[7], "expected at least 2 messages on `/x`, found 1"),
        (&[7, 7], "expected at least 2 messages on `/x` at different times, found 2 at one"),
    ] {
        let mut file = File::plain();
        let x = file.topic("/x", ["", "", ""], "json");
        for time in times {
            file.message(x, *time, b"{\"v\":1}");
        }
        assert_eq!(column_error(&file.end(), "/x.v"), text);
    }
}

#[test]
fn numbers_are_finite() {
    let mut file = File::plain();
    let x = file.ros("/x", "p/T", "float64 v\n");
    for (time, v) in [(1_000_000_000, 0.0), (2_230_000_000, f64::NAN)] {
        file.message(x, time, &cdr(&[&f64s(&[v])]));
    }
    assert_eq!(file_error(&file.end(), "/x.v"), "`/x.v`: expected a finite number at 1.23 s, found NaN");
}

#[test]
fn names_encodings_that_it_does_not_read() {
    for (schema, messages, text) in [
        (["ros2idl", "p/T", ""], "cdr", "`/x` has a schema in the encoding `ros2idl`, expected `ros2msg`"),
        (["", "", ""], "cdr", "`/x` has no schema, expected one in the encoding `ros2msg`"),
        (
            ["protobuf", "T", ""],
            "protobuf",
            "`/x` has messages in the encoding `protobuf`, expected `cdr` (ROS 2) or `json`",
        ),
    ] {
        let mut file = File::plain();
        file.topic("/x", schema, messages);
        assert_eq!(column_error(&file.end(), "/x.v"), text);
    }
    let other = file_error(&twice("float64 v\n", &[0, 7, 0, 0, 0, 0, 0, 0]), "/x.v");
    let expected = "expected plain CDR, with the encapsulation 0x0000 or 0x0001, found 0x0007 (XCDR2)";
    assert_eq!(other, format!("message 1 of `/x`, at 0 s: {expected}"));
}

#[test]
fn refuses_definitions_that_mean_nothing() {
    let deep: String = (0..100).map(|k| format!("T{} x\n===\nMSG: p/T{}\n", k + 1, k + 1)).collect();
    for (text, expected) in [
        ("T x\n", "the definition of `p/T` contains itself"),
        ("U x\n", "the definition of `p/U` is missing in the file"),
        ("float64\n", "the definition of `p/T` has a line that is no field: \"float64\""),
        ("float64[0] x\n", "the definition of `p/T` has a line that is no field: \"float64[0] x\""),
        ("float64[1][2] x\n", "the definition of `p/T` has a line that is no field: \"float64[1][2] x\""),
        (&deep, "the definition of `p/T64` is too deep in others"),
    ] {
        assert_eq!(file_error(&twice(text, &[]), "/x.x"), expected);
    }
}

#[test]
fn lengths_of_messages_are_not_believed() {
    let huge = [255_u8; 4];
    for (text, data) in [
        ("string s\nfloat64 v\n", cdr(&[&huge])),
        ("float64[] s\nfloat64 v\n", cdr(&[&huge])),
        ("string[] s\nfloat64 v\n", cdr(&[&huge, &[0; 64]])),
        ("E[] s\nfloat64 v\n===\nMSG: p/E\n", cdr(&[&huge, &[0; 64]])),
        ("E[18446744073709551615] s\nfloat64 v\n===\nMSG: p/E\n", cdr(&[&[0; 64]])),
        ("float64[18446744073709551615] s\nfloat64 v\n", cdr(&[&[0; 64]])),
        ("float64 v\n", vec![0, 1]),
        ("float64 v\n", cdr(&[&[0; 7]])),
        ("wstring s\nfloat64 v\n", cdr(&[&[1, 0, 0, 0, 65, 0, 0, 0], &[0; 16]])),
    ] {
        let found = file_error(&twice(text, &data), "/x.v");
        assert!(found.starts_with("message 1 of `/x`, at 0 s: "), "{found}");
    }
}

/// A few messages in every kind of chunk.
fn samples() -> Vec<(Vec<u8>, &'static str)> {
    let mut all: Vec<(Vec<u8>, &str)> = [None, Some(Compression::Zstd), Some(Compression::Lz4)]
        .into_iter()
        .map(|kind| (twists(9, WriteOptions::new().compression(kind).chunk_size(Some(500))), "/cmd_vel.linear.x"))
        .collect();
    all.push((twists(9, WriteOptions::new().use_chunks(false)), "/cmd_vel.linear.x"));
    let text = "string s\nE[] e\nfloat64 v\n===\nMSG: p/E\nuint8 a\n";
    all.push((twice(text, &cdr(&[&[2, 0, 0, 0, 65, 0, 0, 0, 2, 0, 0, 0, 1, 1, 0, 0], &[0; 8]])), "/x.v"));
    all
}

#[test]
fn a_file_that_was_cut_is_read_as_far_as_it_goes() {
    for (bytes, column) in samples() {
        let whole = series(&bytes, column).unwrap();
        let mut most = 0;
        for length in 0..bytes.len() {
            match series(&bytes[..length], column) {
                Ok((times, values)) => {
                    assert!(times.len() >= most, "{} messages at {length}, {most} before", times.len());
                    most = times.len();
                    assert_eq!((&times, &values), (&whole.0[..most].to_vec(), &whole.1[..most].to_vec()));
                }
                Err(DataError::Column(_)) => assert_eq!(most, 0, "at {length}"),
                Err(error) => panic!("at {length}: {error:?}"),
            }
        }
        assert_eq!(most, whole.0.len());
        let mut reserved = bytes[..bytes.len() / 2].to_vec();
        reserved.extend([0; 100]);
        _ = series(&reserved, column);
    }
}

#[test]
fn damage_does_no_harm() {
    for (bytes, column) in samples() {
        for place in 8..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[place] ^= 0x81;
            if let Ok((times, values)) = series(&bytes, column) {
                assert!(times.len() == values.len() && times.windows(2).all(|pair| pair[0] < pair[1]));
            }
        }
        // A whole file with a record that is too long.
        let mut long = bytes.clone();
        long[8 + 1 + 7] = 1;
        let found = file_error(&long, column);
        assert_eq!(found, "the file is damaged at byte 8: a record ends behind the end of the file");
    }
}

#[test]
fn chunks_are_checked() {
    for kind in [None, Some(Compression::Zstd)] {
        let bytes = twists(9, WriteOptions::new().compression(kind).chunk_size(Some(500)));
        let chunk = 8 + 9 + usize::from(bytes[9]);
        assert_eq!(bytes[chunk], mcap::records::op::CHUNK);
        let mut wrong = bytes.clone();
        wrong[chunk + 9 + 24] ^= 1;
        let found = file_error(&wrong, "/cmd_vel.linear.x");
        assert_eq!(found, format!("the file is damaged at byte {chunk}: the checksum of the chunk is wrong"));
        if kind.is_some() {
            let mut other = bytes;
            other[chunk + 9 + 32] = b'x';
            let found = file_error(&other, "/cmd_vel.linear.x");
            assert!(
                found.ends_with("expected a chunk with the compression zstd, lz4 or none, found \"xstd\""),
                "{found}"
            );
        }
    }
}
