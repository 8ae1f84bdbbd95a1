//! The records of an MCAP file, <https://mcap.dev/spec>, with those in its chunks.

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};

use crate::text::brief;

/// Bytes of a record before its content: opcode, length.
const PREFIX_BYTES: usize = 9;
/// Most bytes of a record in a compressed chunk.
const MOST_RECORD: usize = 64 << 20;
/// Most bytes of all of them.
const MOST_UNPACKED: usize = 2 << 30;

/// Takes a record: its opcode and content.
pub(super) type Take<'a> = dyn FnMut(u8, &[u8]) -> Result<(), String> + 'a;

/// Hands over all records but chunks, and the records in chunks. A file without its end is read as far as it goes.
///
/// # Errors
/// Says where and how the file is damaged, or what `take` says.
pub(super) fn for_each(bytes: &[u8], take: &mut Take) -> Result<(), String> {
    let is_whole = bytes.len() >= 2 * MAGIC.len() && bytes.ends_with(MAGIC);
    let end = bytes.len() - if is_whole { MAGIC.len() } else { 0 };
    let mut at = MAGIC.len();
    let mut unpacker = Unpacker::new();
    while at < end {
        let rest = &bytes[at..end];
        let damaged = |what: String| format!("the file is damaged at byte {at}: {what}");
        let Some((opcode, body)) = next(rest) else {
            if is_whole {
                return Err(damaged("a record ends behind the end of the file".into()));
            }
            if rest[0] == op::CHUNK && rest.len() > PREFIX_BYTES {
                // Whatever ends the readable part of an incomplete chunk.
                _ = unpacker.chunk(rest, false, take);
            }
            return Ok(());
        };
        match opcode {
            // Bytes that were reserved and never written.
            0 if !is_whole => return Ok(()),
            0 => return Err(damaged("0 is no kind of record".into())),
            op::CHUNK => unpacker.chunk(&rest[..PREFIX_BYTES + body.len()], true, take).map_err(damaged)?,
            op::FOOTER => return Ok(()),
            _ => take(opcode, body).map_err(damaged)?,
        }
        at += PREFIX_BYTES + body.len();
    }
    if is_whole { Err("the file is damaged: expected a footer at its end".into()) } else { Ok(()) }
}

/// The first record, if all of it is there.
fn next(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (&[opcode], rest) = bytes.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    Some((opcode, rest.get(..length)?))
}

/// Takes a number of `SIZE` bytes off.
pub(super) fn number<const SIZE: usize>(bytes: &mut &[u8]) -> Option<[u8; SIZE]> {
    let (number, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*number)
}

/// Takes bytes with their length of 4 bytes off.
pub(super) fn block<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = usize::try_from(u32::from_le_bytes(number(bytes)?)).ok()?;
    let (block, rest) = bytes.split_at_checked(length)?;
    *bytes = rest;
    Some(block)
}

/// Takes a text with its length off.
pub(super) fn text(bytes: &mut &[u8]) -> Option<String> {
    Some(String::from_utf8_lossy(block(bytes)?).into_owned())
}

/// Reads chunks.
struct Unpacker {
    reader: LinearReader,
    /// Bytes that came out of compressed chunks.
    unpacked: usize,
}

impl Unpacker {
    fn new() -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_validate_chunk_crcs(true)
            .with_record_length_limit(MOST_RECORD);
        Self { reader: LinearReader::new_with_options(options), unpacked: 0 }
    }

    /// Hands over the records of a chunk, which is a record itself, with or without its end.
    fn chunk(&mut self, record: &[u8], is_whole: bool, take: &mut Take) -> Result<(), String> {
        let mut body = &record[PREFIX_BYTES..];
        let (crc, compression, size) = head(&mut body).ok_or("the chunk has no complete head")?;
        match compression.as_str() {
            "" => {}
            "lz4" | "zstd" => return self.unpack(record, take),
            other => {
                let other = brief(other);
                return Err(format!("expected a chunk with the compression zstd, lz4 or none, found \"{other}\""));
            }
        }
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        let mut records = body.get(..size).unwrap_or(body);
        if is_whole && records.len() < size {
            return Err("the chunk is longer than its record".into());
        }
        if is_whole && crc != 0 && crc32fast::hash(records) != crc {
            return Err("the checksum of the chunk is wrong".into());
        }
        while !records.is_empty() {
            let (opcode, content) = next(records).ok_or("a record ends behind the end of its chunk")?;
            take(opcode, content)?;
            records = &records[PREFIX_BYTES + content.len()..];
        }
        Ok(())
    }

    fn unpack(&mut self, record: &[u8], take: &mut Take) -> Result<(), String> {
        let mut rest = record;
        while let Some(event) = self.reader.next_event() {
            match event.map_err(|error| describe(&error))? {
                // The reader knows the end of a chunk, and wants the record behind it.
                LinearReadEvent::ReadRequest(_) if rest.is_empty() => break,
                LinearReadEvent::ReadRequest(wanted) => {
                    let (part, behind) = rest.split_at(wanted.min(rest.len()));
                    self.reader.insert(part.len()).copy_from_slice(part);
                    self.reader.notify_read(part.len());
                    rest = behind;
                }
                LinearReadEvent::Record { data, opcode } => {
                    self.unpacked += PREFIX_BYTES + data.len();
                    if self.unpacked > MOST_UNPACKED {
                        return Err(format!("expected at most {} MiB in chunks, found more", MOST_UNPACKED >> 20));
                    }
                    take(opcode, data)?;
                }
            }
        }
        Ok(())
    }
}

/// Checksum, compression and size of a chunk.
fn head(body: &mut &[u8]) -> Option<(u32, String, u64)> {
    // The times of its first and last message, and the size of its records.
    number::<24>(body)?;
    let crc = u32::from_le_bytes(number(body)?);
    Some((crc, text(body)?, u64::from_le_bytes(number(body)?)))
}

fn describe(error: &McapError) -> String {
    match error {
        McapError::BadChunkCrc { .. } => "the checksum of the chunk is wrong".into(),
        McapError::RecordTooLarge { len, .. } => {
            format!("expected at most {} MiB in a record, found {len} bytes", MOST_RECORD >> 20)
        }
        error => format!("cannot unpack the chunk: {}", brief(&error.to_string().replace('\n', " "))),
    }
}
