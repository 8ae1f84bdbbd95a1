//! A log read step by step: some of its topics, and no more memory than a few chunks take, however long it is.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use lockstep::{Header, Layout};

use super::header::Headers;
use super::reader::sample;
use super::record::Record;
use super::schema::layout_of;
use super::walk::{Ending, walk};
use super::{DATA, LogError, METADATA, SCENARIO};

/// Chunks that are read ahead.
const READ_AHEAD: usize = 2;

/// What a log says before its first sample.
#[derive(Clone, Debug, Default)]
pub struct Head {
    /// The scenario that was run, TOML.
    pub scenario: Option<String>,
    /// The data files of the scenario, by the path that its formulas name.
    pub data: BTreeMap<String, Arc<[u8]>>,
    /// What the recorder was told about the run.
    pub metadata: BTreeMap<String, String>,
    /// Topics with the fields of their samples, in the order of the file. Topics of other kinds are left out.
    pub topics: Vec<(String, Layout)>,
}

impl Head {
    /// Reads the log `path` up to its first sample.
    ///
    /// # Errors
    /// As those of [`Log::open`](super::Log::open).
    pub fn read(path: &Path) -> Result<Self, LogError> {
        let foreign = || LogError::Foreign { path: path.into() };
        let mut head = Self::default();
        let mut schemas = BTreeMap::new();
        let mut enough = false;
        let result = walk(path, |at, record| {
            match record {
                Record::Message { .. } => {
                    enough = true;
                    // Ends the walk; what the error says does not matter.
                    return Err(foreign());
                }
                Record::Schema { id, encoding: "ros2msg", text, .. } => {
                    schemas.insert(id, layout_of(text));
                }
                Record::Channel { schema, topic, encoding: "cdr", .. } => {
                    let layout = schemas.get(&schema).cloned().flatten();
                    head.topics.extend(layout.map(|layout| (topic.to_string(), layout)));
                }
                Record::Attachment { name: SCENARIO, data, .. } => {
                    let text = String::from_utf8(data.into());
                    let text = text.map_err(|_| LogError::damaged(path, at, "the scenario is no text"))?;
                    head.scenario = Some(text);
                }
                Record::Attachment { name, data, .. } => {
                    head.data.extend(name.strip_prefix(DATA).map(|path| (path.to_string(), data.into())));
                }
                Record::Metadata { name: METADATA, metadata } => head.metadata = metadata,
                _ => {}
            }
            Ok(())
        });
        match result {
            Err(error) if !enough => Err(error),
            _ if head.metadata.is_empty() && head.topics.is_empty() => Err(foreign()),
            _ => Ok(head),
        }
    }
}

/// Complete steps, one after the other.
#[derive(Debug, Default)]
struct Block {
    /// Number and simulated time of every step, the latter in ns.
    steps: Vec<(u64, u64)>,
    /// Header of every topic at every step.
    headers: Vec<Header>,
    /// Words of every topic at every step.
    words: Vec<f64>,
}

/// Some topics of a log, step by step. A thread of its own reads and unpacks ahead.
#[derive(Debug)]
pub struct Stream {
    blocks: Receiver<Result<Block, LogError>>,
    block: Block,
    /// The row of `block` that is the current step.
    row: Option<usize>,
    /// Where the words of every topic are within those of a step; the last entry is their number.
    places: Vec<usize>,
    path: PathBuf,
}

impl Stream {
    /// Opens the log `path` for these topics, whose layouts must be those of its [`Head`].
    ///
    /// # Errors
    /// [`LogError::Read`] if the thread that reads cannot be started; all else is found out by [`advance`](Self::advance).
    pub fn open(path: &Path, topics: &[(String, Layout)]) -> Result<Self, LogError> {
        let (sender, blocks) = sync_channel(READ_AHEAD);
        let mut places = vec![0];
        for (_, layout) in topics {
            places.push(places[places.len() - 1] + layout.words());
        }
        let reading = Reading {
            path: path.into(),
            topics: topics.to_vec(),
            seen: topics.iter().map(|(topic, _)| Headers::of(topic)).collect(),
            places: places.clone(),
            index: Vec::new(),
            row: Row { step: None, headers: vec![None; topics.len()], words: vec![0.0; places[places.len() - 1]] },
            next: None,
            block: Block::default(),
            sender,
        };
        let reader = thread::Builder::new().name("replay".into()).spawn(move || reading.run());
        reader.map_err(|error| LogError::read(path, error))?;
        Ok(Self { blocks, block: Block::default(), row: None, places, path: path.into() })
    }

    /// Goes to the next step; `false` if there is none. That of a run that was killed ends where its file is cut.
    ///
    /// # Errors
    /// [`LogError`] if the file is damaged there, or lacks a sample.
    pub fn advance(&mut self) -> Result<bool, LogError> {
        let next = self.row.map_or(0, |row| row + 1);
        if next < self.block.steps.len() {
            self.row = Some(next);
            return Ok(true);
        }
        match self.blocks.recv() {
            Ok(block) => (self.block, self.row) = (block?, Some(0)),
            // The thread is done, so that there is nothing behind the current row.
            Err(_) => return Ok(false),
        }
        Ok(true)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of the current step; `None` before the first.
    pub fn step(&self) -> Option<u64> {
        self.row.map(|row| self.block.steps[row].0)
    }

    /// Simulated time of the current step, ns; 0 before the first.
    pub fn time_ns(&self) -> u64 {
        self.row.map_or(0, |row| self.block.steps[row].1)
    }

    /// The header of topic number `topic` at the current step.
    ///
    /// # Panics
    /// Before the first step, or if there are fewer topics; so does [`words`](Self::words).
    pub fn header(&self, topic: usize) -> Header {
        let row = self.row.expect("`advance` comes first");
        self.block.headers[row * (self.places.len() - 1) + topic]
    }

    /// The numbers of topic number `topic` at the current step.
    pub fn words(&self, topic: usize) -> &[f64] {
        let row = self.row.expect("`advance` comes first");
        let stride = self.places[self.places.len() - 1];
        &self.block.words[row * stride + self.places[topic]..row * stride + self.places[topic + 1]]
    }
}

/// A step that is not complete yet.
struct Row {
    /// Its number as far as it stands in the file, and its time.
    step: Option<(u32, u64)>,
    headers: Vec<Option<Header>>,
    words: Vec<f64>,
}

/// What the reading thread owns.
struct Reading {
    path: PathBuf,
    topics: Vec<(String, Layout)>,
    /// What the headers of every topic said so far.
    seen: Vec<Headers>,
    places: Vec<usize>,
    /// Which topic a channel of the file is.
    index: Vec<Option<usize>>,
    row: Row,
    /// Number of the next step.
    next: Option<u64>,
    block: Block,
    sender: SyncSender<Result<Block, LogError>>,
}

impl Reading {
    fn run(mut self) {
        let path = self.path.clone();
        let result = walk(&path, |_, record| self.take(record));
        let result = result.and_then(|ending| self.finish(ending));
        if let Err(error) = result {
            // A receiver that has gone needs no error.
            let _ = self.sender.send(Err(error));
        }
    }

    fn take(&mut self, record: Record<'_>) -> Result<(), LogError> {
        match record {
            Record::Channel { id, topic, encoding: "cdr", .. } => {
                let place = usize::from(id);
                if self.index.len() <= place {
                    self.index.resize(place + 1, None);
                }
                self.index[place] = self.topics.iter().position(|(wanted, _)| wanted == topic);
                Ok(())
            }
            Record::Message { channel, sequence, log_time, data, .. } => {
                match self.index.get(usize::from(channel)).copied().flatten() {
                    Some(topic) => self.message(topic, sequence, log_time, data),
                    None => Ok(()),
                }
            }
            Record::ChunkEnd => self.send(),
            _ => Ok(()),
        }
    }

    fn message(&mut self, topic: usize, sequence: u32, time_ns: u64, data: &[u8]) -> Result<(), LogError> {
        let (name, layout) = &self.topics[topic];
        let Some((header, words)) = sample(data, layout.bytes()) else {
            let what = format!("a message is not the {} bytes of its schema", layout.bytes());
            return Err(LogError::Topic { path: self.path.clone(), topic: name.clone(), what });
        };
        let expected = *self.next.get_or_insert(sequence.into());
        let (step, time) = *self.row.step.get_or_insert((expected as u32, time_ns));
        let missing =
            |topic: &str, found| LogError::Step { path: self.path.clone(), topic: topic.into(), expected, found };
        if sequence != step || self.row.headers[topic].is_some() {
            let lacking = self.row.headers.iter().position(Option::is_none).unwrap_or(topic);
            return Err(missing(&self.topics[lacking].0, format!("a sample numbered {sequence} of {name} comes next")));
        }
        if time_ns != time {
            return Err(missing(name, format!("its time is {time_ns} ns, that of other topics {time} ns")));
        }
        if let Err(what) = self.seen[topic].check(&header, expected, time_ns) {
            return Err(LogError::Topic { path: self.path.clone(), topic: name.clone(), what });
        }
        self.row.headers[topic] = Some(header);
        let places = self.row.words[self.places[topic]..self.places[topic + 1]].iter_mut();
        places.zip(words).for_each(|(place, word)| *place = f64::from_le_bytes(*word));
        if self.row.headers.iter().all(Option::is_some) {
            self.block.steps.push((expected, time));
            self.block.headers.extend(self.row.headers.iter_mut().filter_map(Option::take));
            self.block.words.extend_from_slice(&self.row.words);
            (self.row.step, self.next) = (None, Some(expected + 1));
        }
        Ok(())
    }

    /// Hands on the complete steps.
    fn send(&mut self) -> Result<(), LogError> {
        if self.block.steps.is_empty() {
            return Ok(());
        }
        let block = std::mem::take(&mut self.block);
        // Ends the walk once the receiver has gone; no code reads this error.
        self.sender.send(Ok(block)).map_err(|_| LogError::Foreign { path: self.path.clone() })
    }

    /// A cut may fall into a step; a finished file may not end in one.
    fn finish(&mut self, ending: Ending) -> Result<(), LogError> {
        self.send()?;
        let (Some((step, _)), Ending::Complete) = (self.row.step, ending) else { return Ok(()) };
        let lacking = self.row.headers.iter().position(Option::is_none).unwrap_or(0);
        let (topic, found) = (self.topics[lacking].0.clone(), "it ends before other topics".into());
        Err(LogError::Step { path: self.path.clone(), topic, expected: step.into(), found })
    }
}
