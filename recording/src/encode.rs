//! Fields and records of an MCAP file, little-endian, appended to a buffer.

use std::collections::BTreeMap;

/// Opcode and length before every record, bytes.
pub(super) const PREFIX_BYTES: usize = 9;

/// A buffer that records are appended to.
pub(super) trait Encode {
    /// Appends a record whose body `fields` appends.
    fn record(&mut self, opcode: u8, fields: impl FnOnce(&mut Self));
    /// Appends a number of 16 bits.
    fn put_u16(&mut self, value: u16);
    /// Appends a number of 32 bits.
    fn put_u32(&mut self, value: u32);
    /// Appends a number of 64 bits.
    fn put_u64(&mut self, value: u64);
    /// Appends a length of 32 bits, and the text.
    fn put_text(&mut self, text: &str);
    /// Appends a length of 32 bits, and pairs of texts in order of the first.
    fn put_texts(&mut self, texts: &BTreeMap<String, String>);
    /// Appends a length of 32 bits, and what `entries` appends.
    fn put_list(&mut self, entries: impl FnOnce(&mut Self));
}

impl Encode for Vec<u8> {
    fn record(&mut self, opcode: u8, fields: impl FnOnce(&mut Self)) {
        self.push(opcode);
        self.put_u64(0);
        let start = self.len();
        fields(self);
        let length = (self.len() - start) as u64;
        self[start - 8..start].copy_from_slice(&length.to_le_bytes());
    }

    fn put_u16(&mut self, value: u16) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_u32(&mut self, value: u32) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_u64(&mut self, value: u64) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_text(&mut self, text: &str) {
        self.put_list(|buffer| buffer.extend_from_slice(text.as_bytes()));
    }

    fn put_texts(&mut self, texts: &BTreeMap<String, String>) {
        self.put_list(|buffer| {
            for (name, text) in texts {
                buffer.put_text(name);
                buffer.put_text(text);
            }
        });
    }

    fn put_list(&mut self, entries: impl FnOnce(&mut Self)) {
        self.put_u32(0);
        let start = self.len();
        entries(self);
        let length = (self.len() - start) as u32;
        self[start - 4..start].copy_from_slice(&length.to_le_bytes());
    }
}
