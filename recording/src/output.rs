//! The file of a log as it grows: bytes out, digest, size and what its summary will say on the way.

use std::collections::BTreeMap;
use std::io;

use sha2::{Digest, Sha256};

use super::chunk::{Chunk, Packed};
use super::encode::Encode;
use super::record::{MAGIC, op};
use super::target::Target;

/// Room for what the end of a file has besides definitions and entries, bytes.
const FIXED_BYTES: u64 = 1024;

/// Where a log goes.
pub(super) struct Output<W> {
    file: W,
    digest: Sha256,
    /// Checksum of all before the end of the data.
    checksum: crc32fast::Hasher,
    bytes: u64,
    /// Definitions that are written, bytes; they stand in the summary once more.
    defined: u64,
    /// Whether a step is in the file.
    has_step: bool,
    /// Entries of the summary that point to chunks, attachments and metadata; they grow with the file by about a thousandth.
    chunks: Vec<u8>,
    attachments: Vec<u8>,
    metadata: Vec<u8>,
    statistics: Statistics,
}

/// What a file says about itself.
#[derive(Debug, Default)]
struct Statistics {
    messages: BTreeMap<u16, u64>,
    times: Option<[u64; 2]>,
    chunks: u32,
    attachments: u32,
    metadata: u32,
}

/// A file that goes into the log as it is.
#[derive(Debug)]
pub(super) struct Attachment {
    pub(super) name: String,
    pub(super) media_type: String,
    pub(super) data: Vec<u8>,
}

/// All definitions of a file, encoded once more for its summary.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    pub(super) schemas: (u16, Vec<u8>),
    pub(super) channels: (u32, Vec<u8>),
}

/// What came of a file.
#[derive(Debug)]
pub(super) struct Closed {
    pub(super) bytes: u64,
    pub(super) messages: u64,
    pub(super) sha256: String,
    /// Whether the file has its place: one without a step does not replace an earlier one.
    pub(super) is_published: bool,
}

impl<W: Target> Output<W> {
    /// Starts a file.
    pub(super) fn start(file: W, profile: &str, library: &str) -> io::Result<Self> {
        let mut output = Self {
            file,
            digest: Sha256::new(),
            checksum: crc32fast::Hasher::new(),
            bytes: 0,
            defined: 0,
            has_step: false,
            chunks: Vec::new(),
            attachments: Vec::new(),
            metadata: Vec::new(),
            statistics: Statistics::default(),
        };
        let mut bytes = MAGIC.to_vec();
        bytes.record(op::HEADER, |body| {
            body.put_text(profile);
            body.put_text(library);
        });
        output.data(&bytes)?;
        Ok(output)
    }

    fn write(&mut self, bytes: &[u8], reserve: u64) -> io::Result<()> {
        self.file.write(bytes, reserve)?;
        self.digest.update(bytes);
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    fn data(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write(bytes, self.reserve(0))?;
        self.checksum.update(bytes);
        Ok(())
    }

    /// Room for the end of the file with so many bytes of definitions more: the definitions, the entries that are there and one
    /// more, and some hundred bytes of fixed size.
    fn reserve(&self, defined: usize) -> u64 {
        let entries = self.chunks.len() + self.attachments.len() + self.metadata.len();
        // What an entry or the statistics say of a channel is shorter than its definition.
        3 * (self.defined + defined as u64) + entries as u64 + FIXED_BYTES
    }

    /// Writes a chunk in the place of what was shown of it.
    pub(super) fn chunk(&mut self, chunk: &Chunk, packed: &Packed) -> io::Result<()> {
        let start = self.bytes;
        self.write(&packed.bytes, self.reserve(chunk.defined()))?;
        self.checksum.update(&packed.bytes);
        packed.point_to(start, &mut self.chunks);
        self.defined += chunk.defined() as u64;
        let statistics = &mut self.statistics;
        statistics.chunks += 1;
        for (channel, count) in chunk.counts() {
            *statistics.messages.entry(channel).or_default() += count;
        }
        if let Some([first, last]) = chunk.times() {
            let [earliest, latest] = statistics.times.unwrap_or([first, last]);
            statistics.times = Some([earliest.min(first), latest.max(last)]);
            self.first_step()?;
        }
        Ok(())
    }

    /// A step is in the file.
    fn first_step(&mut self) -> io::Result<()> {
        if !self.has_step {
            self.file.publish(true)?;
            self.has_step = true;
        }
        Ok(())
    }

    /// Writes an attachment. Its times are zero: the wall clock stays out of a log.
    pub(super) fn attach(&mut self, attachment: &Attachment) -> io::Result<()> {
        let Attachment { name, media_type, data } = attachment;
        let start = self.bytes;
        let mut bytes = Vec::new();
        bytes.record(op::ATTACHMENT, |body| {
            let fields = body.len();
            body.put_u64(0);
            body.put_u64(0);
            body.put_text(name);
            body.put_text(media_type);
            body.put_u64(data.len() as u64);
            body.extend_from_slice(data);
            let checksum = crc32fast::hash(&body[fields..]);
            body.put_u32(checksum);
        });
        self.data(&bytes)?;
        self.attachments.record(op::ATTACHMENT_INDEX, |body| {
            body.put_u64(start);
            body.put_u64(bytes.len() as u64);
            body.put_u64(0);
            body.put_u64(0);
            body.put_u64(data.len() as u64);
            body.put_text(name);
            body.put_text(media_type);
        });
        self.statistics.attachments += 1;
        Ok(())
    }

    /// Writes a metadata record.
    pub(super) fn metadata(&mut self, name: &str, metadata: &BTreeMap<String, String>) -> io::Result<()> {
        let start = self.bytes;
        let mut bytes = Vec::new();
        bytes.record(op::METADATA, |body| {
            body.put_text(name);
            body.put_texts(metadata);
        });
        self.data(&bytes)?;
        self.metadata.record(op::METADATA_INDEX, |body| {
            body.put_u64(start);
            body.put_u64(bytes.len() as u64);
            body.put_text(name);
        });
        self.statistics.metadata += 1;
        Ok(())
    }

    /// Shows a chunk with messages that is not written yet, and in which there are so many bytes of definitions.
    pub(super) fn show(&mut self, bytes: &[u8], defined: usize) -> io::Result<()> {
        self.file.show(bytes, self.reserve(defined))?;
        self.first_step()
    }

    /// Whether definitions are written.
    pub(super) fn has_definitions(&self) -> bool {
        self.defined > 0
    }

    /// Whether anything is shown that is not written.
    pub(super) fn shows(&self) -> bool {
        self.file.shows()
    }

    /// Writes the summary section and the end.
    pub(super) fn finish(mut self, definitions: &Definitions) -> io::Result<Closed> {
        let mut bytes = Vec::new();
        let checksum = self.checksum.clone().finalize();
        bytes.record(op::DATA_END, |body| body.put_u32(checksum));
        let data_end = bytes.len();
        let start = self.bytes + data_end as u64;
        let statistics = self.statistics.encode(definitions);
        let groups = [
            (op::SCHEMA, &definitions.schemas.1),
            (op::CHANNEL, &definitions.channels.1),
            (op::STATISTICS, &statistics),
            (op::CHUNK_INDEX, &self.chunks),
            (op::ATTACHMENT_INDEX, &self.attachments),
            (op::METADATA_INDEX, &self.metadata),
        ];
        let mut offsets = Vec::new();
        for (opcode, group) in groups.into_iter().filter(|(_, group)| !group.is_empty()) {
            offsets.record(op::SUMMARY_OFFSET, |body| {
                body.push(opcode);
                body.put_u64(self.bytes + bytes.len() as u64);
                body.put_u64(group.len() as u64);
            });
            bytes.extend_from_slice(group);
        }
        let offsets_start = self.bytes + bytes.len() as u64;
        bytes.extend_from_slice(&offsets);
        bytes.record(op::FOOTER, |_| {});
        let footer = bytes.len();
        bytes.put_u64(start);
        bytes.put_u64(offsets_start);
        // The checksum covers the footer up to itself, its length included.
        let length = (bytes.len() + 4 - footer) as u64;
        bytes[footer - 8..footer].copy_from_slice(&length.to_le_bytes());
        let checksum = crc32fast::hash(&bytes[data_end..]);
        bytes.put_u32(checksum);
        bytes.extend_from_slice(MAGIC);
        self.write(&bytes, 0)?;
        let sha256 = self.digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        let is_published = self.file.publish(self.has_step)?;
        let messages = self.statistics.messages.values().sum();
        Ok(Closed { bytes: self.bytes, messages, sha256, is_published })
    }
}

impl Statistics {
    fn encode(&self, definitions: &Definitions) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.record(op::STATISTICS, |body| {
            body.put_u64(self.messages.values().sum());
            body.put_u16(definitions.schemas.0);
            body.put_u32(definitions.channels.0);
            body.put_u32(self.attachments);
            body.put_u32(self.metadata);
            body.put_u32(self.chunks);
            self.times.unwrap_or_default().iter().for_each(|time| body.put_u64(*time));
            body.put_list(|list| {
                for (channel, count) in &self.messages {
                    list.put_u16(*channel);
                    list.put_u64(*count);
                }
            });
        });
        bytes
    }
}
