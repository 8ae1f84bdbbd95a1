//! That schema, bytes and layout say the same, by the rules of CDR and not by those of this program.

use super::*;

/// Byte offset and number of elements of each primitive field of a ROS 2 message of fixed size, behind the encapsulation.
fn offsets(text: &str) -> Vec<(String, usize, usize)> {
    let separator = format!("{}\n", "=".repeat(80));
    let mut definitions = text.split(&separator);
    let main = definitions.next().unwrap();
    let nested: BTreeMap<&str, &str> =
        definitions.map(|part| part.strip_prefix("MSG: ").unwrap().split_once('\n').unwrap()).collect();
    let (mut position, mut found) = (0, Vec::new());
    place(main, "", &nested, &mut position, &mut found);
    found.push((String::from("end"), position, 0));
    found
}

fn place(
    text: &str,
    prefix: &str,
    nested: &BTreeMap<&str, &str>,
    position: &mut usize,
    found: &mut Vec<(String, usize, usize)>,
) {
    for line in text.lines() {
        let mut words = line.split('#').next().unwrap().split_whitespace();
        let (kind, name) = (words.next().unwrap(), words.next().unwrap());
        let (kind, count) = match kind.split_once('[') {
            Some((kind, length)) => (kind, length.trim_end_matches(']').parse().unwrap()),
            None => (kind, 1),
        };
        let size = match kind {
            "int32" | "uint32" => 4,
            "uint64" | "float64" => 8,
            _ => {
                place(nested[kind], &format!("{prefix}{name}."), nested, position, found);
                continue;
            }
        };
        *position = position.next_multiple_of(size);
        found.push((format!("{prefix}{name}"), *position, count));
        *position += size * count;
    }
}

#[test]
fn layout_and_schema_agree_on_every_offset() {
    for channel in &Run::new(1, 5).network.channels {
        let mut found = offsets(&channel.layout.ros2msg());
        assert_eq!(found.pop(), Some(("end".into(), channel.layout.bytes(), 0)));
        let (header, fields) = found.split_at(5);
        let header: Vec<_> = header.iter().map(|(name, at, _)| (name.as_str(), *at)).collect();
        assert_eq!(header, [("stamp.sec", 0), ("stamp.nanosec", 4), ("step", 8), ("agent", 16), ("status", 20)]);
        for (name, at, count) in fields {
            let (offset, words) = channel.layout.find(name).unwrap();
            assert_eq!((*at, *count), (lockstep::HEADER_BYTES + 8 * offset, words), "{name}");
        }
    }
}

#[test]
fn bytes_in_the_file_stand_where_the_schema_says() {
    let scratch = Scratch::new("cdr");
    let path = scratch.file("run.mcap");
    let run = Run::new(1, 5);
    run.record(&path, 4);
    // Read with the library alone.
    let file = fs::read(&path).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&file).unwrap().map(Result::unwrap).collect();
    assert_eq!(messages.len(), 8);
    for (index, message) in messages.iter().enumerate() {
        let (step, channel) = (index as u64 / 2, index % 2);
        assert_eq!((message.sequence as u64, message.log_time), (step, step * PERIOD_NS));
        assert_eq!(message.publish_time, message.log_time);
        assert_eq!(message.data[..4], [0, 1, 0, 0]);
        let body = &message.data[4..];
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!((schema.encoding.as_str(), message.channel.message_encoding.as_str()), ("ros2msg", "cdr"));
        let mut word = 0;
        for (name, at, count) in offsets(std::str::from_utf8(&schema.data).unwrap()) {
            match name.as_str() {
                "stamp.sec" | "stamp.nanosec" | "status" => {}
                "step" => {
                    let computed = run.header(step, ChannelId(channel)).step;
                    assert_eq!(u64::from_le_bytes(body[at..at + 8].try_into().unwrap()), computed);
                }
                "agent" => assert_eq!(u32::from_le_bytes(body[at..at + 4].try_into().unwrap()), 1),
                "end" => assert_eq!(at, body.len()),
                _ => {
                    for bytes in body[at..at + 8 * count].chunks_exact(8) {
                        let value = f64::from_le_bytes(bytes.try_into().unwrap());
                        assert_eq!(value, Run::value(step, channel, word));
                        word += 1;
                    }
                }
            }
        }
    }
}

#[test]
fn nothing_of_the_machine_is_in_the_file() {
    let scratch = Scratch::new("machine");
    let path = scratch.file("run.mcap");
    Run::new(1, 1).record(&path, 3);
    let summary = mcap::Summary::read(&fs::read(&path).unwrap()).unwrap().unwrap();
    let attachment = &summary.attachment_indexes[0];
    assert_eq!((attachment.create_time, attachment.log_time), (0, 0));
    assert_eq!((attachment.name.as_str(), attachment.media_type.as_str()), ("scenario.toml", "application/toml"));
    assert_eq!(summary.metadata_indexes[0].name, "phalanx");
    assert_eq!(summary.stats.unwrap().message_end_time, 2 * PERIOD_NS);
}
