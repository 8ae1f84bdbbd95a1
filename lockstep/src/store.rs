//! The samples of one process: two of every channel, that of the current step and that of the one before.

use crate::{Channel, ChannelId, Header, Layout, Network, Status, Timing};

/// Samples of the current and of the previous step, of every channel, in one block of memory.
///
/// Channels alternate between two buffers, so writing the sample of step k leaves that of k-1 readable (delayed edges) and
/// nothing is copied from one step to the next. Until its writer has run, a channel reads as its initial sample, delayed or not.
#[derive(Debug)]
pub struct Store {
    words: Vec<f64>,
    /// Where the channels are among `slots`.
    index: Vec<u32>,
    slots: Vec<Slot>,
}

/// What there is of a channel besides its words.
#[derive(Clone, Debug, Default)]
struct Slot {
    /// Start of the even-step buffer within the words; the odd-step buffer follows it.
    start: usize,
    /// Words of a sample.
    length: usize,
    /// Headers of the even-step and the odd-step sample, once there are such samples.
    headers: [Option<Header>; 2],
    /// Whether the sample in the making is not new.
    marked: bool,
}

/// What stands where nothing is written yet: one of the many NaNs, which computations do not come to by themselves.
const UNWRITTEN: f64 = f64::from_bits(0x7ff8_0000_756e_7772);

/// Whether this is a number that was not written.
pub(crate) fn is_unwritten(word: f64) -> bool {
    word.to_bits() == UNWRITTEN.to_bits()
}

impl Store {
    /// A store for channels of these layouts, all zeros.
    pub fn new<'a>(layouts: impl IntoIterator<Item = &'a Layout>) -> Self {
        Self::with(layouts.into_iter().map(|layout| Some(layout.words())))
    }

    /// A store for the channels of a network, with their initial samples.
    pub fn of(network: &Network) -> Self {
        Self::of_some(network, |_| true)
    }

    /// A store in which there is room for some of the channels only; the others are of no length.
    pub fn of_some(network: &Network, is_used: impl Fn(ChannelId) -> bool) -> Self {
        let used = |(number, channel): (usize, &Channel)| is_used(ChannelId(number)).then(|| channel.layout.words());
        let mut store = Self::with(network.channels.iter().enumerate().map(used));
        for (number, channel) in network.channels.iter().enumerate().filter(|(_, channel)| !channel.initial.is_empty())
        {
            if is_used(ChannelId(number)) {
                store.begin(ChannelId(number), &channel.initial);
            }
        }
        store
    }

    fn with(lengths: impl Iterator<Item = Option<usize>>) -> Self {
        // The first one stands for all that are not there.
        let mut slots = vec![Slot::default()];
        let mut start = 0;
        let place = |length: Option<usize>| {
            let Some(length) = length else { return 0 };
            slots.push(Slot { start, length, ..Slot::default() });
            start += 2 * length;
            slots.len() as u32 - 1
        };
        let index = lengths.map(place).collect();
        Self { words: vec![0.0; start], index, slots }
    }

    /// Lets a channel start with this sample: it is read, delayed or not, until the channel is written.
    pub(crate) fn begin(&mut self, channel: ChannelId, sample: &[f64]) {
        for step in 0..2 {
            self.write(channel, step).copy_from_slice(sample);
        }
    }

    fn slot(&self, channel: ChannelId) -> &Slot {
        &self.slots[self.index[channel.0] as usize]
    }

    fn slot_mut(&mut self, channel: ChannelId) -> &mut Slot {
        &mut self.slots[self.index[channel.0] as usize]
    }

    /// The sample of `step`.
    pub fn read(&self, channel: ChannelId, step: u64) -> &[f64] {
        let (start, length) = self.span(channel, step);
        &self.words[start..start + length]
    }

    /// The sample of the step before `step`; the initial sample at step 0.
    pub fn read_before(&self, channel: ChannelId, step: u64) -> &[f64] {
        self.read(channel, before(step))
    }

    /// The place of the sample of `step`.
    pub fn write(&mut self, channel: ChannelId, step: u64) -> &mut [f64] {
        let (start, length) = self.span(channel, step);
        &mut self.words[start..start + length]
    }

    /// Where `length` words at `offset` in the sample are that a reader of this timing sees at `step`.
    ///
    /// Nothing but the words themselves is referred to, so that pointers to other samples stay valid.
    pub(crate) fn pointer(
        &self,
        channel: ChannelId,
        step: u64,
        timing: Timing,
        offset: usize,
        length: usize,
    ) -> *const f64 {
        let sample = if timing == Timing::Delayed { before(step) } else { step };
        self.words.as_ptr().wrapping_add(self.place(channel, sample, offset, length))
    }

    /// Where `length` words at `offset` in the sample of `step` belong; see [`Store::pointer`].
    pub(crate) fn pointer_mut(&mut self, channel: ChannelId, step: u64, offset: usize, length: usize) -> *mut f64 {
        let place = self.place(channel, step, offset, length);
        self.words.as_mut_ptr().wrapping_add(place)
    }

    fn place(&self, channel: ChannelId, step: u64, offset: usize, length: usize) -> usize {
        let (start, words) = self.span(channel, step);
        assert!(offset + length <= words, "a signal ends beyond its sample");
        start + offset
    }

    /// The header of the sample of `step`; `None` if the channel's writer has not run yet.
    pub fn header(&self, channel: ChannelId, step: u64) -> Option<&Header> {
        self.slot(channel).headers[(step % 2) as usize].as_ref()
    }

    /// Gives the sample of `step` its header.
    pub fn stamp(&mut self, channel: ChannelId, step: u64, header: Header) {
        self.slot_mut(channel).headers[(step % 2) as usize] = Some(header);
    }

    /// Makes the sample of `step` one of which nothing is written yet.
    pub(crate) fn forget(&mut self, channel: ChannelId, step: u64) {
        self.write(channel, step).fill(UNWRITTEN);
    }

    /// Says that the sample of a channel that is being made is not new.
    pub(crate) fn mark(&mut self, channel: ChannelId) {
        self.slot_mut(channel).marked = true;
    }

    /// Whether that was said; it is forgotten then.
    pub(crate) fn take_mark(&mut self, channel: ChannelId) -> bool {
        std::mem::take(&mut self.slot_mut(channel).marked)
    }

    /// Lets the sample of the step before stand for `step` too: same numbers, same time stamp, with the status that says why.
    ///
    /// A channel without a sample so far stays without one.
    pub fn hold(&mut self, channel: ChannelId, step: u64, status: Status) {
        let Some(before) = step.checked_sub(1) else { return };
        let (from, length) = self.span(channel, before);
        let (to, _) = self.span(channel, step);
        self.words.copy_within(from..from + length, to);
        if let Some(header) = self.header(channel, before).copied() {
            self.stamp(channel, step, Header { status: status as u32, ..header });
        }
    }

    fn span(&self, channel: ChannelId, step: u64) -> (usize, usize) {
        let &Slot { start, length, .. } = self.slot(channel);
        (start + (step % 2) as usize * length, length)
    }
}

/// The step before, by the buffer that its sample stands in: at step 0, nothing has been written into that one.
fn before(step: u64) -> u64 {
    step.wrapping_sub(1)
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

    #[test]
    fn a_held_sample_keeps_its_numbers_and_its_stamp() {
        let layout = Layout::new([Field::scalar("x", "")]);
        let mut store = Store::new([&layout]);
        let channel = ChannelId(0);
        store.hold(channel, 0, Status::Held);
        assert_eq!(store.header(channel, 0), None);
        store.write(channel, 4)[0] = 7.0;
        store.stamp(channel, 4, Header::new(4, 1_000_000, 2, Status::Fresh));
        store.hold(channel, 5, Status::Held);
        assert_eq!(store.read(channel, 5), [7.0]);
        assert_eq!(store.header(channel, 5), Some(&Header::new(4, 1_000_000, 2, Status::Held)));
    }
}
