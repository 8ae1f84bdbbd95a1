//! The records of an MCAP file one after the other, whatever state the file is in.
//!
//! A reader of its own, because a log may be cut or hostile: every length is checked against what is there before memory is
//! taken for it, and nothing is copied out of a chunk.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use zstd::bulk::Decompressor;

use super::LogError;

/// Longest record, and longest content of a chunk, that is read: far above what a recorder writes. Bytes.
const RECORD_MAX: u64 = 256 << 20;
/// Content that all chunks may have together, per byte of the file read so far ...
const EXPANSION_MAX: u64 = 512;
/// ... and in addition to that, bytes. Both keep a small file from filling the memory.
const EXPANSION_FREE: u64 = 1 << 30;
/// Opcode and length before every record.
const PREFIX_BYTES: usize = 9;

/// A record, borrowed from the buffer it was read into.
pub(super) enum Record<'a> {
    Header {
        profile: &'a str,
        library: &'a str,
    },
    Schema {
        id: u16,
        name: &'a str,
        encoding: &'a str,
        text: &'a [u8],
    },
    Channel {
        id: u16,
        schema: u16,
        topic: &'a str,
        encoding: &'a str,
        metadata: BTreeMap<String, String>,
    },
    Message {
        channel: u16,
        sequence: u32,
        log_time: u64,
        publish_time: u64,
        data: &'a [u8],
    },
    Attachment {
        name: &'a str,
        media_type: &'a str,
        data: &'a [u8],
    },
    Metadata {
        name: &'a str,
        metadata: BTreeMap<String, String>,
    },
    /// All records of a chunk were given.
    ChunkEnd,
}

/// How the walk through a file ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// With the footer: the file was finished.
    Complete,
    /// In the middle: whoever wrote it was killed.
    Cut,
}

/// Gives every record of the data section, chunks unpacked and checked, to `visit` with the place of its outermost record.
///
/// # Errors
/// [`LogError::Read`], [`LogError::NotMcap`], [`LogError::Damaged`], and what `visit` returns.
pub(super) fn walk(
    path: &Path,
    mut visit: impl FnMut(u64, Record<'_>) -> Result<(), LogError>,
) -> Result<Ending, LogError> {
    let file = File::open(path).map_err(|error| LogError::read(path, error))?;
    let mut source = Source { path, file: BufReader::with_capacity(1 << 16, file), position: 0 };
    let mut record = Vec::new();
    let mut content = Vec::new();
    let mut decompressor = Decompressor::new().map_err(|error| LogError::read(path, error))?;
    let mut expanded = 0;
    let mut checksum = crc32fast::Hasher::new();
    if !source.take(mcap::MAGIC.len() as u64, &mut record)? || record != mcap::MAGIC {
        let what = if record.is_empty() { "it is empty" } else { "it does not start with the magic bytes of MCAP" };
        return Err(LogError::NotMcap { path: path.into(), what });
    }
    checksum.update(&record);
    let mut in_data = true;
    loop {
        let at = source.position;
        let damaged = |what: &str| LogError::damaged(path, at, what);
        if !source.take(PREFIX_BYTES as u64, &mut record)? {
            return Ok(Ending::Cut);
        }
        let (opcode, length) = prefix(&record).ok_or_else(|| damaged("a record has no length"))?;
        if in_data && opcode != mcap::records::op::DATA_END {
            checksum.update(&record);
        }
        if length > RECORD_MAX {
            return Err(damaged(&format!("a record claims {length} bytes, {RECORD_MAX} are allowed")));
        }
        if !source.take(length, &mut record)? {
            return Ok(Ending::Cut);
        }
        match opcode {
            mcap::records::op::FOOTER => {
                let finished = source.take(mcap::MAGIC.len() as u64, &mut record)? && record == mcap::MAGIC;
                return Ok(if finished { Ending::Complete } else { Ending::Cut });
            }
            mcap::records::op::DATA_END => {
                let expected = Fields(&record).u32().ok_or_else(|| damaged("the end of the data is malformed"))?;
                if expected != 0 && expected != checksum.clone().finalize() {
                    return Err(damaged("the checksum of the file is wrong"));
                }
                in_data = false;
            }
            // Behind the data comes a copy of schemas and channels for readers in a hurry.
            _ if !in_data => {}
            mcap::records::op::CHUNK => {
                checksum.update(&record);
                let chunk = Chunk::parse(&record).ok_or_else(|| damaged("a chunk is malformed"))?;
                expanded += chunk.size;
                if chunk.size > RECORD_MAX || expanded > EXPANSION_FREE + EXPANSION_MAX * source.position {
                    return Err(damaged(&format!(
                        "a chunk claims a content of {} bytes, more than allowed",
                        chunk.size
                    )));
                }
                let records = chunk.open(&mut decompressor, &mut content).map_err(|what| damaged(&what))?;
                each(records, |opcode, body| match parse(opcode, body).map_err(|what| damaged(&what))? {
                    Some(record) => visit(at, record),
                    None => Ok(()),
                })
                .unwrap_or_else(|| Err(damaged("a record is longer than its chunk")))?;
                visit(at, Record::ChunkEnd)?;
            }
            _ => {
                checksum.update(&record);
                if let Some(record) = parse(opcode, &record).map_err(|what| damaged(&what))? {
                    visit(at, record)?;
                }
            }
        }
    }
}

/// The file, read from front to end.
struct Source<'a> {
    path: &'a Path,
    file: BufReader<File>,
    position: u64,
}

impl Source<'_> {
    /// Reads `length` bytes; false if there are fewer. Takes memory for what is there only, whatever `length` says.
    fn take(&mut self, length: u64, into: &mut Vec<u8>) -> Result<bool, LogError> {
        into.clear();
        let read = self.file.by_ref().take(length).read_to_end(into);
        let read = read.map_err(|error| LogError::read(self.path, error))? as u64;
        self.position += read;
        Ok(read == length)
    }
}

/// Opcode and length of the record that starts here.
fn prefix(bytes: &[u8]) -> Option<(u8, u64)> {
    let (opcode, rest) = bytes.split_first()?;
    Some((*opcode, u64::from_le_bytes(*rest.first_chunk()?)))
}

/// Calls `visit` with opcode and body of each record; `None` if the last one is cut.
fn each(mut bytes: &[u8], mut visit: impl FnMut(u8, &[u8]) -> Result<(), LogError>) -> Option<Result<(), LogError>> {
    while !bytes.is_empty() {
        let (opcode, length) = prefix(bytes)?;
        let rest = &bytes[PREFIX_BYTES..];
        let (body, rest) = rest.split_at_checked(usize::try_from(length).ok()?)?;
        if let Err(error) = visit(opcode, body) {
            return Some(Err(error));
        }
        bytes = rest;
    }
    Some(Ok(()))
}

/// A chunk before it is unpacked.
struct Chunk<'a> {
    size: u64,
    checksum: u32,
    compression: &'a str,
    stored: &'a [u8],
}

impl<'a> Chunk<'a> {
    fn parse(body: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(body);
        fields.u64()?;
        fields.u64()?;
        let (size, checksum, compression) = (fields.u64()?, fields.u32()?, fields.text()?);
        let length = fields.u64()?;
        Some(Self { size, checksum, compression, stored: fields.bytes(length)? })
    }

    /// The records in it, checked.
    fn open(&self, decompressor: &mut Decompressor<'_>, content: &'a mut Vec<u8>) -> Result<&'a [u8], String> {
        let records = match self.compression {
            "" => self.stored,
            "zstd" => {
                content.clear();
                content.reserve_exact(self.size as usize);
                decompressor
                    .decompress_to_buffer(self.stored, content)
                    .map_err(|error| format!("a chunk cannot be decompressed: {error}"))?;
                content
            }
            other => return Err(format!("a chunk is compressed with {other:?}, only zstd is supported")),
        };
        if records.len() as u64 != self.size {
            return Err(format!("a chunk holds {} bytes, not {}", records.len(), self.size));
        }
        if self.checksum != 0 && self.checksum != crc32fast::hash(records) {
            return Err("the checksum of a chunk is wrong".into());
        }
        Ok(records)
    }
}

/// The record, or `None` for a kind that a log can be read without.
fn parse(opcode: u8, body: &[u8]) -> Result<Option<Record<'_>>, String> {
    let mut fields = Fields(body);
    let (record, kind) = match opcode {
        mcap::records::op::MESSAGE => (fields.message(), "message"),
        mcap::records::op::HEADER => (fields.header(), "header"),
        mcap::records::op::SCHEMA => (fields.schema(), "schema"),
        mcap::records::op::CHANNEL => (fields.channel(), "channel"),
        mcap::records::op::ATTACHMENT => (fields.attachment(body), "attachment"),
        mcap::records::op::METADATA => (fields.metadata(), "metadata"),
        _ => return Ok(None),
    };
    record.map(Some).ok_or_else(|| format!("a {kind} record is malformed"))
}

/// What is left of the body of a record.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, length: u64) -> Option<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(bytes)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.bytes(length.into())?).ok()
    }

    fn map(&mut self) -> Option<BTreeMap<String, String>> {
        let length = self.u32()?;
        let mut entries = Fields(self.bytes(length.into())?);
        let mut map = BTreeMap::new();
        while !entries.0.is_empty() {
            map.insert(entries.text()?.into(), entries.text()?.into());
        }
        Some(map)
    }

    fn header(&mut self) -> Option<Record<'a>> {
        Some(Record::Header { profile: self.text()?, library: self.text()? })
    }

    fn schema(&mut self) -> Option<Record<'a>> {
        let (id, name, encoding, length) = (self.u16()?, self.text()?, self.text()?, self.u32()?);
        Some(Record::Schema { id, name, encoding, text: self.bytes(length.into())? })
    }

    fn channel(&mut self) -> Option<Record<'a>> {
        let (id, schema, topic, encoding) = (self.u16()?, self.u16()?, self.text()?, self.text()?);
        Some(Record::Channel { id, schema, topic, encoding, metadata: self.map()? })
    }

    fn message(&mut self) -> Option<Record<'a>> {
        let (channel, sequence, log_time, publish_time) = (self.u16()?, self.u32()?, self.u64()?, self.u64()?);
        Some(Record::Message { channel, sequence, log_time, publish_time, data: self.0 })
    }

    fn attachment(&mut self, body: &[u8]) -> Option<Record<'a>> {
        self.bytes(16)?;
        let (name, media_type, length) = (self.text()?, self.text()?, self.u64()?);
        let data = self.bytes(length)?;
        let checked = &body[..body.len() - self.0.len()];
        let checksum = self.u32()?;
        let good = checksum == 0 || checksum == crc32fast::hash(checked);
        good.then_some(Record::Attachment { name, media_type, data })
    }

    fn metadata(&mut self) -> Option<Record<'a>> {
        Some(Record::Metadata { name: self.text()?, metadata: self.map()? })
    }
}
