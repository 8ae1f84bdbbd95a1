//! The last steps of a run, which its log does not hold yet.

use std::io;
use std::ops::Range;
use std::path::Path;

use lockstep::{ChannelId, Header, Network, Store};
use processes::History;

use recording::{Recorder, UNSETTLED, play_log};

/// Steps that are kept.
const KEPT: u64 = 2 * UNSETTLED;

/// The samples of the last [`KEPT`] steps; memory is taken once.
pub(super) struct Tail {
    rows: Vec<Row>,
    /// The step that comes next.
    next: u64,
}

#[derive(Clone, Default)]
struct Row {
    headers: Vec<Option<Header>>,
    words: Vec<f64>,
}

impl Tail {
    pub(super) fn new() -> Self {
        Self { rows: vec![Row::default(); KEPT as usize], next: 0 }
    }

    /// Keeps the samples of `step`, the one after the last that was kept.
    pub(super) fn note(&mut self, network: &Network, store: &Store, step: u64) {
        let row = &mut self.rows[(step % KEPT) as usize];
        row.headers.clear();
        row.words.clear();
        for channel in (0..network.channels.len()).map(ChannelId) {
            row.headers.push(store.header(channel, step).copied());
            row.words.extend_from_slice(store.read(channel, step));
        }
        self.next = step + 1;
    }

    /// Whether no step was done yet.
    pub(super) fn is_empty(&self) -> bool {
        self.next == 0
    }

    /// The oldest step that is kept.
    fn first(&self) -> u64 {
        self.next.saturating_sub(KEPT)
    }
}

/// All steps that are done: from the log, and from the tail what is not in there yet.
pub(super) struct Past<'a> {
    pub(super) network: &'a Network,
    pub(super) tail: &'a Tail,
    pub(super) log: &'a Path,
    pub(super) recorder: &'a Recorder,
}

impl History for Past<'_> {
    fn play(&mut self, steps: Range<u64>, visit: &mut dyn FnMut(&Store, u64) -> io::Result<()>) -> io::Result<()> {
        let mut next = steps.start;
        let oldest = self.tail.first();
        if next < oldest {
            self.recorder.settle().map_err(|error| io::Error::other(error.to_string()))?;
            next = play_log(self.log, self.network, next..steps.end, visit)?;
        }
        if next < oldest {
            return Err(io::Error::other(format!("the log {} ends before step {next}", self.log.display())));
        }
        let mut store = Store::new(self.network.channels.iter().map(|channel| &channel.layout));
        for step in next..steps.end {
            let row = &self.tail.rows[(step % KEPT) as usize];
            let mut words = row.words.as_slice();
            for (index, header) in row.headers.iter().enumerate() {
                let place = store.write(ChannelId(index), step);
                let (own, rest) = words.split_at(place.len());
                place.copy_from_slice(own);
                words = rest;
                if let Some(header) = header {
                    store.stamp(ChannelId(index), step, *header);
                }
            }
            visit(&store, step)?;
        }
        Ok(())
    }
}
