//! A walk through an MCAP file, record by record, also of a damaged or unfinished file.
//!
//! A reader of its own, because a log may be cut or hostile: every length is checked against what is there before memory is
//! taken for it, and nothing is copied out of a chunk.

use std::fs::File;
use std::io::{BufReader, Read};
use std::os::unix::fs::FileExt;
use std::path::Path;

use crc32fast::Hasher;
use zstd::bulk::Decompressor;

use super::LogError;
use super::encode::PREFIX_BYTES;
use super::place::is_written_to;
use super::record::{Fields, MAGIC, Record, op, parse};
use super::summary::{Summary, Tally};

/// Longest record, and longest content of a chunk, that is read: far above what a recorder writes. Bytes.
const RECORD_MAX: u64 = 256 << 20;
/// Content that all chunks may have together, per byte of the file read so far ...
const EXPANSION_MAX: u64 = 512;
/// ... and in addition to that, bytes. Both keep a small file from filling the memory.
const EXPANSION_FREE: u64 = 1 << 30;
/// Bytes of a footer before its checksum.
const FOOTER_COVERED: usize = 16;
/// How the header of a file of this program names its writer.
const LIBRARY: &str = "phalanx ";

/// How the walk through a file ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// With the footer: the file was finished.
    Complete,
    /// In the middle of a record: its writer was killed. The records before this place are complete.
    Cut {
        /// Offset, bytes.
        at: u64,
    },
}

/// Gives every record of the data section, chunks unpacked and checked, to `visit` with the place of its outermost record, and
/// checks what stands behind the data. Of a log that is being written, damage at its end is a cut: a reader may look while a chunk
/// takes the place of another one.
///
/// # Errors
/// [`LogError::Read`], [`LogError::NotMcap`], [`LogError::Compression`], [`LogError::Damaged`], and what `visit` returns.
pub(super) fn walk(
    path: &Path,
    visit: impl FnMut(u64, Record<'_>) -> Result<(), LogError>,
) -> Result<Ending, LogError> {
    let file = File::open(path).map_err(|error| LogError::read(path, error))?;
    let lock = file.try_clone();
    let source = Source { path, file: BufReader::with_capacity(1 << 16, file), position: 0 };
    let decompressor = Decompressor::new().map_err(|error| LogError::read(path, error))?;
    let unpacker = Unpacker { decompressor, content: Vec::new(), total: 0 };
    let walk =
        Walk { source, record: Vec::new(), checksum: Hasher::new(), tally: Tally::default(), is_own: false, visit };
    match walk.run(unpacker) {
        Err(LogError::Damaged { at, .. }) if lock.is_ok_and(|file| is_written_to(&file)) => Ok(Ending::Cut { at }),
        result => result,
    }
}

/// A walk through one file.
struct Walk<'a, V> {
    source: Source<'a>,
    /// The record that was read last.
    record: Vec<u8>,
    /// Of all before the end of the data.
    checksum: Hasher,
    tally: Tally,
    /// Whether the header says that this program wrote the file.
    is_own: bool,
    visit: V,
}

impl<V: FnMut(u64, Record<'_>) -> Result<(), LogError>> Walk<'_, V> {
    fn run(mut self, mut unpacker: Unpacker) -> Result<Ending, LogError> {
        if !self.source.take(MAGIC.len() as u64, &mut self.record)? || self.record != MAGIC {
            let what =
                if self.record.is_empty() { "it is empty" } else { "it does not start with the magic bytes of MCAP" };
            return Err(LogError::NotMcap { path: self.source.path.into(), what });
        }
        self.checksum.update(&self.record);
        loop {
            let at = self.source.position;
            let before = self.checksum.clone();
            let Some(opcode) = self.next()? else { return self.source.cut(at) };
            match opcode {
                op::FOOTER => return Err(self.damaged(at, "the end of the data is missing")),
                op::DATA_END => {
                    let expected = Fields(&self.record).u32().filter(|_| self.record.len() == 4);
                    let expected = expected.ok_or_else(|| self.damaged(at, "the end of the data is malformed"))?;
                    if expected != 0 && expected != before.finalize() {
                        return Err(self.damaged(at, "the checksum of the file is wrong"));
                    }
                    return self.summary();
                }
                op::CHUNK => self.chunk(at, &mut unpacker)?,
                _ => self.visit(at, opcode)?,
            }
            let length = self.source.position - at;
            self.tally.record(opcode, at, length, &self.record);
        }
    }

    /// Reads the next record and returns its opcode; `None` if the file ends before it does.
    fn next(&mut self) -> Result<Option<u8>, LogError> {
        let at = self.source.position;
        if !self.source.take(PREFIX_BYTES as u64, &mut self.record)? {
            return Ok(None);
        }
        self.checksum.update(&self.record);
        let (opcode, length) = prefix(&self.record).ok_or_else(|| self.damaged(at, "a record has no length"))?;
        if length > RECORD_MAX {
            return Err(self.damaged(at, format!("a record claims {length} bytes, {RECORD_MAX} are allowed")));
        }
        let is_there = self.source.take(length, &mut self.record)?;
        // The footer ends with the checksum of all before it.
        let covered = if opcode == op::FOOTER { self.record.len().min(FOOTER_COVERED) } else { self.record.len() };
        self.checksum.update(&self.record[..covered]);
        Ok(is_there.then_some(opcode))
    }

    /// Gives the records of a chunk away.
    fn chunk(&mut self, at: u64, unpacker: &mut Unpacker) -> Result<(), LogError> {
        let path = self.source.path;
        let damaged = |what: &str| LogError::damaged(path, at, what);
        let records = match unpacker.unpack(&self.record, self.source.position) {
            Ok(records) => records,
            Err(Fault::Compression(compression)) if !self.is_own => {
                return Err(LogError::Compression { path: path.into(), compression });
            }
            Err(fault) => return Err(damaged(&fault.to_string())),
        };
        each(records, |opcode, body| {
            if matches!(opcode, op::SCHEMA | op::CHANNEL) {
                self.tally.define(opcode, body);
            }
            match parse(opcode, body).map_err(|what| damaged(&what))? {
                Some(record) => {
                    if let Record::Message { channel, log_time, .. } = record {
                        self.tally.message(channel, log_time);
                    }
                    (self.visit)(at, record)
                }
                None => Ok(()),
            }
        })
        .unwrap_or_else(|| Err(damaged("a record is longer than its chunk")))?;
        (self.visit)(at, Record::ChunkEnd)
    }

    /// Gives a record away that stands outside of chunks.
    fn visit(&mut self, at: u64, opcode: u8) -> Result<(), LogError> {
        if matches!(opcode, op::SCHEMA | op::CHANNEL) {
            self.tally.define(opcode, &self.record);
        }
        let path = self.source.path;
        let Some(record) = parse(opcode, &self.record).map_err(|what| LogError::damaged(path, at, what))? else {
            return Ok(());
        };
        match record {
            Record::Header { library, .. } => self.is_own = library.starts_with(LIBRARY),
            Record::Message { channel, log_time, .. } => self.tally.message(channel, log_time),
            _ => {}
        }
        (self.visit)(at, record)
    }

    /// Checks what stands behind the data. Every mistake is one of the whole summary, which can be made anew from the data.
    fn summary(mut self) -> Result<Ending, LogError> {
        let start = self.source.position;
        let wrong =
            |path, what: &str| LogError::damaged(path, start, format!("the summary behind the data is wrong: {what}"));
        let mut summary = Summary::default();
        self.checksum = Hasher::new();
        loop {
            let at = self.source.position;
            let Some(opcode) = self.next()? else { return self.source.cut(at) };
            if opcode == op::FOOTER {
                break;
            }
            let length = self.source.position - at;
            let taken = summary.record(&self.tally, opcode, at, length, &self.record);
            taken.map_err(|what| wrong(self.source.path, what))?;
        }
        let path = self.source.path;
        let mut fields = Fields(&self.record);
        let footer = (|| Some(([fields.u64()?, fields.u64()?], fields.u32()?)))().filter(|_| fields.0.is_empty());
        let (starts, checksum) = footer.ok_or_else(|| wrong(path, "the footer is malformed"))?;
        if checksum != 0 && checksum != self.checksum.clone().finalize() {
            return Err(wrong(path, "its checksum is another one"));
        }
        summary.conclude(&self.tally, start, starts).map_err(|what| wrong(path, what))?;
        let at = self.source.position;
        if !self.source.take(MAGIC.len() as u64, &mut self.record)? {
            return Ok(Ending::Cut { at });
        }
        if self.record != MAGIC || self.source.take(1, &mut self.record)? {
            return Err(wrong(path, "the file does not end with the magic bytes of MCAP"));
        }
        Ok(Ending::Complete)
    }

    fn damaged(&self, at: u64, what: impl Into<String>) -> LogError {
        LogError::damaged(self.source.path, at, what)
    }
}

/// The file, read from front to end.
struct Source<'a> {
    path: &'a Path,
    file: BufReader<File>,
    position: u64,
}

impl Source<'_> {
    /// Reads `length` bytes; false if there are fewer. Allocates for the bytes that exist only, so that a wrong `length` costs nothing.
    fn take(&mut self, length: u64, into: &mut Vec<u8>) -> Result<bool, LogError> {
        into.clear();
        let read = self.file.by_ref().take(length).read_to_end(into);
        let read = read.map_err(|error| LogError::read(self.path, error))? as u64;
        self.position += read;
        Ok(read == length)
    }

    /// The end of a file within the record at `at`: it was cut there, unless it ends as a finished file does.
    fn cut(&self, at: u64) -> Result<Ending, LogError> {
        let file = self.file.get_ref();
        let mut end = [0; MAGIC.len()];
        let length = file.metadata().map_or(0, |metadata| metadata.len());
        let is_finished = length > 2 * MAGIC.len() as u64
            && file.read_exact_at(&mut end, length - MAGIC.len() as u64).is_ok()
            && end == MAGIC;
        match is_finished {
            true => Err(LogError::damaged(self.path, at, "a record claims more bytes than the file has")),
            false => Ok(Ending::Cut { at }),
        }
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

/// Why the records of a chunk cannot be read.
#[derive(Debug, thiserror::Error)]
enum Fault {
    #[error("{0}")]
    Wrong(String),
    #[error("a chunk is compressed with {0:?}, only zstd is supported")]
    Compression(String),
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
    fn unpack<'a>(&'a mut self, chunk: &'a [u8], read: u64) -> Result<&'a [u8], Fault> {
        let malformed = || Fault::Wrong("a chunk is malformed".into());
        let Chunk { size, checksum, compression, stored } = Chunk::parse(chunk).ok_or_else(malformed)?;
        self.total = self.total.saturating_add(size);
        if size > RECORD_MAX || self.total > EXPANSION_FREE + EXPANSION_MAX * read {
            return Err(Fault::Wrong(format!("a chunk claims a content of {size} bytes, more than allowed")));
        }
        let records = match compression {
            "" => stored,
            "zstd" => {
                self.content.clear();
                self.content.reserve_exact(size as usize);
                let written = self.decompressor.decompress_to_buffer(stored, &mut self.content);
                written.map_err(|error| Fault::Wrong(format!("a chunk cannot be decompressed: {error}")))?;
                &self.content
            }
            other => return Err(Fault::Compression(other.into())),
        };
        if records.len() as u64 != size {
            return Err(Fault::Wrong(format!("a chunk holds {} bytes, not {size}", records.len())));
        }
        if checksum != 0 && checksum != crc32fast::hash(records) {
            return Err(Fault::Wrong("the checksum of a chunk is wrong".into()));
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
