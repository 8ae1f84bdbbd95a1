//! What stands behind the data of a file: a copy of its definitions, and where everything is. It is checked like the data, since
//! readers that do not read a file from front to end believe it.

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::encode::PREFIX_BYTES;
use super::record::{Fields, MAGIC, op};

/// Largest summary that is read for the number of messages, bytes.
const SUMMARY_MAX: u64 = 64 << 20;
/// What stands at the end of a file, bytes: footer and magic.
const END_BYTES: usize = PREFIX_BYTES + 20 + MAGIC.len();

/// How many messages every channel has, as far as the summary of the log `path` says it: the data may say something else. `None` if
/// there is no summary that could be read.
pub(super) fn claimed_messages(path: &Path) -> Option<BTreeMap<u16, u64>> {
    let file = File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    let mut end = [0; END_BYTES];
    let end_start = length.checked_sub(END_BYTES as u64)?;
    file.read_exact_at(&mut end, end_start).ok()?;
    if !end.ends_with(MAGIC) || end[0] != op::FOOTER {
        return None;
    }
    let start = Fields(&end[PREFIX_BYTES..]).u64()?;
    let bytes = end_start.checked_sub(start).filter(|bytes| *bytes <= SUMMARY_MAX)?;
    let mut summary = vec![0; usize::try_from(bytes).ok()?];
    file.read_exact_at(&mut summary, start).ok()?;
    let mut rest = Fields(&summary);
    while !rest.0.is_empty() {
        let (opcode, length) = (rest.bytes(1)?[0], rest.u64()?);
        let body = rest.bytes(length)?;
        if opcode == op::STATISTICS {
            let mut fields = Fields(body);
            // Totals, and the times of the first and the last message.
            fields.bytes(8 + 2 + 4 + 4 + 4 + 4 + 8 + 8)?;
            let mut list = fields.u32()? / 10;
            let mut messages = BTreeMap::new();
            while list > 0 {
                messages.insert(fields.u16()?, fields.u64()?);
                list -= 1;
            }
            return Some(messages);
        }
    }
    None
}

/// What the data of a file hold, as far as its summary speaks of it.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Checksum of the definition of every schema and of every channel, by opcode and number.
    definitions: BTreeMap<(u8, u16), u32>,
    chunks: Vec<Indexed>,
    attachments: Vec<Indexed>,
    metadata: Vec<Indexed>,
    /// Messages of every channel.
    messages: BTreeMap<u16, u64>,
    /// Time of the first and of the last message, ns.
    times: Option<[u64; 2]>,
}

/// A record that the summary points to.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Indexed {
    /// Place and length of the record, bytes.
    pub(super) start: u64,
    pub(super) length: u64,
    /// What else is said of it: sizes and times.
    pub(super) numbers: Vec<u64>,
    /// Its name, or its compression.
    pub(super) name: String,
    /// Of a chunk: the place of the index of every channel, and the length of all of them.
    pub(super) indexes: BTreeMap<u16, u64>,
    pub(super) index_length: u64,
}

impl Tally {
    /// A definition, in the data or in a chunk.
    pub(super) fn define(&mut self, opcode: u8, body: &[u8]) {
        if let Some(id) = Fields(body).u16() {
            self.definitions.entry((opcode, id)).or_insert_with(|| crc32fast::hash(body));
        }
    }

    /// A message.
    pub(super) fn message(&mut self, channel: u16, time: u64) {
        *self.messages.entry(channel).or_default() += 1;
        let [first, last] = self.times.unwrap_or([time; 2]);
        self.times = Some([first.min(time), last.max(time)]);
    }

    /// A record of the data, outside of chunks.
    pub(super) fn record(&mut self, opcode: u8, start: u64, length: u64, body: &[u8]) {
        match opcode {
            op::CHUNK => self.chunks.extend(Indexed::chunk(start, length, body)),
            op::ATTACHMENT => self.attachments.extend(Indexed::attachment(start, length, body)),
            op::METADATA => {
                let name = Fields(body).text().unwrap_or_default().to_string();
                self.metadata.push(Indexed { start, length, name, ..Indexed::default() });
            }
            op::MESSAGE_INDEX => {
                if let (Some(chunk), Some(channel)) = (self.chunks.last_mut(), Fields(body).u16()) {
                    chunk.indexes.insert(channel, start);
                    chunk.index_length += length;
                }
            }
            _ => {}
        }
    }
}

impl Indexed {
    fn chunk(start: u64, length: u64, body: &[u8]) -> Option<Self> {
        let mut fields = Fields(body);
        let (first, last, size) = (fields.u64()?, fields.u64()?, fields.u64()?);
        fields.u32()?;
        let (name, stored) = (fields.text()?.into(), fields.u64()?);
        Some(Self { start, length, numbers: vec![first, last, stored, size], name, ..Self::default() })
    }

    fn attachment(start: u64, length: u64, body: &[u8]) -> Option<Self> {
        let mut fields = Fields(body);
        let (logged, created) = (fields.u64()?, fields.u64()?);
        let name = fields.text()?.into();
        fields.text()?;
        Some(Self { start, length, numbers: vec![logged, created, fields.u64()?], name, ..Self::default() })
    }

    /// The entry of a summary for a chunk, an attachment or a metadata record.
    fn entry(opcode: u8, body: &[u8]) -> Option<Self> {
        let mut fields = Fields(body);
        let mut entry = Self::default();
        if opcode == op::CHUNK_INDEX {
            entry.numbers = vec![fields.u64()?, fields.u64()?];
        }
        (entry.start, entry.length) = (fields.u64()?, fields.u64()?);
        match opcode {
            op::CHUNK_INDEX => {
                let mut list = fields.list()?;
                while !list.0.is_empty() {
                    entry.indexes.insert(list.u16()?, list.u64()?);
                }
                entry.index_length = fields.u64()?;
                entry.name = fields.text()?.into();
                entry.numbers.extend([fields.u64()?, fields.u64()?]);
            }
            op::ATTACHMENT_INDEX => {
                entry.numbers = vec![fields.u64()?, fields.u64()?, fields.u64()?];
                entry.name = fields.text()?.into();
            }
            _ => entry.name = fields.text()?.into(),
        }
        Some(entry)
    }
}

/// The summary of a file while it is read.
#[derive(Debug, Default)]
pub(super) struct Summary {
    chunks: Vec<Indexed>,
    attachments: Vec<Indexed>,
    metadata: Vec<Indexed>,
    /// Place and length of the records of one kind, which stand together.
    groups: BTreeMap<u8, [u64; 2]>,
    offsets: Vec<(u8, [u64; 2])>,
}

impl Summary {
    /// Takes the next record, which begins at `start`; says what is wrong with it.
    pub(super) fn record(
        &mut self,
        tally: &Tally,
        opcode: u8,
        start: u64,
        length: u64,
        body: &[u8],
    ) -> Result<(), &'static str> {
        self.groups.entry(opcode).or_insert([start, 0])[1] += length;
        match opcode {
            op::SCHEMA | op::CHANNEL => {
                let id = Fields(body).u16().unwrap_or_default();
                let is_same = tally.definitions.get(&(opcode, id)) == Some(&crc32fast::hash(body));
                is_same.then_some(()).ok_or("a definition is not that of the data")?;
            }
            op::STATISTICS => {
                statistics_agree(tally, body).then_some(()).ok_or("the statistics are not those of the data")?
            }
            op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::METADATA_INDEX => {
                let entry = Indexed::entry(opcode, body).ok_or("an entry of the index is malformed")?;
                match opcode {
                    op::CHUNK_INDEX => self.chunks.push(entry),
                    op::ATTACHMENT_INDEX => self.attachments.push(entry),
                    _ => self.metadata.push(entry),
                }
            }
            op::SUMMARY_OFFSET => {
                let mut fields = Fields(body);
                let offset = (|| Some((fields.u8()?, [fields.u64()?, fields.u64()?])))();
                self.offsets.push(offset.ok_or("an entry of its table is malformed")?);
            }
            _ => {}
        }
        Ok(())
    }

    /// Compares all of it with the data and with the footer, at the end; `start` is where it begins.
    pub(super) fn conclude(mut self, tally: &Tally, start: u64, footer: [u64; 2]) -> Result<(), &'static str> {
        let pairs = [
            (&mut self.chunks, &tally.chunks),
            (&mut self.attachments, &tally.attachments),
            (&mut self.metadata, &tally.metadata),
        ];
        for (found, expected) in pairs {
            // Other writers may leave an index out, and order it as they like.
            found.sort_by_key(|entry| entry.start);
            if !found.is_empty() && found != expected {
                return Err("its index does not point to the records of the data");
            }
        }
        if self.offsets.iter().any(|(opcode, place)| self.groups.get(opcode) != Some(place)) {
            return Err("its table does not point to its records");
        }
        let offsets = self.groups.get(&op::SUMMARY_OFFSET).map_or(0, |[start, _]| *start);
        let is_empty = self.groups.keys().all(|opcode| *opcode == op::SUMMARY_OFFSET);
        let starts = [if is_empty { 0 } else { start }, offsets];
        // A file without summary may point to where it would be.
        let fits =
            |(found, expected): (&u64, u64)| *found == expected || (expected == 0 && *found == start) || *found == 0;
        footer.iter().zip(starts).all(fits).then_some(()).ok_or("the footer does not point to it")
    }
}

fn statistics_agree(tally: &Tally, body: &[u8]) -> bool {
    let mut fields = Fields(body);
    let count = |opcode: u8| tally.definitions.keys().filter(|(kind, _)| *kind == opcode).count() as u64;
    let [first, last] = tally.times.unwrap_or_default();
    let agree = (|| {
        let mut all = fields.u64()? == tally.messages.values().sum::<u64>();
        all &= u64::from(fields.u16()?) == count(op::SCHEMA);
        all &= u64::from(fields.u32()?) == count(op::CHANNEL);
        for expected in [tally.attachments.len(), tally.metadata.len(), tally.chunks.len()] {
            all &= fields.u32()? as usize == expected;
        }
        all &= fields.u64()? == first && fields.u64()? == last;
        let mut list = fields.list()?;
        let mut counts = BTreeMap::new();
        while !list.0.is_empty() {
            counts.insert(list.u16()?, list.u64()?);
        }
        counts.retain(|_, count| *count > 0);
        Some(all && counts == tally.messages)
    })();
    agree == Some(true)
}
