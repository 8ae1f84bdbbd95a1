//! The steps that are in a log already, while it is still being written.

use std::io;
use std::ops::Range;
use std::path::Path;

use lockstep::{ChannelId, Network, Store};

use super::LogError;
use super::reader::sample;
use super::record::Record;
use super::walk::walk;

/// Gives the steps of the range that are in the log `path` to `visit`, in order, each with its samples of all channels of
/// `network`, which is the one that the log was recorded with. Returns the first step that is not there.
///
/// # Errors
/// What `visit` returns, and that the log cannot be read.
pub fn play_log(
    path: &Path,
    network: &Network,
    steps: Range<u64>,
    visit: &mut dyn FnMut(&Store, u64) -> io::Result<()>,
) -> io::Result<u64> {
    let mut store = Store::new(network.channels.iter().map(|channel| &channel.layout));
    let mut next = steps.start;
    let mut failure = None;
    let last = network.channels.len().saturating_sub(1);
    let walked = walk(path, |at, record| {
        let Record::Message { channel, sequence, data, .. } = record else { return Ok(()) };
        let index = usize::from(channel);
        let Some(layout) = network.channels.get(index).map(|channel| &channel.layout) else { return Ok(()) };
        // A sequence number has 32 bits; steps follow each other, so the one that is due tells the rest.
        if failure.is_some() || next >= steps.end || sequence != next as u32 {
            return Ok(());
        }
        let wrong = || LogError::damaged(path, at, "a message is not as long as its layout");
        let (header, words) = sample(data, layout.bytes()).ok_or_else(wrong)?;
        let place = store.write(ChannelId(index), next).iter_mut();
        place.zip(words).for_each(|(place, word)| *place = f64::from_le_bytes(*word));
        store.stamp(ChannelId(index), next, header);
        if index == last {
            // The receiver has failed and needs no more samples.
            failure = visit(&store, next).err();
            next += 1;
        }
        Ok(())
    });
    match (failure, walked) {
        (Some(failure), _) => Err(failure),
        (None, Err(error)) => Err(io::Error::other(error.to_string())),
        (None, Ok(_)) => Ok(next),
    }
}
