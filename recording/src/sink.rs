//! The step thread's side of a log file: collects chunks and hands them to the threads that write.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use lockstep::Header;

use super::chunk::Chunk;
use super::encode::Encode;
use super::output::{Attachment, Closed, Definitions, Output};
use super::pipeline::{Job, Pipeline};
use super::record::op;
use super::target::Target;

/// A finished log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Summary {
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// Messages of all channels.
    pub messages: u64,
    /// SHA-256 of the file, 64 lower-case hexadecimal digits. Equal runs have equal digests.
    pub sha256: String,
}

/// A type definition as the file stores it.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct SchemaRecord {
    pub(super) id: u16,
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) text: Vec<u8>,
}

/// A channel as the file stores it.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct ChannelRecord {
    pub(super) id: u16,
    pub(super) schema: u16,
    pub(super) topic: String,
    pub(super) encoding: String,
    pub(super) metadata: BTreeMap<String, String>,
}

/// Why something is not in the file.
#[derive(Clone, Debug)]
pub(super) enum Refusal {
    /// It contradicts what is there.
    Contradiction(String),
    /// The file could not be written.
    Write(Arc<io::Error>),
}

impl From<Arc<io::Error>> for Refusal {
    fn from(error: Arc<io::Error>) -> Self {
        Self::Write(error)
    }
}

/// Writes the records of one file.
pub(super) struct Sink<W> {
    pipeline: Pipeline<W>,
    chunk: Chunk,
    /// Number of chunks that are closed.
    written: u64,
    /// The number of the open chunk, if it had messages at the last call of [`Sink::show_late`] that were not shown.
    late: Option<u64>,
    schemas: BTreeMap<u16, SchemaRecord>,
    channels: BTreeMap<u16, ChannelRecord>,
}

impl<W: Target + 'static> Sink<W> {
    /// Starts a file on `output`.
    pub(super) fn new(output: W, profile: &str, library: &str) -> io::Result<Self> {
        let pipeline = Pipeline::start(Output::start(output, profile, library)?)?;
        let (schemas, channels) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { pipeline, chunk: Chunk::default(), written: 0, late: None, schemas, channels })
    }

    /// Attaches a file.
    pub(super) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), Refusal> {
        self.flush()?;
        let attachment = Attachment { name: name.into(), media_type: media_type.into(), data: data.into() };
        Ok(self.pipeline.send(Job::Attachment(attachment))?)
    }

    /// Writes a metadata record.
    pub(super) fn metadata(&mut self, name: &str, metadata: &BTreeMap<String, String>) -> Result<(), Refusal> {
        self.flush()?;
        Ok(self.pipeline.send(Job::Metadata(name.into(), metadata.clone()))?)
    }

    /// Writes a definition, once.
    pub(super) fn schema(&mut self, schema: SchemaRecord) -> Result<(), Refusal> {
        match self.schemas.get(&schema.id) {
            Some(known) if *known == schema => return Ok(()),
            Some(_) => return Err(Refusal::Contradiction(format!("schema {} is defined twice", schema.id))),
            None if schema.id == 0 => return Err(Refusal::Contradiction("a schema has the number 0".into())),
            None => {}
        }
        self.chunk.define(op::SCHEMA, |body| schema.encode(body));
        self.schemas.insert(schema.id, schema);
        Ok(())
    }

    /// Writes a channel, whose schema must be there, once.
    pub(super) fn channel(&mut self, channel: ChannelRecord) -> Result<(), Refusal> {
        let contradiction = |what| Err(Refusal::Contradiction(format!("channel {} {what}", channel.id)));
        match self.channels.get(&channel.id) {
            Some(known) if *known == channel => return Ok(()),
            Some(_) => return contradiction("is defined twice"),
            None if channel.schema != 0 && !self.schemas.contains_key(&channel.schema) => {
                return contradiction("has a schema that is not defined");
            }
            None => {}
        }
        self.chunk.define(op::CHANNEL, |body| channel.encode(body));
        self.channels.insert(channel.id, channel);
        Ok(())
    }

    /// Writes a message with the times of its logging and publication, ns.
    pub(super) fn message(&mut self, channel: u16, sequence: u32, times: [u64; 2], data: &[u8]) -> Result<(), Refusal> {
        if !self.channels.contains_key(&channel) {
            return Err(Refusal::Contradiction(format!("a message is of channel {channel}, which is not defined")));
        }
        self.chunk.message(channel, sequence, times, data);
        Ok(())
    }

    /// Writes a sample of a channel that is defined, at a time in ns.
    pub(super) fn sample(&mut self, channel: u16, sequence: u32, time: u64, header: &Header, words: &[f64]) {
        self.chunk.sample(channel, sequence, time, header, words);
    }

    /// Data of the messages since the last flush, bytes.
    pub(super) fn pending(&self) -> usize {
        self.chunk.payload()
    }

    /// Closes the chunk; it will be in the hands of the operating system soon.
    pub(super) fn flush(&mut self) -> Result<(), Refusal> {
        if self.chunk.is_empty() {
            return Ok(());
        }
        let chunk = std::mem::replace(&mut self.chunk, self.pipeline.chunk());
        self.written += 1;
        Ok(self.pipeline.send(Job::Chunk(chunk))?)
    }

    /// Shows what is in the open chunk to readers of the file, until the chunk is written.
    pub(super) fn show(&mut self) -> Result<(), Refusal> {
        if !self.chunk.is_behind() {
            return Ok(());
        }
        let mut bytes = self.pipeline.buffer();
        self.chunk.show(&mut bytes);
        Ok(self.pipeline.send(Job::Show(bytes, self.chunk.defined()))?)
    }

    /// Shows messages that have been waiting for it since the last call of this function, or longer.
    pub(super) fn show_late(&mut self) -> Result<(), Refusal> {
        let waiting = self.chunk.is_behind().then_some(self.written);
        if waiting.is_some() && waiting == self.late {
            self.show()?;
            self.late = None;
        } else {
            self.late = waiting;
        }
        Ok(())
    }

    /// Waits until all chunks that are closed are in the file.
    pub(super) fn drain(&self) -> Result<(), Arc<io::Error>> {
        self.pipeline.drain()
    }

    /// Waits until everything is in the hands of the operating system.
    pub(super) fn settle(&mut self) -> Result<(), Refusal> {
        self.flush()?;
        Ok(self.pipeline.drain()?)
    }

    /// What went wrong so far.
    pub(super) fn check(&self) -> Result<(), Arc<io::Error>> {
        self.pipeline.check()
    }

    /// Writes the rest and the summary section, and closes the file. After an error, the file is closed all the same if there is
    /// room for it. `None` if there is no file, since it holds no step and an earlier one stands in its place.
    pub(super) fn finish(mut self, path: PathBuf) -> (Option<Summary>, Result<(), Arc<io::Error>>) {
        let sent = match self.chunk.is_empty() {
            true => Ok(()),
            false => self.pipeline.send(Job::Chunk(std::mem::take(&mut self.chunk))),
        };
        let mut definitions = Definitions::default();
        definitions.schemas.0 = self.schemas.len() as u16;
        definitions.channels.0 = self.channels.len() as u32;
        for schema in self.schemas.values() {
            definitions.schemas.1.record(op::SCHEMA, |body| schema.encode(body));
        }
        for channel in self.channels.values() {
            definitions.channels.1.record(op::CHANNEL, |body| channel.encode(body));
        }
        let (output, result) = self.pipeline.finish();
        // What is shown after an error could not be written, and stays.
        let closed = match output.filter(|output| !output.shows()) {
            // Not even the definitions have found room.
            Some(output) if !output.has_definitions() => output.finish(&Definitions::default()).map_err(Arc::new),
            Some(output) => output.finish(&definitions).map_err(Arc::new),
            None => return (None, sent.and(result)),
        };
        match closed {
            Ok(Closed { is_published: false, .. }) => (None, sent.and(result)),
            Ok(Closed { bytes, messages, sha256, .. }) => {
                (Some(Summary { path, bytes, messages, sha256 }), sent.and(result))
            }
            Err(error) => (None, sent.and(result).and(Err(error))),
        }
    }
}

impl SchemaRecord {
    fn encode(&self, body: &mut Vec<u8>) {
        body.put_u16(self.id);
        body.put_text(&self.name);
        body.put_text(&self.encoding);
        body.put_list(|list| list.extend_from_slice(&self.text));
    }
}

impl ChannelRecord {
    fn encode(&self, body: &mut Vec<u8>) {
        body.put_u16(self.id);
        body.put_u16(self.schema);
        body.put_text(&self.topic);
        body.put_text(&self.encoding);
        body.put_texts(&self.metadata);
    }
}
