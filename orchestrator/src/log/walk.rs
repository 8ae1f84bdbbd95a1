//! A walk through an MCAP file, record by record, whatever state the file is in.
//!
//! A reader of its own, because a log may be cut or hostile: every length is checked against what is there before memory is
//! taken for it, and nothing is copied out of a chunk.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use zstd::bulk::Decompressor;

use super::LogError;
use super::record::{Fields, Record, parse};

/// Longest record, and longest content of a chunk, that is read: far above what a recorder writes. Bytes.
const RECORD_MAX: u64 = 256 << 20;
/// Content that all chunks may have together, per byte of the file read so far ...
const EXPANSION_MAX: u64 = 512;
/// ... and in addition to that, bytes. Both keep a small file from filling the memory.
const EXPANSION_FREE: u64 = 1 << 30;
/// Opcode and length before every record.
const PREFIX_BYTES: usize = 9;

/// How the walk through a file ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// With the footer: the file was finished.
    Complete,
    /// In the middle: whoever wrote it was killed. What stands before this place is whole.
    Cut {
        /// Offset, bytes.
        at: u64,
    },
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
    let decompressor = Decompressor::new().map_err(|error| LogError::read(path, error))?;
    let mut unpacker = Unpacker { decompressor, content: Vec::new(), total: 0 };
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
            return Ok(Ending::Cut { at });
        }
        let (opcode, length) = prefix(&record).ok_or_else(|| damaged("a record has no length"))?;
        if in_data && opcode != mcap::records::op::DATA_END {
            checksum.update(&record);
        }
        if length > RECORD_MAX {
            return Err(damaged(&format!("a record claims {length} bytes, {RECORD_MAX} are allowed")));
        }
        if !source.take(length, &mut record)? {
            return Ok(Ending::Cut { at });
        }
        match opcode {
            mcap::records::op::FOOTER => {
                let finished = source.take(mcap::MAGIC.len() as u64, &mut record)? && record == mcap::MAGIC;
                return Ok(if finished { Ending::Complete } else { Ending::Cut { at } });
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
                let records = unpacker.unpack(&record, source.position).map_err(|what| damaged(&what))?;
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

/// Takes the records out of chunks, with a limit to how many there may be.
struct Unpacker {
    decompressor: Decompressor<'static>,
    content: Vec<u8>,
    /// Content of all chunks so far, bytes.
    total: u64,
}

impl Unpacker {
    /// The checked records of a chunk, of a file of which `read` bytes were read so far; or what is wrong with it.
    fn unpack<'a>(&'a mut self, chunk: &'a [u8], read: u64) -> Result<&'a [u8], String> {
        let Chunk { size, checksum, compression, stored } = Chunk::parse(chunk).ok_or("a chunk is malformed")?;
        self.total = self.total.saturating_add(size);
        if size > RECORD_MAX || self.total > EXPANSION_FREE + EXPANSION_MAX * read {
            return Err(format!("a chunk claims a content of {size} bytes, more than allowed"));
        }
        let records = match compression {
            "" => stored,
            "zstd" => {
                self.content.clear();
                self.content.reserve_exact(size as usize);
                let written = self.decompressor.decompress_to_buffer(stored, &mut self.content);
                written.map_err(|error| format!("a chunk cannot be decompressed: {error}"))?;
                &self.content
            }
            other => return Err(format!("a chunk is compressed with {other:?}, only zstd is supported")),
        };
        if records.len() as u64 != size {
            return Err(format!("a chunk holds {} bytes, not {size}", records.len()));
        }
        if checksum != 0 && checksum != crc32fast::hash(records) {
            return Err("the checksum of a chunk is wrong".into());
        }
        Ok(records)
    }
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
        // The times of its first and last message.
        fields.bytes(16)?;
        let (size, checksum, compression, length) = (fields.u64()?, fields.u32()?, fields.text()?, fields.u64()?);
        Some(Self { size, checksum, compression, stored: fields.bytes(length)? })
    }
}
