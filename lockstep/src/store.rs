//! The samples of one process: two of every channel, that of the current step and that of the one before.

use crate::{ChannelId, Layout};

/// Samples of the current and of the previous step, of every channel, in one block of memory.
///
/// Channels alternate between two buffers, so writing the sample of step k leaves that of k-1 readable (delayed edges) and
/// nothing is copied from one step to the next.
#[derive(Debug)]
pub struct Store {
    words: Vec<f64>,
    /// Start of the channel's even-step buffer; the odd-step buffer follows it.
    spans: Vec<(usize, usize)>,
    zeros: Vec<f64>,
}

impl Store {
    /// A store for channels of these layouts, all zeros.
    pub fn new<'a>(layouts: impl IntoIterator<Item = &'a Layout>) -> Self {
        let mut spans = Vec::new();
        let mut start = 0;
        let mut longest = 0;
        for layout in layouts {
            let length = layout.words();
            spans.push((start, length));
            start += 2 * length;
            longest = longest.max(length);
        }
        Self { words: vec![0.0; start], spans, zeros: vec![0.0; longest] }
    }

    /// The sample of `step`.
    pub fn read(&self, channel: ChannelId, step: u64) -> &[f64] {
        let (start, length) = self.span(channel, step);
        &self.words[start..start + length]
    }

    /// The sample of the step before `step`; zeros before step 0.
    pub fn read_before(&self, channel: ChannelId, step: u64) -> &[f64] {
        match step.checked_sub(1) {
            Some(before) => self.read(channel, before),
            None => &self.zeros[..self.spans[channel.0].1],
        }
    }

    /// The place of the sample of `step`.
    pub fn write(&mut self, channel: ChannelId, step: u64) -> &mut [f64] {
        let (start, length) = self.span(channel, step);
        &mut self.words[start..start + length]
    }

    fn span(&self, channel: ChannelId, step: u64) -> (usize, usize) {
        let (start, length) = self.spans[channel.0];
        (start + (step % 2) as usize * length, length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Field;

    #[test]
    fn two_steps_are_kept_apart() {
        let layout = Layout::new([Field::vector("x", 2, "")]);
        let mut store = Store::new([&layout, &layout]);
        let channel = ChannelId(1);
        assert_eq!(store.read_before(channel, 0), [0.0, 0.0]);
        store.write(channel, 0).copy_from_slice(&[1.0, 2.0]);
        store.write(channel, 1).copy_from_slice(&[3.0, 4.0]);
        assert_eq!(store.read_before(channel, 1), [1.0, 2.0]);
        assert_eq!(store.read(channel, 1), [3.0, 4.0]);
        assert_eq!(store.read(ChannelId(0), 1), [0.0, 0.0]);
    }
}
