//! The file side of a log: MCAP records out, digest and size on the way, chunks that end where steps end.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{Attachment, Compression, WriteOptions, Writer};
use sha2::{Digest, Sha256};

use super::batch::Batch;
use super::error::io_error;

/// Payload after which a chunk is closed at the end of its step, bytes.
const CHUNK_BYTES: usize = 1 << 20;
/// Size of the buffer before the file, bytes.
const BUFFER_BYTES: usize = 1 << 16;

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

/// Counts and digests what passes.
struct Digested<W> {
    output: W,
    digest: Sha256,
    bytes: u64,
}

impl<W: Write> Write for Digested<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.output.write(bytes)?;
        self.digest.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

/// A type definition as the file stores it.
#[derive(Debug)]
pub(super) struct SchemaRecord {
    pub(super) id: u16,
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) text: Vec<u8>,
}

/// A channel as the file stores it.
#[derive(Debug)]
pub(super) struct ChannelRecord {
    pub(super) id: u16,
    pub(super) schema: u16,
    pub(super) topic: String,
    pub(super) encoding: String,
    pub(super) metadata: BTreeMap<String, String>,
}

/// Writes the records of one file.
pub(super) struct Sink<W: Write> {
    writer: Writer<NoSeek<BufWriter<Digested<W>>>>,
    /// A chunk ends after every step whose successor is a multiple of this.
    flush_every: u64,
    /// The step whose messages are being written.
    step: Option<u64>,
    chunk_bytes: usize,
    messages: u64,
}

impl<W: Write> Sink<W> {
    /// Starts a file on `output`.
    pub(super) fn new(output: W, profile: &str, library: &str, flush_every: u64) -> io::Result<Self> {
        let output = Digested { output, digest: Sha256::new(), bytes: 0 };
        let writer = WriteOptions::new()
            .profile(profile)
            .library(library)
            // Only whole chunks reach the file, so a killed run leaves one that is good up to its cut.
            .disable_seeking(true)
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            // The number of threads changes the bytes; the default would follow the machine.
            .compression_threads(0)
            // Chunks end with steps (see `end_step`), not in the middle of one.
            .chunk_size(None)
            .create(NoSeek::new(BufWriter::with_capacity(BUFFER_BYTES, output)))
            .map_err(io_error)?;
        Ok(Self { writer, flush_every: flush_every.max(1), step: None, chunk_bytes: 0, messages: 0 })
    }

    /// Attaches a file. Times are zero: the wall clock stays out of a log.
    pub(super) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> io::Result<()> {
        let attachment = Attachment {
            log_time: 0,
            create_time: 0,
            name: name.into(),
            media_type: media_type.into(),
            data: data.into(),
        };
        self.writer.attach(&attachment).map_err(io_error)
    }

    /// Writes a metadata record.
    pub(super) fn metadata(&mut self, name: &str, metadata: &BTreeMap<String, String>) -> io::Result<()> {
        let record = Metadata { name: name.into(), metadata: metadata.clone() };
        self.writer.write_metadata(&record).map_err(io_error)
    }

    /// Writes a definition.
    pub(super) fn schema(&mut self, schema: &SchemaRecord) -> io::Result<()> {
        let SchemaRecord { id, name, encoding, text } = schema;
        self.writer.add_schema_with_id(*id, name, encoding, text).map_err(io_error)?;
        Ok(())
    }

    /// Writes a channel, whose schema must be there.
    pub(super) fn channel(&mut self, channel: &ChannelRecord) -> io::Result<()> {
        let ChannelRecord { id, schema, topic, encoding, metadata } = channel;
        self.writer.add_channel_with_id(*id, *schema, topic, encoding, metadata).map_err(io_error)?;
        Ok(())
    }

    /// Writes the messages of a batch; `period_ns` is the time from one step to the next.
    pub(super) fn batch(&mut self, batch: &Batch, period_ns: u64) -> io::Result<()> {
        for (entry, bytes) in batch.messages() {
            if self.step != Some(entry.step) {
                self.end_step()?;
                self.step = Some(entry.step);
            }
            let time_ns = entry.step.saturating_mul(period_ns);
            self.message(entry.channel, entry.step as u32, [time_ns; 2], bytes)?;
        }
        if batch.ends_step {
            self.end_step()?;
        }
        Ok(())
    }

    /// Writes a message with the times of its logging and publication, ns.
    pub(super) fn message(&mut self, channel: u16, sequence: u32, times: [u64; 2], bytes: &[u8]) -> io::Result<()> {
        let [log_time, publish_time] = times;
        let header = MessageHeader { channel_id: channel, sequence, log_time, publish_time };
        self.writer.write_to_known_channel(&header, bytes).map_err(io_error)?;
        self.chunk_bytes += bytes.len();
        self.messages += 1;
        Ok(())
    }

    /// Closes the chunk if the open step is the last of its group, or the chunk is full.
    ///
    /// Both follow from the messages alone, never from a clock or from how they came in batches: equal runs, equal bytes.
    fn end_step(&mut self) -> io::Result<()> {
        let Some(step) = self.step.take() else { return Ok(()) };
        if step.wrapping_add(1).is_multiple_of(self.flush_every) || self.chunk_bytes >= CHUNK_BYTES {
            self.flush()?;
        }
        Ok(())
    }

    /// Closes the chunk and hands everything to the operating system.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.chunk_bytes = 0;
        self.writer.flush().map_err(io_error)
    }

    /// Writes the summary section and closes the file.
    pub(super) fn finish(mut self, path: PathBuf) -> io::Result<Summary> {
        self.writer.finish().map_err(io_error)?;
        let output = self.writer.into_inner().into_inner();
        let Digested { mut output, digest, bytes } = output.into_inner().map_err(|error| error.into_error())?;
        output.flush()?;
        let sha256 = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Summary { path, bytes, messages: self.messages, sha256 })
    }
}
