//! Encoded messages on their way from the step thread to the writer thread.

use super::ENCAPSULATION;

/// One message of a [`Batch`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Number of the channel in the file.
    pub(super) channel: u16,
    /// The step it belongs to.
    pub(super) step: u64,
    /// Where its bytes end; they start where those of the entry before it end.
    end: usize,
}

/// Messages of some steps, in order. Emptied and used again, so that a step allocates nothing once the run is warm.
#[derive(Debug, Default)]
pub(super) struct Batch {
    bytes: Vec<u8>,
    entries: Vec<Entry>,
    /// Whether the last step in it is complete.
    pub(super) ends_step: bool,
}

impl Batch {
    /// Appends a sample: encapsulation, header, words.
    pub(super) fn push_sample(&mut self, channel: u16, step: u64, header: &lockstep::Header, words: &[f64]) {
        self.bytes.extend_from_slice(&ENCAPSULATION);
        self.bytes.extend_from_slice(&header.to_bytes());
        let start = self.bytes.len();
        self.bytes.resize(start + 8 * words.len(), 0);
        for (place, word) in self.bytes[start..].chunks_exact_mut(8).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        self.entries.push(Entry { channel, step, end: self.bytes.len() });
    }

    /// Appends a message that is encoded already.
    pub(super) fn push_payload(&mut self, channel: u16, step: u64, payload: &[u8]) {
        self.bytes.extend_from_slice(payload);
        self.entries.push(Entry { channel, step, end: self.bytes.len() });
    }

    /// The messages in order.
    pub(super) fn messages(&self) -> impl Iterator<Item = (Entry, &[u8])> {
        let mut start = 0;
        self.entries.iter().map(move |entry| {
            let bytes = &self.bytes[start..entry.end];
            start = entry.end;
            (*entry, bytes)
        })
    }

    /// Size of all messages.
    pub(super) fn bytes(&self) -> usize {
        self.bytes.len()
    }

    /// Whether there is nothing to write.
    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Forgets the messages, keeps the memory.
    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        self.entries.clear();
        self.ends_step = false;
    }
}
