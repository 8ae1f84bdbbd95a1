//! A chunk of a log: messages of some steps, collected by the step thread, compressed by another one.

use std::io;

use lockstep::{HEADER_BYTES, Header};
use zstd::bulk::Compressor;

use super::ENCAPSULATION;
use super::encode::{Encode, PREFIX_BYTES};
use super::record::op;

/// Level of the compression; part of what makes equal runs equal bytes.
const LEVEL: i32 = 1;
/// Bytes of a message record before its data: prefix, channel, sequence, two times.
const MESSAGE_BYTES: usize = PREFIX_BYTES + 22;

/// Messages, and definitions that they need. Emptied and used again, so that a step allocates nothing once the run is warm.
#[derive(Debug, Default)]
pub(super) struct Chunk {
    /// The records.
    records: Vec<u8>,
    /// Time and place of the messages of every channel.
    index: Vec<Vec<(u64, u64)>>,
    /// Smallest and largest time of a message.
    times: Option<[u64; 2]>,
    /// Data of all messages, bytes.
    payload: usize,
    /// Definitions among the records, bytes.
    defined: usize,
    /// Records that have been shown already, bytes.
    shown: usize,
    /// Smallest and largest time of a message that has not been shown.
    unshown_times: Option<[u64; 2]>,
}

impl Chunk {
    /// Appends a definition.
    pub(super) fn define(&mut self, opcode: u8, fields: impl FnOnce(&mut Vec<u8>)) {
        let start = self.records.len();
        self.records.record(opcode, fields);
        self.defined += self.records.len() - start;
    }

    /// Appends a message with the times of its logging and publication, ns.
    pub(super) fn message(&mut self, channel: u16, sequence: u32, times: [u64; 2], data: &[u8]) {
        self.begin(channel, sequence, times, data.len());
        self.records.extend_from_slice(data);
    }

    /// Appends a sample: encapsulation, header, words.
    pub(super) fn sample(&mut self, channel: u16, sequence: u32, time: u64, header: &Header, words: &[f64]) {
        self.begin(channel, sequence, [time; 2], ENCAPSULATION.len() + HEADER_BYTES + 8 * words.len());
        self.records.extend_from_slice(&ENCAPSULATION);
        self.records.extend_from_slice(&header.to_bytes());
        let start = self.records.len();
        self.records.resize(start + 8 * words.len(), 0);
        for (place, word) in self.records[start..].chunks_exact_mut(8).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
    }

    fn begin(&mut self, channel: u16, sequence: u32, [logged, published]: [u64; 2], length: usize) {
        let place = usize::from(channel);
        if place >= self.index.len() {
            self.index.resize_with(place + 1, Vec::new);
        }
        self.index[place].push((logged, self.records.len() as u64));
        for times in [&mut self.times, &mut self.unshown_times] {
            let [first, last] = times.unwrap_or([logged; 2]);
            *times = Some([first.min(logged), last.max(logged)]);
        }
        self.payload += length;
        let mut head = [0; MESSAGE_BYTES];
        head[0] = op::MESSAGE;
        head[1..9].copy_from_slice(&((MESSAGE_BYTES - PREFIX_BYTES + length) as u64).to_le_bytes());
        head[9..11].copy_from_slice(&channel.to_le_bytes());
        head[11..15].copy_from_slice(&sequence.to_le_bytes());
        head[15..23].copy_from_slice(&logged.to_le_bytes());
        head[23..31].copy_from_slice(&published.to_le_bytes());
        self.records.extend_from_slice(&head);
    }

    /// Data of all messages, bytes.
    pub(super) fn payload(&self) -> usize {
        self.payload
    }

    /// Whether there is nothing in it.
    pub(super) fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Whether there are messages that have not been shown.
    pub(super) fn is_behind(&self) -> bool {
        self.unshown_times.is_some()
    }

    /// Appends what has not been shown yet to `bytes` as a chunk of an MCAP file, not compressed.
    pub(super) fn show(&mut self, bytes: &mut Vec<u8>) {
        let records = &self.records[self.shown..];
        bytes.reserve(records.len() + 128);
        bytes.record(op::CHUNK, |body| {
            self.unshown_times.unwrap_or_default().iter().for_each(|time| body.put_u64(*time));
            body.put_u64(records.len() as u64);
            body.put_u32(crc32fast::hash(records));
            body.put_text("");
            body.put_u64(records.len() as u64);
            body.extend_from_slice(records);
        });
        (self.shown, self.unshown_times) = (self.records.len(), None);
    }

    /// Definitions among the records, bytes.
    pub(super) fn defined(&self) -> usize {
        self.defined
    }

    /// Forgets everything, keeps the memory.
    pub(super) fn clear(&mut self) {
        self.records.clear();
        self.index.iter_mut().for_each(Vec::clear);
        (self.times, self.unshown_times) = (None, None);
        (self.payload, self.defined, self.shown) = (0, 0, 0);
    }

    /// Number of messages of every channel that has any.
    pub(super) fn counts(&self) -> impl Iterator<Item = (u16, u64)> {
        let channels = self.index.iter().enumerate().filter(|(_, entries)| !entries.is_empty());
        channels.map(|(channel, entries)| (channel as u16, entries.len() as u64))
    }

    /// Smallest and largest time of a message.
    pub(super) fn times(&self) -> Option<[u64; 2]> {
        self.times
    }
}

/// Compresses chunks, one after the other into the same memory.
pub(super) struct Packer {
    compressor: Compressor<'static>,
    packed: Packed,
}

/// A chunk as it stands in the file.
#[derive(Debug, Default)]
pub(super) struct Packed {
    /// The chunk record, and behind it the message index records.
    pub(super) bytes: Vec<u8>,
    /// The compressed content.
    content: Vec<u8>,
    /// The message index records.
    index: Vec<u8>,
    /// Length of the chunk record, bytes.
    length: u64,
    /// Where the index of a channel begins within `index`.
    offsets: Vec<(u16, u64)>,
    size: u64,
    times: [u64; 2],
}

impl Packer {
    pub(super) fn new() -> io::Result<Self> {
        Ok(Self { compressor: Compressor::new(LEVEL)?, packed: Packed::default() })
    }

    /// Compresses a chunk. The bytes depend on nothing but the chunk.
    pub(super) fn pack(&mut self, chunk: &Chunk) -> io::Result<&Packed> {
        let Packed { bytes, content, index, length, offsets, size, times } = &mut self.packed;
        content.clear();
        content.reserve(zstd::zstd_safe::compress_bound(chunk.records.len()));
        self.compressor.compress_to_buffer(&chunk.records, content)?;
        *times = chunk.times.unwrap_or_default();
        *size = chunk.records.len() as u64;
        bytes.clear();
        bytes.record(op::CHUNK, |body| {
            times.iter().for_each(|time| body.put_u64(*time));
            body.put_u64(*size);
            body.put_u32(crc32fast::hash(&chunk.records));
            body.put_text("zstd");
            body.put_u64(content.len() as u64);
            body.extend_from_slice(content);
        });
        *length = bytes.len() as u64;
        index.clear();
        offsets.clear();
        for (channel, entries) in chunk.index.iter().enumerate().filter(|(_, entries)| !entries.is_empty()) {
            offsets.push((channel as u16, index.len() as u64));
            index.record(op::MESSAGE_INDEX, |body| {
                body.put_u16(channel as u16);
                body.put_list(|list| {
                    for (time, offset) in entries {
                        list.put_u64(*time);
                        list.put_u64(*offset);
                    }
                });
            });
        }
        bytes.extend_from_slice(index);
        Ok(&self.packed)
    }
}

impl Packed {
    /// Appends the entry of the summary that points to the chunk, whose record begins at `start` of the file.
    pub(super) fn point_to(&self, start: u64, summary: &mut Vec<u8>) {
        let length = self.length;
        summary.record(op::CHUNK_INDEX, |body| {
            self.times.iter().for_each(|time| body.put_u64(*time));
            body.put_u64(start);
            body.put_u64(length);
            body.put_list(|list| {
                for (channel, offset) in &self.offsets {
                    list.put_u16(*channel);
                    list.put_u64(start + length + offset);
                }
            });
            body.put_u64(self.index.len() as u64);
            body.put_text("zstd");
            body.put_u64(self.content.len() as u64);
            body.put_u64(self.size);
        });
    }
}
