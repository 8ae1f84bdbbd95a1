//! How a process takes the place of another one in a run that goes on: it goes through the steps that are done at full
//! speed, on the recorded inputs, and then takes its place at the gate where the other one is missed.

use std::env;
use std::fs::File;
use std::io::{BufReader, Read};
use std::os::fd::RawFd;

use super::seat::Seat;
use super::{adopt, refusal};
use crate::board::{ChannelReader, Hub, ServiceError};
use crate::page::{Page, Report};
use crate::{ChannelId, HEADER_BYTES, Header, Plan, Step, Store};

/// Environment variable that tells a process that it takes the place of another one, as [`Orders`] in JSON.
pub(crate) const COMEBACK: &str = "PHALANX_COMEBACK";

/// What a process does with the steps that are done when it takes the place of another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Comeback {
    /// It computes them anew on the recorded inputs, and must come to what was published, bit by bit.
    Recompute,
    /// It computes them on the recorded inputs, to have a state; what it comes to may differ: it is another program.
    Adopt,
    /// It computes nothing, neither then nor later: the last samples stand, marked as [`Stale`](crate::Status::Stale).
    Hold,
}

/// Where a process comes into a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Orders {
    pub(crate) comeback: Comeback,
    /// Number of this process among those of its worker.
    pub(crate) incarnation: u32,
    /// The steps whose samples come through the feed: from here ...
    pub(crate) first: u64,
    /// ... to here, this one not included.
    pub(crate) recorded: u64,
    /// The step at which the worker is missed ...
    pub(crate) step: u64,
    /// ... and which of the phases that it takes part in.
    pub(crate) place: usize,
    /// The reading end of the feed.
    pub(crate) feed: RawFd,
}

impl Orders {
    /// What the environment tells; `None` for a process that starts with the run.
    pub(super) fn find() -> Result<Option<Self>, String> {
        match env::var(COMEBACK) {
            Ok(text) => serde_json::from_str(&text).map(Some).map_err(|error| format!("{COMEBACK}: {error}")),
            Err(env::VarError::NotPresent) => Ok(None),
            Err(error) => Err(format!("{COMEBACK}: {error}")),
        }
    }
}

/// The samples of the steps that are done, as the recorder has them.
struct Feed {
    input: BufReader<File>,
    channels: Vec<ChannelId>,
    bytes: Vec<u8>,
}

impl Feed {
    fn open(plan: &Plan, worker: usize, orders: &Orders) -> Result<Self, Report> {
        let file = adopt(orders.feed).map_err(|error| refusal(format!("the feed cannot be used: {error}")))?;
        let input = BufReader::with_capacity(1 << 16, file.into());
        Ok(Self { input, channels: plan.traffic(worker).into_iter().collect(), bytes: Vec::new() })
    }

    /// Reads all samples of the next step into `store`.
    fn step(&mut self, plan: &Plan, store: &mut Store, step: u64) -> Result<(), Report> {
        for &channel in &self.channels {
            let words = plan.network.channels[channel.0].layout.words();
            self.bytes.resize(HEADER_BYTES + 8 * words, 0);
            let read = self.input.read_exact(&mut self.bytes);
            read.map_err(|error| refusal(format!("the recorded steps end before step {step}: {error}")))?;
            let (values, _) = self.bytes[HEADER_BYTES..].as_chunks();
            for (word, value) in store.write(channel, step).iter_mut().zip(values) {
                *word = f64::from_le_bytes(*value);
            }
            if let Some(header) = Header::from_bytes(&self.bytes) {
                store.stamp(channel, step, header);
            }
        }
        Ok(())
    }
}

/// A sample that was published before.
struct Published {
    channel: ChannelId,
    header: Option<Header>,
    words: Vec<f64>,
}

/// Goes through the steps that are done.
pub(super) fn catch_up(
    plan: &Plan,
    worker: usize,
    orders: &Orders,
    (hub, page): (&Hub, &Page),
    (seats, store): (&mut [Seat], &mut Store),
) -> Result<(), Report> {
    let mut feed = Feed::open(plan, worker, orders)?;
    let former = former_readers(plan, worker, hub, page).map_err(refusal)?;
    let channels = seats.iter().flat_map(Seat::outputs);
    let published = |channel| Published { channel, header: None, words: Vec::new() };
    let mut published: Vec<Published> = channels.map(published).collect();
    for index in orders.first..=orders.step {
        let step = Step { index, dt: plan.dt };
        let is_recorded = index < orders.recorded;
        if is_recorded {
            feed.step(plan, store, index)?;
            published.iter_mut().for_each(|published| published.note(store, index));
        }
        let places = if index == orders.step { orders.place } else { seats.len() };
        for seat in &mut seats[..places] {
            let outputs: Vec<ChannelId> = seat.outputs().collect();
            let is_own = |published: &&mut Published| outputs.contains(&published.channel);
            if !is_recorded {
                seat.fetch(plan, store, &step)?;
                for reader in former.iter().filter(|reader| outputs.contains(&reader.channel)) {
                    let fetched = reader.fetch(&plan.network, store, index);
                    fetched.map_err(|wrong| refusal(wrong.describe(&plan.network)))?;
                }
                published.iter_mut().filter(is_own).for_each(|published| published.note(store, index));
            }
            if orders.comeback != Comeback::Hold {
                seat.compute(plan, store, &step)?;
            }
            if orders.comeback == Comeback::Recompute {
                let mut own = published.iter_mut().filter(is_own);
                own.try_for_each(|published| published.check(plan, store, index))?;
            }
            // What others have read already stays as it was.
            published.iter_mut().filter(is_own).for_each(|published| published.restore(store, index));
            seat.publish(store, index);
        }
    }
    Ok(())
}

/// Readers of what the process before this one has published.
fn former_readers(plan: &Plan, worker: usize, hub: &Hub, page: &Page) -> Result<Vec<ChannelReader>, ServiceError> {
    let mut readers = Vec::new();
    for &node in &plan.workers[worker].nodes {
        if !plan.network.nodes[node].outputs.is_empty() {
            readers.extend(hub.open(&plan.network, node, page.incarnation(worker))?.readers(|_| true)?);
        }
    }
    Ok(readers)
}

impl Published {
    fn note(&mut self, store: &Store, step: u64) {
        self.header = store.header(self.channel, step).copied();
        self.words.clear();
        self.words.extend_from_slice(store.read(self.channel, step));
    }

    /// Puts it back into the store.
    fn restore(&self, store: &mut Store, step: u64) {
        if let Some(header) = self.header {
            store.write(self.channel, step).copy_from_slice(&self.words);
            store.stamp(self.channel, step, header);
        }
    }

    /// Whether what is in the store now is the same, bit by bit.
    fn check(&self, plan: &Plan, store: &Store, step: u64) -> Result<(), Report> {
        let now = store.read(self.channel, step);
        let differs = |(now, before): (&f64, &f64)| now.to_bits() != before.to_bits();
        let Some(at) = now.iter().zip(&self.words).position(differs) else { return Ok(()) };
        let channel = &plan.network.channels[self.channel.0];
        Err(refusal(format!(
            "it recomputes {} {} of step {step} as {}, but {} was published: the participant does not follow from its \
             inputs alone, so it cannot be restarted",
            channel.topic,
            channel.layout.label(at),
            now[at],
            self.words[at]
        )))
    }
}
