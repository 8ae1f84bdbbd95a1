//! Reading a log back.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lockstep::{HEADER_BYTES, Header, Layout};

use super::header::Headers;
use super::numbers::Numbers;
use super::place::is_being_written;
use super::record::Record;
use super::schema::layout_of;
use super::summary::claimed_messages;
use super::walk::{Ending, walk};
use super::{DATA, ENCAPSULATION, LogError, METADATA, PLAYER, SCENARIO, Series};

/// Numbers kept of the header of a sample: its step and its status.
pub(super) const HEADER_WORDS: usize = 2;

/// A channel of a [`Log`].
#[derive(Clone, Debug, PartialEq)]
pub struct LogChannel {
    /// Its name, `/agent_3/state`.
    pub topic: String,
    /// Name of its type, `phalanx_msgs/msg/State`. Empty if it has none.
    pub schema: String,
    /// Number of its messages in the file.
    pub messages: u64,
    /// Number of the agent it belongs to, 0 if none; known from the first sample.
    pub agent: u32,
    /// What its samples consist of; `None` for a channel of another kind, whose messages are not decoded.
    pub layout: Option<Layout>,
    /// Which numbers of a sample (its step, its status, its words) are in memory, ascending; `None`: all.
    pub(super) kept: Option<Vec<usize>>,
    /// The numbers of each sample that are in memory, one after the other.
    pub(super) data: Numbers,
}

impl LogChannel {
    /// Numbers of a sample that are in memory.
    pub(super) fn stride(&self) -> usize {
        let all = || HEADER_WORDS + self.layout.as_ref().map_or(0, Layout::words);
        self.kept.as_ref().map_or_else(all, Vec::len)
    }

    /// Where a number of a sample is among those in memory; `None` if it is not.
    fn place(&self, number: usize) -> Option<usize> {
        self.kept.as_ref().map_or(Some(number), |kept| kept.binary_search(&number).ok())
    }

    /// Place and length of a field, in numbers of a sample.
    fn numbers_of(&self, field: &str) -> Option<(usize, usize)> {
        match field {
            "step" => Some((0, 1)),
            "status" => Some((1, 1)),
            _ => self.layout.as_ref()?.find(field).map(|(offset, width)| (HEADER_WORDS + offset, width)),
        }
    }

    /// Has only these fields kept.
    fn keep(&mut self, keep: &dyn Fn(&str, &str) -> bool) {
        let Some(layout) = &self.layout else { return };
        let names = layout.fields().iter().map(|field| field.name.as_str());
        let wanted: Vec<&str> =
            ["step", "status"].into_iter().chain(names).filter(|name| keep(&self.topic, name)).collect();
        if wanted.len() < 2 + layout.fields().len() {
            let numbers = wanted.into_iter().filter_map(|name| self.numbers_of(name));
            self.kept = Some(numbers.flat_map(|(offset, width)| offset..offset + width).collect());
        }
    }

    /// Sample after sample.
    pub(super) fn numbers(&self) -> &[f64] {
        &self.data
    }

    /// What to call a number of a sample.
    pub(super) fn label(&self, number: usize) -> String {
        match (number, &self.layout) {
            (0, _) => "step".into(),
            (1, _) => "status".into(),
            (word, Some(layout)) => layout.label(word - HEADER_WORDS),
            (word, None) => format!("word {word}"),
        }
    }
}

/// Why a log has no end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfinished {
    /// A process is writing it.
    Growing,
    /// Its run was killed, or could not write the end.
    Cut,
}

impl fmt::Display for Unfinished {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Growing => "not closed yet, since its run goes on",
            Self::Cut => "cut, since its run was killed or could not write on",
        })
    }
}

/// A recorded run, in memory.
#[derive(Clone, Debug)]
pub struct Log {
    pub(super) path: PathBuf,
    pub(super) complete: bool,
    pub(super) scenario: Option<String>,
    pub(super) data: BTreeMap<String, Arc<[u8]>>,
    pub(super) metadata: Option<BTreeMap<String, String>>,
    pub(super) players: Vec<BTreeMap<String, String>>,
    pub(super) channels: Vec<LogChannel>,
    /// The first recorded step.
    pub(super) first: Option<u32>,
    pub(super) times: Vec<u64>,
}

impl Log {
    /// Reads the log `path`. Of a run that was killed, it reads all steps that had reached the file.
    ///
    /// # Errors
    /// [`LogError::Read`], [`LogError::NotMcap`], [`LogError::Foreign`]; [`LogError::Damaged`], [`LogError::Topic`] and
    /// [`LogError::Step`] if the content is wrong or a sample is missing.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        Self::open_for(path, &|_, _| true)
    }

    /// The same, but of the samples only those fields are kept in memory for which `keep` says so, given topic and field; the
    /// whole file is checked all the same.
    ///
    /// # Errors
    /// As those of [`open`](Self::open).
    pub fn open_for(path: &Path, keep: &dyn Fn(&str, &str) -> bool) -> Result<Self, LogError> {
        let mut reader = Reader::new(path, keep, None);
        let ending = walk(path, |at, record| reader.take(at, record))?;
        reader.finish(ending)
    }

    /// Everything but the samples; the whole file is checked all the same.
    ///
    /// # Errors
    /// As those of [`open`](Self::open).
    pub fn outline(path: &Path) -> Result<Self, LogError> {
        Self::open_for(path, &|_, _| false)
    }

    /// The first step of the log, of which the rest is not read; no step if there is none.
    ///
    /// # Errors
    /// As those of [`open`](Self::open), as far as the file is read.
    pub fn first_step(path: &Path) -> Result<Self, LogError> {
        let mut reader = Reader::new(path, &|_, _| true, Some(1));
        match walk(path, |at, record| reader.take(at, record)) {
            Ok(ending) => reader.finish(ending),
            Err(_) if reader.is_full => reader.finish(Ending::Cut { at: 0 }),
            Err(error) => Err(error),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Why the file has no end; `None` if it has one.
    pub fn unfinished(&self) -> Option<Unfinished> {
        let is_growing = || is_being_written(&self.path);
        (!self.complete).then(|| if is_growing() { Unfinished::Growing } else { Unfinished::Cut })
    }

    /// Whether the recorder finished the file. If not, its run goes on, or a viewer needs [`recover`](super::recover).
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// The scenario that was run, TOML.
    pub fn scenario_text(&self) -> Option<&str> {
        self.scenario.as_deref()
    }

    /// The data files of the scenario, by the path that its formulas name.
    pub fn data(&self) -> &BTreeMap<String, Arc<[u8]>> {
        &self.data
    }

    /// What the recorder was told about the run.
    pub fn metadata(&self) -> Option<&BTreeMap<String, String>> {
        self.metadata.as_ref()
    }

    /// What the log says of every participant that was not played by Phalanx itself, in the order in which they began.
    pub fn players(&self) -> &[BTreeMap<String, String>] {
        &self.players
    }

    /// All channels in the order of the file.
    pub fn channels(&self) -> &[LogChannel] {
        &self.channels
    }

    /// The recorded steps; row i of a [`Series`] belongs to the i-th of them.
    pub fn steps(&self) -> Range<u64> {
        let first = self.first.unwrap_or(0).into();
        first..first + self.times.len() as u64
    }

    /// Simulated time of each recorded step, ns.
    pub fn times(&self) -> &[u64] {
        &self.times
    }

    /// All words of the samples of `topic`, one row per step; `None` if there is no such topic, or its messages are no samples.
    pub fn samples(&self, topic: &str) -> Option<Series<'_>> {
        let channel = self.channels.iter().find(|channel| channel.topic == topic)?;
        let words = channel.layout.as_ref()?.words();
        // Of a log of which only some fields were read, there are no whole samples.
        channel.kept.is_none().then(|| Series::of(&channel.data, channel.stride(), HEADER_WORDS, words))
    }

    /// The values of `field` on `topic` at all steps; `None` if there is no such signal.
    ///
    /// Besides the fields of the layout, every topic has `step`, the step that computed the sample, and `status`, the number
    /// of its [`lockstep::Status`].
    pub fn signal(&self, topic: &str, field: &str) -> Option<Series<'_>> {
        let channel = self.channels.iter().find(|channel| channel.topic == topic && channel.layout.is_some())?;
        let (number, width) = channel.numbers_of(field)?;
        Some(Series::of(&channel.data, channel.stride(), channel.place(number)?, width))
    }

    /// Whether `topic` has `field`, in memory or not.
    pub fn has(&self, topic: &str, field: &str) -> bool {
        self.channels.iter().any(|channel| channel.topic == topic && channel.numbers_of(field).is_some())
    }
}

/// A log while it is being read.
struct Reader<'k> {
    log: Log,
    keep: &'k dyn Fn(&str, &str) -> bool,
    /// How many steps are read; `None`: all.
    limit: Option<usize>,
    /// Whether that many have been read.
    is_full: bool,
    /// What the headers of each channel said so far, and how many there were.
    seen: Vec<(Headers, usize)>,
    /// Whether a message has been read.
    has_samples: bool,
    /// Name and, if it is one of ours, layout by number.
    schemas: BTreeMap<u16, (String, Option<Layout>)>,
    /// Index of a channel by its number in the file; a table, as every message asks.
    index: Vec<Option<usize>>,
}

impl<'k> Reader<'k> {
    fn new(path: &Path, keep: &'k dyn Fn(&str, &str) -> bool, limit: Option<usize>) -> Self {
        let log = Log {
            path: path.into(),
            complete: false,
            scenario: None,
            data: BTreeMap::new(),
            metadata: None,
            players: Vec::new(),
            channels: Vec::new(),
            first: None,
            times: Vec::new(),
        };
        let (schemas, index, seen) = (BTreeMap::new(), Vec::new(), Vec::new());
        Self { log, keep, limit, is_full: false, seen, has_samples: false, schemas, index }
    }

    fn take(&mut self, at: u64, record: Record<'_>) -> Result<(), LogError> {
        match record {
            Record::Message { channel, sequence, log_time, data, .. } => {
                let known = self.index.get(usize::from(channel)).copied().flatten();
                let damaged = || LogError::damaged(&self.log.path, at, "a message belongs to no channel");
                let known = known.ok_or_else(damaged)?;
                if !self.has_samples {
                    self.has_samples = true;
                    self.make_room();
                }
                self.message(known, sequence, log_time, data)?;
            }
            Record::Schema { id, name, encoding, text } => {
                let layout = if encoding == "ros2msg" { layout_of(text) } else { None };
                self.schemas.insert(id, (name.into(), layout));
            }
            Record::Channel { id, schema, topic, encoding, .. } => self.channel(id, schema, topic, encoding)?,
            Record::Attachment { name: SCENARIO, data, .. } => {
                let text = std::str::from_utf8(data);
                let text = text.map_err(|_| LogError::damaged(&self.log.path, at, "the scenario is no text"))?;
                self.log.scenario = Some(text.into());
            }
            Record::Attachment { name, data, .. } => {
                self.log.data.extend(name.strip_prefix(DATA).map(|path| (path.to_string(), data.into())));
            }
            Record::Metadata { name: METADATA, metadata } => self.log.metadata = Some(metadata),
            Record::Metadata { name: PLAYER, metadata } => self.log.players.push(metadata),
            Record::Header { .. } | Record::Metadata { .. } | Record::ChunkEnd => {}
        }
        Ok(())
    }

    fn channel(&mut self, id: u16, schema: u16, topic: &str, encoding: &str) -> Result<(), LogError> {
        let place = usize::from(id);
        if self.index.len() <= place {
            self.index.resize(place + 1, None);
        }
        if self.index[place].is_some() {
            // MCAP allows to say the same again.
            return Ok(());
        }
        let (schema, layout) = self.schemas.get(&schema).cloned().unwrap_or_default();
        let layout = layout.filter(|_| encoding == "cdr");
        let same = |other: &LogChannel| other.topic == topic && other.layout.is_some();
        if layout.is_some() && self.log.channels.iter().any(same) {
            return Err(self.log.wrong(topic, "two channels have this name"));
        }
        self.index[place] = Some(self.log.channels.len());
        let topic = topic.into();
        let (kept, data) = (None, Numbers::default());
        let mut channel = LogChannel { topic, schema, messages: 0, agent: 0, layout, kept, data };
        channel.keep(self.keep);
        self.seen.push((Headers::of(&channel.topic), 0));
        self.log.channels.push(channel);
        Ok(())
    }

    /// Takes room for all numbers of a long log in a file, before its first message.
    fn make_room(&mut self) {
        if self.limit.is_some() {
            return;
        }
        let Some(claimed) = claimed_messages(&self.log.path) else { return };
        let mut capacities = vec![0_u64; self.log.channels.len()];
        for (id, index) in self.index.iter().enumerate() {
            let (Some(index), Some(&messages)) = (*index, u16::try_from(id).ok().and_then(|id| claimed.get(&id)))
            else {
                continue;
            };
            let channel = &self.log.channels[index];
            let numbers = channel.layout.as_ref().map_or(0, |_| channel.stride() as u64);
            capacities[index] = messages.saturating_mul(numbers);
        }
        if let Some(lists) = Numbers::for_log(&self.log.path, &capacities) {
            self.log.channels.iter_mut().zip(lists).for_each(|(channel, list)| channel.data = list);
        }
    }

    fn finish(self, ending: Ending) -> Result<Log, LogError> {
        let mut log = self.log;
        log.complete = ending == Ending::Complete;
        if log.metadata.is_none() && log.channels.iter().all(|channel| channel.layout.is_none()) {
            return Err(LogError::Foreign { path: log.path });
        }
        let decoded = || log.channels.iter().zip(&self.seen).filter(|(channel, _)| channel.layout.is_some());
        let shortest = decoded().map(|(_, (_, rows))| *rows).min().unwrap_or(0);
        if let Some((channel, (_, rows))) = decoded().find(|(_, (_, rows))| log.complete && *rows < log.times.len()) {
            let expected = log.steps().start + *rows as u64;
            return Err(log.missing(&channel.topic, expected, "it ends before other topics".into()));
        }
        // Chunks end with steps, so a cut costs whole steps; a cut file of another writer may still end within one.
        log.times.truncate(shortest);
        for channel in &mut log.channels {
            channel.data.truncate(shortest * channel.stride());
        }
        Ok(log)
    }
}

impl Reader<'_> {
    /// Takes a message of the channel with this index.
    fn message(&mut self, index: usize, sequence: u32, time_ns: u64, data: &[u8]) -> Result<(), LogError> {
        let log = &mut self.log;
        let channel = &mut log.channels[index];
        channel.messages += 1;
        let Some(layout) = &channel.layout else { return Ok(()) };
        let bytes = layout.bytes();
        let Some((header, words)) = sample(data, bytes) else {
            return Err(log.wrong_by_index(index, format!("a message is not the {bytes} bytes of its schema")));
        };
        let (headers, rows) = &mut self.seen[index];
        let row = *rows;
        let first = *log.first.get_or_insert(sequence);
        let expected = u64::from(first) + row as u64;
        if sequence != expected as u32 {
            let topic = channel.topic.clone();
            return Err(log.missing(&topic, expected, format!("a sample numbered {sequence} stands there")));
        }
        if self.limit == Some(row) {
            // Ends the walk; what the error says does not matter.
            self.is_full = true;
            return Err(LogError::Foreign { path: log.path.clone() });
        }
        match log.times.get(row) {
            None => log.times.push(time_ns),
            Some(time) if *time == time_ns => {}
            Some(time) => {
                let found = format!("its time is {time_ns} ns, that of other topics {time} ns");
                let topic = channel.topic.clone();
                return Err(log.missing(&topic, expected, found));
            }
        }
        if let Err(what) = headers.check(&header, expected, time_ns) {
            return Err(log.wrong_by_index(index, what));
        }
        if row == 0 {
            channel.agent = header.agent;
        }
        *rows += 1;
        let number = |number: usize| match number {
            0 => header.step as f64,
            1 => f64::from(header.status),
            word => f64::from_le_bytes(words[word - HEADER_WORDS]),
        };
        match &channel.kept {
            Some(kept) => channel.data.extend(kept.iter().map(|kept| number(*kept))),
            None => {
                let words = words.iter().map(|word| f64::from_le_bytes(*word));
                channel.data.extend([number(0), number(1)].into_iter().chain(words));
            }
        }
        Ok(())
    }
}

impl Log {
    fn missing(&self, topic: &str, expected: u64, found: String) -> LogError {
        LogError::Step { path: self.path.clone(), topic: topic.into(), expected, found }
    }

    fn wrong(&self, topic: &str, what: impl Into<String>) -> LogError {
        LogError::Topic { path: self.path.clone(), topic: topic.into(), what: what.into() }
    }

    fn wrong_by_index(&self, index: usize, what: String) -> LogError {
        self.wrong(&self.channels[index].topic, what)
    }
}

/// Header and words of a sample of `bytes` bytes; `None` if it is not a sample.
pub(super) fn sample(data: &[u8], bytes: usize) -> Option<(Header, &[[u8; 8]])> {
    let body = data.strip_prefix(&ENCAPSULATION)?;
    let (words, _) = body.get(HEADER_BYTES..)?.as_chunks();
    (body.len() == bytes).then_some((Header::from_bytes(body)?, words))
}
