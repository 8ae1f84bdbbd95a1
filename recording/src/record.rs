//! The records of an MCAP file as a log needs them.

use std::collections::BTreeMap;

/// The bytes that an MCAP file starts and ends with.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Opcodes of records. (MCAP specification, "Records")
pub(super) mod op {
    pub(in super::super) const HEADER: u8 = 0x01;
    pub(in super::super) const FOOTER: u8 = 0x02;
    pub(in super::super) const SCHEMA: u8 = 0x03;
    pub(in super::super) const CHANNEL: u8 = 0x04;
    pub(in super::super) const MESSAGE: u8 = 0x05;
    pub(in super::super) const CHUNK: u8 = 0x06;
    pub(in super::super) const MESSAGE_INDEX: u8 = 0x07;
    pub(in super::super) const CHUNK_INDEX: u8 = 0x08;
    pub(in super::super) const ATTACHMENT: u8 = 0x09;
    pub(in super::super) const ATTACHMENT_INDEX: u8 = 0x0A;
    pub(in super::super) const STATISTICS: u8 = 0x0B;
    pub(in super::super) const METADATA: u8 = 0x0C;
    pub(in super::super) const METADATA_INDEX: u8 = 0x0D;
    pub(in super::super) const SUMMARY_OFFSET: u8 = 0x0E;
    pub(in super::super) const DATA_END: u8 = 0x0F;
}

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

/// The record, or `None` for a kind that a log can be read without.
pub(super) fn parse(opcode: u8, body: &[u8]) -> Result<Option<Record<'_>>, String> {
    let mut fields = Fields(body);
    let (record, kind) = match opcode {
        op::MESSAGE => (fields.message(), "message"),
        op::HEADER => (fields.header(), "header"),
        op::SCHEMA => (fields.schema(), "schema"),
        op::CHANNEL => (fields.channel(), "channel"),
        op::ATTACHMENT => (fields.attachment(body), "attachment"),
        op::METADATA => (fields.metadata(), "metadata"),
        _ => return Ok(None),
    };
    record.map(Some).ok_or_else(|| format!("a {kind} record is malformed"))
}

/// What is left of the body of a record.
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl<'a> Fields<'a> {
    pub(super) fn bytes(&mut self, length: u64) -> Option<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(bytes)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*bytes)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.bytes(length.into())?).ok()
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_le_bytes)
    }

    /// The entries of a list with a length of 32 bits.
    pub(super) fn list(&mut self) -> Option<Fields<'a>> {
        let length = self.u32()?;
        self.bytes(length.into()).map(Fields)
    }

    fn map(&mut self) -> Option<BTreeMap<String, String>> {
        let mut entries = self.list()?;
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
