//! Files that are cut, damaged, or of another program, and disks that are full.

use std::io::{self, Write};

use super::*;
use crate::sink::{ChannelRecord, SchemaRecord, Sink};
use crate::target::Plain;

/// The same numbers in every run of the test.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }
}

#[test]
fn a_cut_log_is_read_up_to_the_cut_and_recovered() {
    let scratch = Scratch::new("cut");
    let (path, cut, out) = (scratch.file("run.mcap"), scratch.file("cut.mcap"), scratch.file("out.mcap"));
    let run = Run::new(2, 3);
    run.record(&path, 95);
    let bytes = fs::read(&path).unwrap();
    let mut random = Random(1);
    let mut seen = 0;
    for round in 0..200 {
        let length = if round == 0 { bytes.len() - 1 } else { random.below(bytes.len()) };
        fs::write(&cut, &bytes[..length]).unwrap();
        let log = match Log::open(&cut) {
            Ok(log) => log,
            Err(LogError::NotMcap { .. } | LogError::Foreign { .. }) => {
                assert!(length < 400, "{length}");
                continue;
            }
            Err(error) => panic!("{length}: {error}"),
        };
        let steps = log.steps().end;
        assert!(!log.is_complete() && (steps % 10 == 0 || steps == 95), "{steps}");
        if log.channels().is_empty() {
            // Killed before the first flush, which brings channels and samples.
            assert_eq!(steps, 0);
            continue;
        }
        run.check(&log, steps);
        let recovered = recover(&cut, &out).unwrap();
        assert_eq!((recovered.file.messages, recovered.was_complete), (steps * 4, false));
        assert!(recovered.damage.is_none());
        assert_eq!(recovered.until_ns.is_some(), steps > 0);
        let log = Log::open(&out).unwrap();
        assert!(log.is_complete());
        run.check(&log, steps);
        assert_eq!(log.metadata(), Some(&run.metadata));
        fs::write(&cut, &bytes[..length - recovered.lost as usize]).unwrap();
        let again = recover(&cut, &out).unwrap();
        assert_eq!((again.lost, again.file.messages), (0, steps * 4), "what is told to be lost is all that is lost");
        seen = seen.max(steps);
    }
    assert_eq!(seen, 95);
    assert!(matches!(recover(&cut, &cut), Err(LogError::SameFile { .. })));
    let recovered = recover(&path, &out).unwrap();
    assert_eq!(
        (recovered.was_complete, recovered.channels, recovered.attachments, recovered.metadata),
        (true, 4, 1, 2)
    );
}

#[test]
fn flipped_bits_never_panic_and_never_go_unseen() {
    let scratch = Scratch::new("flip");
    let (path, out) = (scratch.file("run.mcap"), scratch.file("out.mcap"));
    let run = Run::new(1, 2);
    run.record(&path, 25);
    let good = fs::read(&path).unwrap();
    let mut random = Random(2);
    for round in 0..1500 {
        let mut bytes = good.clone();
        let mut first = bytes.len();
        for _ in 0..1 + round % 3 {
            let place = random.below(bytes.len());
            bytes[place] ^= 1 << random.below(8);
            first = first.min(place);
        }
        fs::write(&path, &bytes).unwrap();
        let complete = Log::open(&path).is_ok_and(|log| log.is_complete());
        assert!(!complete || bytes == good, "flip at {first} went unseen");
        let _ = recover(&path, &out);
    }
}

#[test]
fn a_damaged_summary_is_named_and_made_anew() {
    let scratch = Scratch::new("summary");
    let (path, out) = (scratch.file("run.mcap"), scratch.file("out.mcap"));
    let run = Run::new(1, 2);
    run.record(&path, 25);
    let good = fs::read(&path).unwrap();
    let last = mcap::Summary::read(&good).unwrap().unwrap().chunk_indexes.pop().unwrap();
    // The end of the data takes 13 bytes.
    let start = (last.chunk_start_offset + last.chunk_length + last.message_index_length) as usize + 13;
    for place in start..good.len() {
        let mut bytes = good.clone();
        bytes[place] ^= 1 << (place % 8);
        fs::write(&path, &bytes).unwrap();
        match Log::open(&path) {
            Err(error @ LogError::Damaged { .. }) => assert!(error.to_string().contains("recover"), "{place}: {error}"),
            // The length of the last records, or the last bytes: as if it were cut.
            Ok(log) => assert!(!log.is_complete(), "flip at {place} went unseen"),
            Err(error) => panic!("{place}: {error}"),
        }
        let recovered = recover(&path, &out).unwrap();
        assert_eq!((recovered.file.messages, fs::read(&out).unwrap() == good), (50, true), "{place}");
    }
}

/// A summary whose checksum fits, but that says something else than the data.
#[test]
fn a_summary_that_lies_is_refused() {
    let scratch = Scratch::new("lies");
    let path = scratch.file("run.mcap");
    Run::new(1, 2).record(&path, 25);
    let good = fs::read(&path).unwrap();
    let footer = good.len() - 37;
    let start = u64::from_le_bytes(good[footer + 9..footer + 17].try_into().unwrap()) as usize;
    let mut refused = 0;
    for place in start..footer + 25 {
        let mut bytes = good.clone();
        bytes[place] ^= 1;
        let checksum = crc32fast::hash(&bytes[start..footer + 25]);
        bytes[footer + 25..footer + 29].copy_from_slice(&checksum.to_le_bytes());
        fs::write(&path, &bytes).unwrap();
        refused += usize::from(!Log::open(&path).is_ok_and(|log| log.is_complete()));
    }
    // A media type of an attachment says nothing that could be compared, and an index may name itself something unknown.
    assert!(refused * 100 > 95 * (footer + 25 - start), "{refused} of {}", footer + 25 - start);
}

#[test]
fn a_damaged_chunk_costs_what_follows_it() {
    let scratch = Scratch::new("damaged");
    let (path, out) = (scratch.file("run.mcap"), scratch.file("out.mcap"));
    let run = Run::new(1, 2);
    run.record(&path, 50);
    let mut bytes = fs::read(&path).unwrap();
    let chunk = &mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes[2];
    bytes[(chunk.chunk_start_offset + chunk.chunk_length) as usize - 1] ^= 1;
    fs::write(&path, &bytes).unwrap();
    let error = Log::open(&path).unwrap_err().to_string();
    assert!(error.contains(&format!("at byte {}", chunk.chunk_start_offset)) && error.contains("recover"), "{error}");
    let recovered = recover(&path, &out).unwrap();
    assert!(recovered.damage.is_some());
    assert_eq!(recovered.lost, bytes.len() as u64 - chunk.chunk_start_offset);
    run.check(&Log::open(&out).unwrap(), 20);
}

#[test]
fn lengths_are_not_believed() {
    let scratch = Scratch::new("lengths");
    let path = scratch.file("x.mcap");
    let open = |bytes: &[&[u8]]| {
        fs::write(&path, bytes.concat()).unwrap();
        Log::open(&path).unwrap_err().to_string()
    };
    assert!(open(&[b""]).contains("it is empty"));
    assert!(open(&[b"topic,step,x\n1,2,3\n"]).contains("magic"));
    let huge = u64::MAX.to_le_bytes();
    assert!(open(&[mcap::MAGIC, &[6], &huge]).contains("claims"));
    // A chunk that claims to hold 2^64-1 bytes, and one that claims 200 MiB, each behind a good one.
    let chunk = |size: u64, compression: &[u8], stored: &[u8]| {
        let name = (compression.len() as u32).to_le_bytes();
        let length = (stored.len() as u64).to_le_bytes();
        let body = [&[0; 16], &size.to_le_bytes()[..], &[0; 4], &name, compression, &length, stored].concat();
        [&[6], &(body.len() as u64).to_le_bytes()[..], &body].concat()
    };
    let good = chunk(9, b"", &[0x80, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert!(open(&[mcap::MAGIC, &good, &good]).contains("not of this program"));
    assert!(open(&[mcap::MAGIC, &good, &chunk(u64::MAX, b"zstd", &[0; 4])]).contains("more than allowed"));
    assert!(open(&[mcap::MAGIC, &good, &chunk(200 << 20, b"zstd", &[0; 4])]).contains("cannot be decompressed"));
    assert!(open(&[mcap::MAGIC, &good, &chunk(4, b"lz4", &[0; 4])]).contains("compressed with \"lz4\""));
    // A schema whose text claims 4 GiB.
    let schema = [&[1, 0], &[0; 8][..], &u32::MAX.to_le_bytes()].concat();
    assert!(open(&[mcap::MAGIC, &[3], &14_u64.to_le_bytes(), &schema]).contains("schema"));
}

#[test]
fn logs_of_other_programs_are_named_so() {
    let scratch = Scratch::new("foreign");
    let path = scratch.file("x.mcap");
    let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    let channel = writer.add_channel(0, "/chat", "json", &BTreeMap::new()).unwrap();
    let header = mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, b"{}").unwrap();
    writer.finish().unwrap();
    assert!(matches!(Log::open(&path), Err(LogError::Foreign { .. })));
    assert!(matches!(Log::open(&scratch.file("none.mcap")), Err(LogError::Read { .. })));
    assert!(matches!(Log::open(&scratch.0), Err(LogError::Read { .. })));
}

#[test]
fn a_missing_sample_is_named() {
    let scratch = Scratch::new("missing");
    let path = scratch.file("x.mcap");
    let layout = Layout::new([Field::scalar("x", "m")]);
    let write = |samples: &[(u16, u32, u64, usize)]| {
        let mut sink = Sink::new(Plain(fs::File::create(&path).unwrap()), "ros2", "test").unwrap();
        let (name, encoding) = (String::from("phalanx_msgs/msg/X"), String::from("ros2msg"));
        sink.schema(SchemaRecord { id: 1, name, encoding, text: layout.ros2msg().into() }).unwrap();
        for id in 0..2 {
            let (topic, encoding) = (format!("/agent_{id}/x"), String::from("cdr"));
            sink.channel(ChannelRecord { id, schema: 1, topic, encoding, metadata: BTreeMap::new() }).unwrap();
        }
        for (channel, sequence, time_ns, bytes) in samples {
            let mut message =
                [&ENCAPSULATION[..], &Header::new(*sequence as u64, 5, u32::from(*channel), Status::Fresh).to_bytes()]
                    .concat();
            message.resize(*bytes, 0);
            sink.message(*channel, *sequence, [*time_ns; 2], &message).unwrap();
        }
        sink.finish(path.clone()).1.unwrap();
        Log::open(&path).map(|log| log.steps()).map_err(|error| error.to_string())
    };
    assert_eq!(write(&[(0, 0, 0, 36), (1, 0, 0, 36), (0, 1, 5, 36), (1, 1, 5, 36)]), Ok(0..2));
    let missing = "topic /agent_1/x lacks its sample of step 1";
    assert!(write(&[(0, 0, 0, 36), (1, 0, 0, 36), (0, 1, 5, 36)]).unwrap_err().contains(missing));
    assert!(write(&[(1, 0, 0, 36), (1, 2, 0, 36)]).unwrap_err().contains(missing));
    assert!(write(&[(0, 0, 0, 36), (1, 0, 0, 36), (0, 1, 5, 36), (1, 1, 6, 36)]).unwrap_err().contains("6 ns"));
    assert!(write(&[(0, 0, 0, 35)]).unwrap_err().contains("32 bytes"));
    let lying = write(&[(0, 0, 5, 36), (1, 0, 5, 36)]).unwrap_err();
    assert!(lying.contains("the sample of step 0 (5 ns) says that it is that of step 0 (0 ns)"), "{lying}");
}

/// A disk with so many bytes left.
struct Disk(usize);

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_an_error_with_the_name_of_the_file() {
    let run = Run::new(2, 3);
    let error = Recorder::create(Path::new("/dev/full"), &run.info()).unwrap_err().to_string();
    assert!(error.contains("/dev/full: it is a device"), "{error}");
    let error = Recorder::on(Disk(100), Path::new("run.mcap"), &run.info()).unwrap_err().to_string();
    assert!(error.contains("cannot write log run.mcap: no storage space"), "{error}");
    // Full after the beginning: a later step says so, and every call after it.
    let mut recorder = Recorder::on(Disk(20_000), Path::new("run.mcap"), &run.info()).unwrap();
    let error = run.drive(&mut recorder, 0..u64::MAX).unwrap_err().to_string();
    assert!(error.contains("cannot write log run.mcap: no storage space"), "{error}");
    assert!(matches!(recorder.add_channel("/x", "x/msg/X", "", Durability::Volatile), Err(LogError::Write { .. })));
    assert!(matches!(recorder.finish(), Err(LogError::Write { .. })));
    // Full at the very end.
    let run = Run { flush_every: 1 << 40, ..run };
    let mut recorder = Recorder::on(Disk(20_000), Path::new("run.mcap"), &run.info()).unwrap();
    run.drive(&mut recorder, 0..500).unwrap();
    assert!(matches!(recorder.finish(), Err(LogError::Write { .. })));
}
