//! A run of made-up samples, recorded and read back.

#![allow(clippy::disallowed_types, clippy::disallowed_methods, reason = "tests measure time and make up numbers")]

mod cdr;
mod hostile;
mod manual;
mod shown;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use lockstep::{Channel, ChannelId, Field, Header, Layout, Network, Status, Store};

use super::*;

const PERIOD_NS: u64 = 1_000_000;

/// A directory that goes away with the test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("phalanx-log-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A fake run: two channels for each agent, of which the second is computed at every third step only.
struct Run {
    network: Network,
    metadata: BTreeMap<String, String>,
    flush_every: u64,
}

impl Run {
    fn new(agents: u32, output_words: usize) -> Self {
        let state = Layout::new([
            Field::vector("position", 3, "m"),
            Field::vector("velocity", 3, "m/s"),
            Field::scalar("flag", ""),
        ]);
        let output = Layout::new([Field::scalar("norm", "N"), Field::vector("force", output_words, "N")]);
        let channels = (1..=agents).flat_map(|agent| {
            [("state", &state), ("controller_output", &output)].map(|(name, layout)| Channel {
                topic: format!("/agent_{agent}/{name}"),
                agent,
                layout: layout.clone(),
                initial: Vec::new(),
            })
        });
        let network = Network { channels: channels.collect(), nodes: Vec::new() };
        let metadata = BTreeMap::from([("scenario".into(), "nobody".into()), ("variant".into(), String::new())]);
        Self { network, metadata, flush_every: 10 }
    }

    fn info(&self) -> RunInfo<'_> {
        RunInfo {
            network: &self.network,
            period: PERIOD_NS.into(),
            scenario: "name = \"nobody\"\n",
            metadata: &self.metadata,
            flush_every: self.flush_every,
        }
    }

    fn store(&self) -> Store {
        Store::new(self.network.channels.iter().map(|channel| &channel.layout))
    }

    fn value(step: u64, channel: usize, word: usize) -> f64 {
        (step as f64 * 0.01 + channel as f64).sin() + word as f64
    }

    fn compute(&self, store: &mut Store, step: u64) {
        for index in 0..self.network.channels.len() {
            for (word, place) in store.write(ChannelId(index), step).iter_mut().enumerate() {
                *place = Self::value(step, index, word);
            }
        }
    }

    fn header(&self, step: u64, channel: ChannelId) -> Header {
        let agent = self.network.channels[channel.0].agent;
        match channel.0 % 2 == 1 && !step.is_multiple_of(3) {
            true => Header::new(step - step % 3, PERIOD_NS, agent, Status::Held),
            false => Header::new(step, PERIOD_NS, agent, Status::Fresh),
        }
    }

    fn drive(&self, recorder: &mut Recorder, steps: std::ops::Range<u64>) -> Result<(), LogError> {
        let mut store = self.store();
        for step in steps {
            self.compute(&mut store, step);
            recorder.record(step, &store, |channel| self.header(step, channel))?;
        }
        Ok(())
    }

    fn record(&self, path: &Path, steps: u64) -> Summary {
        let mut recorder = Recorder::create(path, &self.info()).unwrap();
        self.drive(&mut recorder, 0..steps).unwrap();
        recorder.finish().unwrap().unwrap()
    }

    /// That the log holds exactly the first `steps` steps.
    fn check(&self, log: &Log, steps: u64) {
        assert_eq!(log.steps(), 0..steps);
        assert_eq!(log.times(), (0..steps).map(|step| step * PERIOD_NS).collect::<Vec<_>>());
        for (index, channel) in self.network.channels.iter().enumerate() {
            let mut word = 0;
            for field in channel.layout.fields() {
                let series = log.signal(&channel.topic, &field.name).unwrap();
                assert_eq!((series.width(), series.len() as u64), (field.shape.words(), steps));
                for (step, row) in series.rows().enumerate() {
                    for (place, value) in row.iter().enumerate() {
                        assert_eq!(*value, Self::value(step as u64, index, word + place));
                    }
                }
                word += field.shape.words();
            }
            let headers = ["step", "status"].map(|field| log.signal(&channel.topic, field).unwrap());
            for step in 0..steps {
                let header = self.header(step, ChannelId(index));
                let read = headers.map(|series| series.row(step as usize)[0]);
                assert_eq!(read, [header.step as f64, f64::from(header.status)]);
            }
        }
    }
}

#[test]
fn what_was_recorded_is_read() {
    let scratch = Scratch::new("round-trip");
    let path = scratch.file("run.mcap");
    let run = Run::new(3, 5);
    let summary = run.record(&path, 205);
    assert_eq!((summary.messages, summary.bytes), (205 * 6, fs::metadata(&path).unwrap().len()));
    let log = Log::open(&path).unwrap();
    assert!(log.is_complete());
    assert_eq!((log.scenario_text(), log.metadata()), (Some("name = \"nobody\"\n"), Some(&run.metadata)));
    for (read, written) in log.channels().iter().zip(&run.network.channels) {
        assert_eq!((&read.topic, read.agent, read.messages), (&written.topic, written.agent, 205));
        assert_eq!(read.layout.as_ref(), Some(&written.layout));
    }
    assert!(log.channels()[1].schema.starts_with("phalanx_msgs/msg/ControllerOutput"));
    run.check(&log, 205);
    assert!(log.signal("/agent_1/state", "speed").is_none() && log.signal("/agent_9/state", "flag").is_none());
}

#[test]
fn data_files_are_read_back() {
    let scratch = Scratch::new("data");
    let path = scratch.file("run.mcap");
    let run = Run::new(1, 1);
    let mut recorder = Recorder::create(&path, &run.info()).unwrap();
    recorder.attach_data("../wind.csv", b"t,vx\n0,1\n").unwrap();
    let store = run.store();
    recorder.record(0, &store, |_| Header::new(0, PERIOD_NS, 1, Status::Fresh)).unwrap();
    recorder.finish().unwrap();
    let (head, log) = (Head::read(&path).unwrap(), Log::open(&path).unwrap());
    let data = BTreeMap::from([("../wind.csv".to_string(), b"t,vx\n0,1\n".as_slice().into())]);
    assert_eq!((&head.data, log.data()), (&data, &data));
    assert_eq!(head.scenario.as_deref(), Some("name = \"nobody\"\n"));
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let scratch = Scratch::new("same");
    let run = Run::new(2, 4);
    let [first, second] = ["a.mcap", "b.mcap"].map(|name| run.record(&scratch.file(name), 333));
    assert_eq!(first.sha256, second.sha256);
    let bytes = fs::read(&first.path).unwrap();
    assert_eq!(bytes, fs::read(&second.path).unwrap());
    use sha2::{Digest, Sha256};
    assert_eq!(first.sha256, format!("{:x}", Sha256::digest(bytes)));
}

#[test]
fn a_dropped_recorder_leaves_a_whole_file() {
    let scratch = Scratch::new("drop");
    let path = scratch.file("run.mcap");
    let run = Run::new(1, 1);
    let mut recorder = Recorder::create(&path, &run.info()).unwrap();
    run.drive(&mut recorder, 0..17).unwrap();
    drop(recorder);
    let log = Log::open(&path).unwrap();
    assert!(log.is_complete());
    run.check(&log, 17);
}

#[test]
fn prepared_messages_stand_among_the_samples() {
    let scratch = Scratch::new("extra");
    let path = scratch.file("run.mcap");
    let run = Run::new(1, 1);
    let mut recorder = Recorder::create(&path, &run.info()).unwrap();
    let extra = recorder.add_channel("/log", "std_msgs/msg/UInt8", "uint8 data\n", Durability::Volatile).unwrap();
    assert!(matches!(recorder.write(extra, 0, &[0, 1, 0, 0, 7]), Err(LogError::StepOrder { .. })));
    run.drive(&mut recorder, 0..30).unwrap();
    recorder.write(extra, 29, &[0, 1, 0, 0, 7]).unwrap();
    let late = recorder.add_channel("/late", "std_msgs/msg/UInt8", "uint8 data\n", Durability::Volatile).unwrap();
    let conflict = recorder.add_channel("/other", "std_msgs/msg/UInt8", "uint16 data\n", Durability::Volatile);
    assert!(matches!(conflict, Err(LogError::SchemaConflict { .. })));
    recorder.write(late, 29, &[0, 1, 0, 0, 8]).unwrap();
    run.drive(&mut recorder, 30..40).unwrap();
    assert!(matches!(recorder.write(late, 29, &[]), Err(LogError::StepOrder { expected: 39, found: 29 })));
    assert_eq!(recorder.finish().unwrap().unwrap().messages, 82);
    let log = Log::open(&path).unwrap();
    run.check(&log, 40);
    let listed: Vec<_> =
        log.channels()[2..].iter().map(|c| (c.topic.as_str(), c.messages, c.layout.is_none())).collect();
    assert_eq!(listed, [("/log", 1, true), ("/late", 1, true)]);
}

#[test]
fn a_step_left_out_is_refused() {
    let scratch = Scratch::new("order");
    let run = Run::new(1, 1);
    let mut recorder = Recorder::create(&scratch.file("run.mcap"), &run.info()).unwrap();
    run.drive(&mut recorder, 5..8).unwrap();
    assert!(matches!(run.drive(&mut recorder, 9..10), Err(LogError::StepOrder { expected: 8, found: 9 })));
    recorder.finish().unwrap();
    assert_eq!(Log::open(&scratch.file("run.mcap")).unwrap().steps(), 5..8);
}
